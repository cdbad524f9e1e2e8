"""Plots of what the order of a study does: the side of a picture, and the half of a session."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reports.figures import PlotFigure
from reports.study_figures import CHANCE, WIDTH, draw_mark
from reports.study_words import Row, condition_words, number_or_nan
from reports.style import BLUE, INK, RULE, VERMILION, page_svg, plot_style

GROUPS = {"side": "own picture on this side", "half": "half of the session"}
"""Groups of two levels that are drawn, with the titles of their panels."""
LOOKS = (("o", BLUE, 0.14), ("D", VERMILION, -0.14))
"""Mark, colour and height above the row of the first and of the second level."""


def order_figure(rates: Iterable[Row], mark: str = "") -> PlotFigure | None:
    """Return the rates by side and by half of every condition, joined in pairs.

    Parameters
    ----------
    rates : iterable of Row
        Those of the groups ``side`` and ``half`` are drawn.
    mark : str
        Drawn across every panel: the data are simulated, or a pilot's.

    Returns
    -------
    PlotFigure or None
        None where no rate has a side or a half.
    """
    pairs = {group: _pairs(rates, group) for group in GROUPS}
    shown = {group: found for group, found in pairs.items() if found}
    if not shown:
        return None
    names = list(dict.fromkeys(name for found in shown.values() for name in found))
    with plot_style():
        figure = Figure(figsize=(WIDTH, 1.3 + 0.5 * max(len(names), 2)), layout="constrained")
        axes = figure.subplots(1, len(shown), sharex=True, sharey=True, squeeze=False)[0]
        for axis, (group, found) in zip(axes, shown.items(), strict=True):
            _draw(axis, group, found, names)
            draw_mark(axis, mark)
        svg = page_svg(figure, "side-and-half")
    return PlotFigure(
        "side-and-half",
        "Side and half",
        "The same rate when the own picture was on the left and on the right, and in the first and"
        " the second half of a session, with 95 % intervals by subject. A gap on the left is a"
        " preference for a side, which balanced schedules cancel; a gap on the right is learning"
        " or fatigue. The dotted line is chance.",
        svg,
        " ".join(_sentences(shown)),
    )


def _pairs(rates: Iterable[Row], group: str) -> dict[str, list[Row]]:
    """Return the rows of two levels by condition."""
    found: dict[str, list[Row]] = {}
    for row in rates:
        if row["group"] == group and row["rate"] is not None:
            found.setdefault(condition_words(row["task"], row["condition"]), []).append(row)
    return {name: rows for name, rows in found.items() if len(rows) == len(LOOKS)}


def _draw(axis: Axes, group: str, found: Mapping[str, Sequence[Row]], names: Sequence[str]) -> None:
    places = {name: len(names) - 1 - place for place, name in enumerate(names)}
    labels = [row["level"] for row in next(iter(found.values()))]
    for number, (marker, colour, above) in enumerate(LOOKS):
        rows = [found[name][number] for name in found]
        where = np.array([places[name] for name in found]) + above
        low, rate, high = (
            100 * np.array([number_or_nan(row[key]) for row in rows])
            for key in ("cluster_low", "rate", "cluster_high")
        )
        axis.hlines(where, low, high, color=colour, linewidth=1.6)
        axis.plot(rate, where, marker, color=colour, label=labels[number], linestyle="none")
    axis.axvline(CHANCE, color=INK, linewidth=1.2, linestyle=":")
    axis.set_yticks(list(places.values()), list(places))
    axis.set_ylim(-0.6, len(names) - 0.4)
    axis.set_xlabel("chosen, percent")
    axis.grid(visible=False, axis="y")
    axis.tick_params(axis="y", length=0, color=RULE)
    axis.set_title(GROUPS[group], pad=22)
    axis.legend(loc="lower left", bbox_to_anchor=(-0.02, 0.98), ncols=2, handletextpad=0.1)


def _sentences(shown: Mapping[str, Mapping[str, Sequence[Row]]]) -> Iterable[str]:
    for group, found in shown.items():
        for name, rows in found.items():
            values = " and ".join(f"{100 * row['rate']:.1f} ({row['level']})" for row in rows)
            yield f"{name} by {group}: {values} percent."
