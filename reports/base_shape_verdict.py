"""What a measured Table 2 says of the paper's finding about base shapes, from the numbers.

The finding (`subsec:shapestudy`): the contour shape is not the barrier, as Kinect and SIRFS do not
outperform it, and SIRFS-stereo is clearly better.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from evaluation.base_shapes import RIVAL_SHAPES
from reports.base_shape_comparison import (
    ALIKE_BY_MEAN,
    BELOW,
    BELOW_BY_MEAN,
    LEVEL,
    SAME,
    Comparison,
    Document,
    can_decide,
    compared,
    judged_rules,
    least_p,
    measured_objects,
    p_words,
)
from reports.table1_verdict import Finding

NUMBERS = {1: "one object", 2: "two objects", 3: "three objects"}


def shape_findings(document: Document, words: Mapping[str, str]) -> tuple[Finding, ...]:
    """Return the parts of the paper's finding, and under how many of its rules each holds.

    Parameters
    ----------
    document : mapping
    words : mapping of str
        What the shapes are called.

    Returns
    -------
    tuple of Finding
        Contour against Kinect, contour against SIRFS, SIRFS-stereo against contour.
    """
    rules = judged_rules(document)

    def against(first: str, second: str) -> list[Comparison]:
        every = (compared(document, first, second, rule) for rule in rules)
        return [one for one in every if one is not None]

    return (
        *(
            _finding(
                f"The contour shape is not worse than {words[rival]}",
                against("contour", rival),
                {BELOW, SAME, BELOW_BY_MEAN, ALIKE_BY_MEAN},
            )
            for rival in ("kinect", "sirfs")
        ),
        _finding(
            "SIRFS-stereo is clearly better than the contour shape",
            against("sirfs-stereo", "contour"),
            {BELOW, BELOW_BY_MEAN},
        ),
    )


def verdict_words(document: Document, findings: Iterable[Finding]) -> str:
    """Return in one sentence whether the paper's finding holds.

    Parameters
    ----------
    document : mapping
    findings : iterable of Finding
        Of `shape_findings`.

    Returns
    -------
    str
    """
    *rivals, stereo = findings
    barrier = Finding(
        "", sum(one.held for one in rivals), sum(one.compared for one in rivals), ""
    ).state
    objects = measured_objects(document)
    parts = {
        "That the contour shape is not the barrier": barrier,
        "that SIRFS-stereo is clearly better": stereo.state,
    }
    said = "; ".join(
        f"{what} {{{'was not measured' if state == 'not measured' else state}}}"
        for what, state in parts.items()
    )
    return f"{said}. Measured on {objects} object{'' if objects == 1 else 's'}."


def significance_words(document: Document) -> str:
    """Return what rank tests say of all shapes together, or why they say nothing.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    str
    """
    objects, rules = measured_objects(document), judged_rules(document)
    pairs = len({(row["first"], row["second"]) for row in document["pairs"]})
    if not pairs:
        return "Fewer than two of the paper's shapes were measured, so none can be compared."
    if not can_decide(document):
        number = NUMBERS.get(objects, f"{objects} objects")
        return (
            f"{{No test is possible}}: with {number}, the p of Wilcoxon's test after Holm's"
            f" correction cannot fall below {least_p(objects, pairs):.2g}, whatever the errors."
            " What is said here rests on the means alone, which are called alike within a tenth."
        )
    friedman = [
        f"{row['weights']} p {p_words(row['p'])}"
        for row in document["tests"]
        if row["weights"] in rules
    ]
    if not friedman:
        return "Friedman's test needs three of the paper's shapes, and fewer were measured."
    return (
        "Friedman's test, that all shapes do alike by relative error over"
        f" {objects} objects: {', '.join(friedman)}. Pairs are told apart by Wilcoxon's test at"
        f" {LEVEL:g} after Holm's correction."
    )


def gap_words(document: Document, words: Mapping[str, str]) -> str:
    """Return how much of the way from the flat to the true shape each shape goes; may be empty.

    Parameters
    ----------
    document : mapping
    words : mapping of str

    Returns
    -------
    str
    """
    said = [text for rule in judged_rules(document) if (text := _gap(document, words, rule))]
    if not said:
        return ""
    return (
        f"From the error of the flat shape (0 %) to that of {words['ground-truth']} (100 %):"
        f" {'; '.join(said)}."
    )


def _gap(document: Document, words: Mapping[str, str], weights: str) -> str:
    means = {row["shape"]: row["imse"] for row in document["rows"] if row["weights"] == weights}
    flat, true = means.get("flat"), means.get("ground-truth")
    if flat is None or true is None or not flat > true:
        return ""
    shares = [
        f"{words[shape]} {100 * (flat - means[shape]) / (flat - true):.0f} %"
        for shape in RIVAL_SHAPES
        if means.get(shape) is not None
    ]
    return f"with {weights} weights, {', '.join(shares)}" if shares else ""


def _finding(statement: str, comparisons: list[Comparison], holding: set[str]) -> Finding:
    held = sum(one.word in holding for one in comparisons)
    return Finding(statement, held, len(comparisons), "; ".join(c.evidence for c in comparisons))
