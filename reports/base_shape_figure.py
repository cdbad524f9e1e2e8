"""The figure of Table 2 (`fig:shaperes`): mean errors with intervals, and every object's bars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from evaluation.base_shapes import RIVAL_SHAPES
from reports.base_shape_comparison import judged_rules
from reports.base_shape_words import (
    RULE_WORDS,
    Document,
    key_of,
    measured_shapes,
    set_words,
)
from reports.figures import PlotFigure
from reports.generic_view_figure import SHAPE_LINES
from reports.style import INK, page_svg, plot_style
from shading_model.arrays import Float

BAR_SHARE = 0.8
"""Of the room of an object, what its bars take together."""
BOUNDS = ("ground-truth", "flat")
SHORT_NAMES = 6
"""As many objects have their names written level."""


def base_shape_figure(document: Document, words: Mapping[str, str]) -> PlotFigure:
    """Return means and objects' errors as bars, a row for each rule of the published table.

    Parameters
    ----------
    document : mapping
    words : mapping of str
        What the shapes are called.

    Returns
    -------
    PlotFigure
    """
    rules, identifier = judged_rules(document), f"shaperes-{key_of(document)}"
    rivals = tuple(s for s in measured_shapes(document) if s in RIVAL_SHAPES)
    bounds = tuple(s for s in measured_shapes(document) if s in BOUNDS)
    with plot_style():
        figure = Figure(figsize=(9.6, 0.9 + 2.5 * len(rules)), layout="constrained")
        axes = figure.subplots(
            len(rules), 2, squeeze=False, sharex="col", width_ratios=[1.0, _width(document)]
        )
        for row, rule in zip(axes, rules, strict=True):
            _draw_means(row[0], document, rule, rivals, bounds)
            _draw_objects(row[1], document, rule, rivals, bounds)
        figure.legend(handles=_handles(rivals, bounds, words), loc="outside upper center", ncols=6)
        svg = page_svg(figure, identifier)
    return PlotFigure(
        identifier,
        f"Error by base shape on {set_words(document['provenance']['dataset'])}",
        "After the paper's `fig:shaperes`: default weights above, oracle weights below. Left: mean"
        " IMSE with its 95 % interval over objects, where there are two or more. Right: every"
        " object, relative to its mean squared photograph, since a dark object has a small error"
        " whatever its shape. Marks are the bounds.",
        svg,
        " ".join(_described(document, rule, words) for rule in rules),
    )


def _width(document: Document) -> float:
    """Return the width of the objects' bars over that of the means."""
    count = len({row["object"] for row in document["objects"]})
    return float(np.clip(count / 3, 1.0, 4.0))


def _draw_means(
    axis: Axes, document: Document, rule: str, rivals: Sequence[str], bounds: Sequence[str]
) -> None:
    rows = {row["shape"]: row for row in document["rows"] if row["weights"] == rule}
    for place, shape in enumerate(rivals):
        value, low, high = (_number(rows[shape][key]) for key in ("imse", "low", "high"))
        axis.bar(place, value, BAR_SHARE, color=SHAPE_LINES[shape][1])
        if np.isfinite([value, low, high]).all():
            ends = [[value - low], [high - value]]
            axis.errorbar(place, value, ends, color=INK, capsize=3, linewidth=1.2)
    for shape in bounds:
        marker, colour = SHAPE_LINES[shape]
        level = _number(rows[shape]["imse"])
        axis.plot(range(len(rivals)), [level] * len(rivals), marker, color=colour, linestyle=":")
    axis.set_title(RULE_WORDS.get(rule, rule))
    axis.set_ylabel("IMSE")
    axis.set_xticks([], [])
    axis.set_xlabel("all objects")
    axis.set_ylim(bottom=0)
    axis.grid(visible=False, axis="x")


def _draw_objects(
    axis: Axes, document: Document, rule: str, rivals: Sequence[str], bounds: Sequence[str]
) -> None:
    names = list(dict.fromkeys(row["object"] for row in document["objects"]))
    errors = _object_errors(document, rule, names)
    places = np.arange(len(names), dtype=np.float64)
    width = BAR_SHARE / max(len(rivals), 1)
    for number, shape in enumerate(rivals):
        shift = width * (number - (len(rivals) - 1) / 2)
        axis.bar(places + shift, errors[shape], width, color=SHAPE_LINES[shape][1])
    for shape in bounds:
        marker, colour = SHAPE_LINES[shape]
        axis.plot(places, errors[shape], marker, color=colour, markersize=4.0, linestyle="none")
    axis.set_ylabel("IMSE over mean I², percent")
    turn = 0 if len(names) <= SHORT_NAMES else 50
    axis.set_xticks(places, names, rotation=turn, ha="right" if turn else "center")
    if turn:
        for label in axis.get_xticklabels():
            label.set_rotation_mode("anchor")
    axis.set_xlim(-0.6, len(names) - 0.4)
    axis.set_ylim(bottom=0)
    axis.grid(visible=False, axis="x")


def _object_errors(document: Document, rule: str, names: Sequence[str]) -> dict[str, Float]:
    """Return the relative errors of objects by shape, percent, NaN where unknown."""
    found = {
        (row["shape"], row["object"]): _number(row["relative_imse"])
        for row in document["objects"]
        if row["weights"] == rule
    }
    return {
        shape: 100 * np.array([found.get((shape, name), np.nan) for name in names])
        for shape in measured_shapes(document)
    }


def _handles(
    rivals: Sequence[str], bounds: Sequence[str], words: Mapping[str, str]
) -> list[Patch | Line2D]:
    bars: list[Patch | Line2D] = [
        Patch(color=SHAPE_LINES[shape][1], label=words[shape]) for shape in rivals
    ]
    marks = [
        Line2D(
            *([], []),
            marker=SHAPE_LINES[shape][0],
            color=SHAPE_LINES[shape][1],
            linestyle="none",
            label=words[shape],
        )
        for shape in bounds
    ]
    return [*bars, *marks]


def _described(document: Document, rule: str, words: Mapping[str, str]) -> str:
    said = [
        f"{words[row['shape']]} {_in_words(row['imse'])}"
        for row in document["rows"]
        if row["weights"] == rule
    ]
    return f"{RULE_WORDS.get(rule, rule)}, mean error: {', '.join(said)}."


def _in_words(value: float | None) -> str:
    return "not measured" if value is None else f"{value:.4f}"


def _number(value: float | None) -> float:
    return np.nan if value is None else float(value)
