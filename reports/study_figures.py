"""Forest plots of a study: bars with two-deviation whiskers, and the intervals that are sound."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reports.figures import PlotFigure
from reports.study_words import Row, level_words, number_or_nan
from reports.style import BLUE, INK, RULE, SKY, VERMILION, page_svg, plot_style

CHANCE = 50.0
WIDTH = 9.6
BAR, OFFSET = 0.46, 0.36
"""Height of a bar, and how far from its middle the two intervals are drawn; rows are 1 apart."""
ROW_INCHES = 0.44
INTERVALS = {"wilson": ("Wilson", OFFSET, BLUE), "cluster": ("by subject", -OFFSET, VERMILION)}
CAPTION = (
    " Bars are rates with whiskers of two deviations, as the paper's: of the mean over subjects."
    " Above each bar is the Wilson interval, below it the cluster-robust one by subject, both of"
    " 95 %. The dotted line is chance."
)
PUBLISHED = " Open circles are the published rates."


@dataclass(frozen=True)
class Panel:
    """One condition of a forest plot.

    Parameters
    ----------
    title : str
    rows : sequence of Row
        Rates, from top to bottom.
    published : sequence of Row
        Published rates with the same ``group`` and ``level``, may be empty.
    """

    title: str
    rows: Sequence[Row]
    published: Sequence[Row] = ()


def forest_figure(
    identifier: str, title: str, caption: str, panels: Sequence[Panel], mark: str = ""
) -> PlotFigure:
    """Return rates of subpopulations as a forest plot, one panel for each condition.

    Parameters
    ----------
    identifier, title, caption : str
    panels : sequence of Panel
        At least one; rows that only some of them have leave a gap in the others.
    mark : str
        Drawn across every panel: the data are simulated, or a pilot's.

    Returns
    -------
    PlotFigure

    Examples
    --------
    >>> row = {"group": "all", "level": "all", "rate": 0.6, "deviation": 0.02, "trials": 600}
    >>> figure = forest_figure("plot", "Rates", "", [Panel("ours", [row])], "SIMULATED")
    >>> "SIMULATED" in figure.svg, figure.description
    (True, 'ours: all 60.0 percent.')
    """
    names = _names(panels)
    with plot_style():
        figure = Figure(
            figsize=(WIDTH, 1.15 + ROW_INCHES * max(len(names), 3)), layout="constrained"
        )
        axes = figure.subplots(1, len(panels), sharex=True, sharey=True, squeeze=False)[0]
        for axis, panel in zip(axes, panels, strict=True):
            _draw_panel(axis, panel, names, mark)
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=max(len(labels), 1))
        svg = page_svg(figure, identifier)
    circles = PUBLISHED if any(panel.published for panel in panels) else ""
    words = f"{caption}{CAPTION}{circles}".strip()
    return PlotFigure(identifier, title, words, svg, _description(panels))


def draw_mark(axis: Axes, mark: str) -> None:
    """Write a mark across a plot, so that no crop of it is without.

    Parameters
    ----------
    axis : Axes
    mark : str
        Nothing is drawn if empty.
    """
    axis.text(
        *(0.5, 0.5, mark),
        transform=axis.transAxes,
        rotation=20,
        ha="center",
        va="center",
        fontsize=30,
        fontweight="bold",
        color=VERMILION,
        alpha=0.32,
        zorder=5,
    )


def _names(panels: Sequence[Panel]) -> list[tuple[str, str]]:
    """Return group and level of every row of any panel, in the order they come."""
    found = [(row["group"], row["level"]) for panel in panels for row in panel.rows]
    return sorted(dict.fromkeys(found), key=lambda name: _first(found, name[0]))


def _first(names: Sequence[tuple[str, str]], group: str) -> int:
    return next(place for place, (own, _) in enumerate(names) if own == group)


def _draw_panel(axis: Axes, panel: Panel, names: Sequence[tuple[str, str]], mark: str) -> None:
    places = {name: len(names) - 1 - place for place, name in enumerate(names)}
    where = np.array([places[row["group"], row["level"]] for row in panel.rows])
    rates = _percent(panel.rows, "rate")
    deviations = _percent(panel.rows, "deviation")
    axis.barh(where, rates, height=BAR, color=SKY, label="rate")
    if np.isfinite(deviations).any():
        axis.errorbar(
            *(rates, where),
            xerr=2 * deviations,
            fmt="none",
            ecolor=INK,
            elinewidth=1.2,
            capsize=3,
            label="two deviations",
        )
    for key, (label, offset, colour) in INTERVALS.items():
        ends = [_percent(panel.rows, f"{key}_{end}") for end in ("low", "high")]
        if np.isfinite(ends).any():
            _draw_interval(axis, where + offset, ends, colour, label)
    _draw_published(axis, panel.published, places)
    axis.axvline(CHANCE, color=INK, linewidth=1.2, linestyle=":")
    _draw_rules(axis, names)
    axis.set_title(panel.title, wrap=True)
    axis.set_xlim(0, 100)
    axis.set_ylim(-0.75, len(names) - 0.25)
    axis.set_yticks(list(places.values()), [level_words(*name) for name in names])
    axis.set_xlabel("chosen, percent")
    axis.grid(visible=False, axis="y")
    axis.tick_params(axis="y", length=0)
    draw_mark(axis, mark)


def _draw_interval(
    axis: Axes, where: np.ndarray, ends: Sequence[np.ndarray], colour: str, label: str
) -> None:
    low, high = ends
    axis.hlines(where, low, high, color=colour, linewidth=1.6, label=label)
    for end in (low, high):
        axis.plot(end, where, "|", color=colour, markersize=5.0)


def _draw_published(axis: Axes, rows: Sequence[Row], places: dict[tuple[str, str], int]) -> None:
    shown = [row for row in rows if (row["group"], row["level"]) in places]
    if shown:
        axis.plot(
            _percent(shown, "rate"),
            [places[row["group"], row["level"]] for row in shown],
            "o",
            markerfacecolor="none",
            markeredgecolor=INK,
            markeredgewidth=1.4,
            label="published",
            linestyle="none",
        )


def _draw_rules(axis: Axes, names: Sequence[tuple[str, str]]) -> None:
    """Draw a line between two groups of rows."""
    for place in range(1, len(names)):
        if names[place][0] != names[place - 1][0]:
            axis.axhline(len(names) - place - 0.5, color=RULE, linewidth=0.6)


def _percent(rows: Sequence[Row], key: str) -> np.ndarray:
    return 100 * np.array([number_or_nan(row.get(key)) for row in rows], dtype=float)


def _description(panels: Sequence[Panel]) -> str:
    return " ".join(
        f"{panel.title}: "
        + ", ".join(
            f"{level_words(row['group'], row['level'])} {100 * number_or_nan(row['rate']):.1f}"
            for row in panel.rows
        )
        + " percent."
        for panel in panels
    )
