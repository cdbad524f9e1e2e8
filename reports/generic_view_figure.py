"""The generic-view check (`fig:cube`) as curves: outlines of turned views, and shadows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from evaluation.generic_view_study import (
    LARGEST_TURN,
    GenericViewCurve,
    GenericViewRow,
    generic_view_curves,
)
from reports.figures import PlotFigure
from reports.style import (
    BLUE,
    GREEN,
    INK,
    ORANGE,
    PURPLE,
    RULE,
    SKY,
    VERMILION,
    page_svg,
    plot_style,
)
from shading_model.errors import RelightlabError

SHAPE_LINES = {
    "contour": ("o", VERMILION),
    "kinect": ("s", ORANGE),
    "sirfs": ("^", GREEN),
    "sirfs-stereo": ("v", BLUE),
    "ground-truth": ("D", INK),
    "flat": ("x", SKY),
}
"""Mark and colour of a base shape: either alone tells them apart."""
OTHER_LINES = (("P", PURPLE), ("X", INK), ("*", SKY))
"""Of shapes that are not the study's, in their order."""
BAND_OPACITY = 0.15


def generic_view_figure(
    rows: Sequence[GenericViewRow],
    identifier: str = "generic-view",
    words: Mapping[str, str] | None = None,
) -> PlotFigure:
    """Return both measures over the angle: the median object, and the middle half as a band.

    Parameters
    ----------
    rows : sequence of GenericViewRow
    identifier : str
        Unique on the page.
    words : mapping of str, optional
        What shapes are called, where it is not their name.

    Returns
    -------
    PlotFigure
        Outlines up to the largest turn of the paper's check; shadows at every angle of the rows.

    Raises
    ------
    RelightlabError
        If there are no rows, or as `evaluation.generic_view_study.generic_view_curves`.
    """
    near = [row for row in rows if row.angle <= LARGEST_TURN]
    if not near:
        raise RelightlabError(
            f"expected measures of views turned by up to {LARGEST_TURN:g} degrees, got none"
        )
    shifts, shares = (
        generic_view_curves(near, "outline_shift"),
        generic_view_curves(rows, "shadow_share"),
    )
    called = {curve.shape: (words or {}).get(curve.shape, curve.shape) for curve in shares}
    with plot_style():
        figure = Figure(figsize=(9.6, 3.6), layout="constrained")
        left, right = figure.subplots(1, 2)
        _draw(left, shifts, called)
        _draw(right, shares, called)
        left.set(title="outline", xlabel="view turned by, degrees")
        left.set_ylabel("outline moves by, percent of the diameter")
        right.set(title="cast shadows", xlabel="light inclined by, degrees")
        right.set_ylabel("in its own shadow, percent of the area")
        if shares[0].angles[-1] > LARGEST_TURN:
            right.axvline(LARGEST_TURN, color=RULE, linewidth=1.6)
        figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=6)
        svg = page_svg(figure, identifier)
    return PlotFigure(
        identifier,
        "The generic-view check",
        _caption(shifts),
        svg,
        " ".join(
            (
                *(_shift_words(curve, called[curve.shape]) for curve in shifts),
                *(_share_words(curve, called[curve.shape]) for curve in shares),
            )
        ),
    )


def _draw(axis: Axes, curves: Sequence[GenericViewCurve], called: Mapping[str, str]) -> None:
    others = cycle(OTHER_LINES)
    for curve in curves:
        marker, colour = SHAPE_LINES.get(curve.shape) or next(others)
        axis.fill_between(
            curve.angles,
            100 * curve.low,
            100 * curve.high,
            color=colour,
            alpha=BAND_OPACITY,
            linewidth=0,
        )
        axis.plot(
            curve.angles,
            100 * curve.median,
            marker=marker,
            color=colour,
            label=called[curve.shape],
            clip_on=False,
        )
    axis.set_xlim(0, float(np.max([curve.angles[-1] for curve in curves])) or None)
    axis.set_ylim(bottom=0)


def _caption(curves: Sequence[GenericViewCurve]) -> str:
    counts = [curve.objects for curve in curves]
    number = f"{min(counts)}" if min(counts) == max(counts) else f"{min(counts)} to {max(counts)}"
    return (
        "After the claim of the paper's `fig:cube`. Left: mean distance between the outline of the"
        " turned surface and that of the flat cut-out, which only narrows. Right: share of the"
        " object that faces a distant light but lies in a shadow the surface casts on itself; a"
        " view turned as far would not see it either. Lines are medians over the objects (number:"
        f" {number}), bands their middle half; each value is a mean over the directions of turning."
        f" The upright line, where there is one, is at {LARGEST_TURN:g} degrees."
    )


def _shift_words(curve: GenericViewCurve, name: str) -> str:
    return (
        f"Turned by {curve.angles[-1]:g} degrees, {name} moves its outline by"
        f" {_spread_words(curve, -1)} percent of the diameter."
    )


def _share_words(curve: GenericViewCurve, name: str) -> str:
    largest_turn = int(np.searchsorted(curve.angles, LARGEST_TURN, side="right")) - 1
    each = [
        f"{_spread_words(curve, place)} percent of itself at {curve.angles[place]:g} degrees"
        for place in sorted({largest_turn, len(curve.angles) - 1})
    ]
    return f"Under an inclined light, {name} casts shadows on {' and '.join(each)}."


def _spread_words(curve: GenericViewCurve, place: int) -> str:
    low, median, high = (100 * part[place] for part in (curve.low, curve.median, curve.high))
    return f"{median:.2f} (middle half {low:.2f} to {high:.2f})"
