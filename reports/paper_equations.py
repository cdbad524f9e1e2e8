"""The equations that a reader of the results needs, as typst, as MathML and in words."""

from __future__ import annotations

from reports.content import Block, Equation


def _mo(sign: str) -> str:
    return f"<mo>{sign}</mo>"


def _row(*parts: str) -> str:
    return f"<mrow>{''.join(parts)}</mrow>"


def _mi(letter: str) -> str:
    return f"<mi>{letter}</mi>"


def _name(word: str) -> str:
    return f"<mi>{word}</mi><mo>&#x2061;</mo>"


def _sub(base: str, index: str) -> str:
    return f"<msub><mi>{base}</mi><mi>{index}</mi></msub>"


def _squared(*inside: str) -> str:
    bars = '<mo fence="true">‖</mo>'
    return f"<msup><mrow>{bars}{''.join(inside)}{bars}</mrow><mn>2</mn></msup>"


_W = _sub("w", "p") + _sub("S", "p") + _mo("+") + _sub("w", "g") + _sub("S", "g")
_MODEL = _row(
    *(_mi("S"), _mo("("), _mi("Z"), _mo(","), _sub("S", "p"), _mo(","), _sub("S", "g")),
    *(_mo(";"), _mi("L"), _mo(","), _mi("w"), _mo(")"), _mo("="), _name("shade"), _mo("(")),
    *(_mi("Z"), _mo(","), _mi("L"), _mo(")"), _mo("+"), _W),
)
_BOLD = '<mi mathvariant="normal" class="vector">N</mi>'
_NORMAL = _row(
    f"<munder><mi>min</mi>{_mi('N')}</munder>",
    f"<munder><mo>∑</mo>{_mi('Ω')}</munder>",
    *(_squared(_mo("∇"), _BOLD), _mo("+"), "<msup><mrow>", _mo("("), _squared(_BOLD)),
    *(_mo("-"), "<mn>1</mn>", _mo(")"), "</mrow><mn>2</mn></msup>"),
    *("<mspace width='1em'></mspace><mtext>subject to</mtext><mspace width='1em'></mspace>",),
    *("<msubsup><mi>N</mi><mi>z</mi><mi>i</mi></msubsup>", _mo("="), "<mn>0</mn>"),
    *("<mspace width='1em'></mspace>", _mo("∀"), _mi("i"), _mo("∈"), _mo("∂"), _mi("Ω")),
)
_ERROR = _row(
    "<msubsup><mi>IMSE</mi><mi>rerender</mi><mo>&#x2032;</mo></msubsup>",
    *(_mo("="), "<mfrac><mn>1</mn><mi>n</mi></mfrac>"),
    _squared(
        *(_mi("I"), _mo("-"), _mi("k"), f"<mover>{_mi('A')}<mo>^</mo></mover>"),
        *(_name("ReShade"), _mo("("), _mi("S"), _mo("("), _mi("L"), _mo(")"), _mo(",")),
        *(_mi("w"), _mo(")")),
    ),
)

EQUATIONS: tuple[Block, ...] = (
    Equation(
        "eq:model",
        "The relit shading is the coarse shading of the shape Z under the light L plus two detail"
        " layers taken from the photograph, the parametric residual S_p and the geometric detail"
        " S_g, each with a weight:",
        'S(Z, S_p, S_g; L, w) = op("shade")(Z, L) + w_p S_p + w_g S_g',
        _MODEL,
        "S of Z, S p, S g, L and w equals shade of Z and L, plus w p times S p, plus w g times S g",
    ),
    Equation(
        "eq:normal",
        "The coarse shape comes from the contour alone: the smoothest field of unit normals that"
        " lie in the picture plane on the boundary, where they are also held to the outward"
        " contour normal:",
        'min_N sum_Omega norm(nabla bold(N))^2 + (norm(bold(N))^2 - 1)^2 quad "subject to" quad'
        " N_z^i = 0 quad forall i in partial Omega",
        _NORMAL,
        "minimum over N of the sum over Omega of the squared norm of the gradient of N plus the"
        " square of the squared norm of N minus one, subject to N z equal to zero for every i on"
        " the boundary of Omega",
    ),
    Equation(
        "eq:MSEmetric",
        "A relit picture is compared with the true one, I, over the n pixels of the mask, up to one"
        " factor k for each light:",
        'op("IMSE")\'_"rerender" = 1/n norm(I - k hat(A) op("ReShade")(S(L), w))^2',
        _ERROR,
        "IMSE prime equals one over n times the squared norm of I minus k times A hat times"
        " ReShade of S of L and w",
    ),
)
