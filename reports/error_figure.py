"""Plots of Table 1: every object's error, and the shape of the table beside the published one."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from reports.figures import PlotFigure
from reports.style import BLUE, GREEN, INK, ORANGE, RULE, VERMILION, page_svg, plot_style
from reports.subject import Subject
from reports.table1_entries import NO_RULE, Key, entry_words, has_rival, measured, published

MARKS = {
    "coarse": ("o", VERMILION),
    "regression": ("s", ORANGE),
    "oracle": ("D", BLUE),
}
"""Shape and colour of a weight rule: either alone tells them apart."""
RIVAL_MARK = ("^", GREEN)
REFERENCE = ("natural", "default", "regression")


def object_error_figure(subject: Subject) -> PlotFigure:
    """Return every object's relative error in both settings, as dots.

    Parameters
    ----------
    subject : Subject

    Returns
    -------
    PlotFigure
    """
    errors = relative_errors(subject.document)
    names = sorted(subject.objects, key=lambda name: _mean_error(errors, name), reverse=True)
    with plot_style():
        figure = Figure(figsize=(9.6, 1.3 + 0.235 * len(names)), layout="constrained")
        axes = figure.subplots(1, len(subject.settings), sharex=True, sharey=True, squeeze=False)[0]
        for axis, setting in zip(axes, subject.settings, strict=True):
            _draw_objects(axis, errors, names, setting)
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
        svg = page_svg(figure, "object-errors")
    return PlotFigure(
        "object-errors",
        "Error of every object",
        "Mean relative error of each object over the lights of the table, detail source"
        " “default”, on a logarithmic axis; the hardest object is at the top. The line joins the"
        f" three weight rules of one object{_rival_words(subject)}. All values are in the table"
        " below.",
        svg,
        _extremes(errors, names, subject.settings),
    )


def _rival_words(subject: Subject) -> str:
    return "; B+M is the SIRFS of the table" if has_rival(subject.document) else ""


def relative_errors(document: dict[str, Any]) -> dict[tuple[str, str, str], float]:
    """Return relative IMSE by (object, setting, rule) for the source ``default``.

    The rule ``none`` is B+M.

    Parameters
    ----------
    document : dict

    Returns
    -------
    dict
        NaN where there is no value.
    """
    return {
        (row["object"], row["setting"], row["weights"]): (
            np.nan if row["relative_imse"] is None else row["relative_imse"]
        )
        for row in document["objects"]
        if row["detail_source"] == "default" and row["weights"] in {*MARKS, NO_RULE}
    }


def _mean_error(errors: dict[tuple[str, str, str], float], name: str) -> float:
    own = [value for (owner, _, rule), value in errors.items() if (owner, rule) == (name, "oracle")]
    return float(np.mean(own))


def _draw_objects(
    axis: Axes, errors: dict[tuple[str, str, str], float], names: list[str], setting: str
) -> None:
    places = np.arange(len(names))[::-1]
    values = {
        rule: 100 * np.array([errors.get((name, setting, rule), np.nan) for name in names])
        for rule in (*MARKS, NO_RULE)
    }
    rival = values.pop(NO_RULE)
    stacked = np.stack(list(values.values()))
    known = np.isfinite(stacked).any(axis=0)
    ends = [reduce(stacked[:, known], axis=0) for reduce in (np.nanmin, np.nanmax)]
    axis.hlines(places[known], *ends, color=RULE, linewidth=2.2)
    for rule, (marker, colour) in MARKS.items():
        axis.plot(values[rule], places, marker, color=colour, label=rule, linestyle="none")
    if np.isfinite(rival).any():
        marker, colour = RIVAL_MARK
        axis.plot(rival, places, marker, color=colour, label="B+M", linestyle="none")
    axis.set_title(setting)
    axis.set_xlabel("IMSE over mean I², percent")
    axis.set_yticks(places, names)
    axis.set_ylim(-0.7, len(names) - 0.3)
    if not (stacked > 0).any():
        return
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.xaxis.set_major_formatter("{x:g}")
    axis.xaxis.set_minor_locator(NullLocator())


def _extremes(
    errors: dict[tuple[str, str, str], float], names: list[str], settings: tuple[str, ...]
) -> str:
    sentences = []
    for setting in settings:
        every = {name: errors.get((name, setting, "oracle"), np.nan) for name in names}
        own = {name: value for name, value in every.items() if np.isfinite(value)}
        if not own:
            continue
        low, high = min(own, key=lambda n: own[n]), max(own, key=lambda n: own[n])
        sentences.append(
            f"In the {setting} setting, relative error with oracle weights runs from"
            f" {100 * own[low]:.1f} percent ({low}) to {100 * own[high]:.1f} percent ({high})."
        )
    return " ".join(sentences)


def table_shape_figure(subject: Subject) -> PlotFigure:
    """Return our and the published entries, each table relative to its own entry `REFERENCE`.

    Parameters
    ----------
    subject : Subject

    Returns
    -------
    PlotFigure
    """
    ours, theirs = measured(subject.document), published(subject.document)
    keys = list(theirs)
    with plot_style():
        figure = Figure(figsize=(9.6, 1.0 + 0.3 * len(keys)), layout="constrained")
        axis = figure.subplots()
        _draw_shape(axis, [_relative(table, keys) for table in (theirs, ours)], keys)
        figure.legend(loc="outside upper center", ncols=2)
        svg = page_svg(figure, "table-shape")
    return PlotFigure(
        "table-shape",
        "The shape of the table, ours against the paper's",
        f"Each table divided by its own entry “{entry_words(REFERENCE)}”, which takes out the"
        " unknown scale of the lights. What then remains is the order and the proportions.",
        svg,
        "; ".join(
            f"{entry_words(key)}: published {a:.2f}, here {_in_words(b)}"
            for key, a, b in zip(keys, _relative(theirs, keys), _relative(ours, keys), strict=True)
        ),
    )


def _in_words(value: float) -> str:
    return f"{value:.2f}" if np.isfinite(value) else "not measured"


def _relative(table: dict[Key, float], keys: list[Key]) -> list[float]:
    unit = table.get(REFERENCE, np.nan)
    return [table.get(key, np.nan) / unit if unit else np.nan for key in keys]


def _draw_shape(axis: Axes, tables: list[list[float]], keys: list[Key]) -> None:
    places = np.arange(len(keys))[::-1]
    published_values, own_values = tables
    axis.hlines(places, published_values, own_values, color=RULE, linewidth=2.2)
    axis.plot(
        published_values,
        places,
        "o",
        markerfacecolor="none",
        markeredgecolor=INK,
        markeredgewidth=1.4,
        label="published",
        linestyle="none",
    )
    axis.plot(own_values, places, "D", color=BLUE, label="measured here", linestyle="none")
    axis.axvline(1.0, color=RULE, linewidth=1.0)
    axis.set_yticks(places, [entry_words(key) for key in keys])
    axis.set_xlabel(f"error over that of {entry_words(REFERENCE)}")
    axis.set_xlim(left=0)
