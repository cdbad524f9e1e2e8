"""The flow of subjects through a study: who started, who was left out and why, who remains."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from reports.figures import PlotFigure
from reports.study_figures import draw_mark
from reports.study_words import Row, counted
from reports.style import BLUE, INK, VERMILION, page_svg, plot_style

WIDTH = 9.6
MAIN, ASIDE = 0.24, 0.74
"""Middles of the column of those who remain and of those who are left out."""
BOX = 0.42
"""Half a box's share of the distance between two boxes."""
LONGEST = 58


def flow_figure(started: Row, exclusions: Sequence[Row], mark: str = "") -> PlotFigure:
    """Return the flow of subjects as boxes from above to below.

    Parameters
    ----------
    started : Row
        ``subjects`` and ``trials`` before anything was left out.
    exclusions : sequence of Row
        Steps in order, each with ``reason``, ``subjects`` and ``trials`` left out, and
        ``remaining_subjects`` and ``remaining_trials``.
    mark : str
        Drawn across the plot: the data are simulated, or a pilot's.

    Returns
    -------
    PlotFigure

    Examples
    --------
    >>> step = {"reason": "chose a cartoon", "subjects": 6, "trials": 60,
    ...         "remaining_subjects": 294, "remaining_trials": 2940}
    >>> flow_figure({"subjects": 300, "trials": 3000}, [step]).description
    '300 subjects started. Left out: 6, chose a cartoon. 294 remain.'
    """
    steps = [step for step in exclusions if step["subjects"] or step["trials"]]
    with plot_style():
        figure = Figure(figsize=(WIDTH, 0.9 + 1.1 * len(steps)), layout="constrained")
        axis = figure.subplots()
        axis.set_axis_off()
        axis.set_xlim(0, 1)
        axis.set_ylim(-2 * len(steps) - 0.7, 0.7)
        _box(axis, MAIN, 0, "started", started["subjects"], started["trials"], BLUE)
        for number, step in enumerate(steps):
            _draw_step(axis, -2 * number, step, last=number == len(steps) - 1)
        draw_mark(axis, mark)
        svg = page_svg(figure, "exclusion-flow")
    return PlotFigure(
        "exclusion-flow",
        "Who was left out",
        "The flow of subjects: each rule in its order, and how many it left out. Rules that left"
        " out nobody are in the table only.",
        svg,
        _description(started, steps),
    )


def _draw_step(axis: Axes, top: float, step: Row, *, last: bool) -> None:
    words = "analysed" if last else "remain"
    below = top - 2
    _box(axis, ASIDE, top - 1, step["reason"], step["subjects"], step["trials"], VERMILION)
    _box(axis, MAIN, below, words, step["remaining_subjects"], step["remaining_trials"], BLUE)
    arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0}
    axis.annotate("", (MAIN, below + BOX + 0.1), (MAIN, top - BOX - 0.1), arrowprops=arrow)
    axis.annotate("", (ASIDE - 0.24, top - 1), (MAIN, top - 1), arrowprops=arrow)


def _box(
    axis: Axes, x: float, y: float, words: str, subjects: int, trials: int, colour: str
) -> None:
    half = 0.18 if x == MAIN else 0.24
    corner = (x - half, y - BOX)
    axis.add_patch(
        Rectangle(corner, 2 * half, 2 * BOX, fill=False, edgecolor=colour, linewidth=1.4)
    )
    shown = words if len(words) <= LONGEST else words[: LONGEST - 1] + "…"
    axis.text(x, y + 0.16, shown, ha="center", va="center", fontweight="bold")
    counts = f"{counted(subjects, 'subject')}, {counted(trials, 'trial')}"
    axis.text(x, y - 0.2, counts, ha="center", va="center")


def _description(started: Row, steps: Sequence[Row]) -> str:
    left = "; ".join(f"{step['subjects']}, {step['reason']}" for step in steps) or "nobody"
    remain = steps[-1]["remaining_subjects"] if steps else started["subjects"]
    return f"{counted(started['subjects'], 'subject')} started. Left out: {left}. {remain} remain."
