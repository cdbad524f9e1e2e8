"""The plot of how the power of a study grows with its subjects."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from datasets.atomic import atomic_path
from reports.style import BLUE, INK, VERMILION, page_svg, plot_style, print_svg
from studies.power import PowerCurve

LOOKS = ((BLUE, "-"), (VERMILION, "--"))
"""Colour and line of the first and of the second scope."""
PANEL = (4.4, 2.5)


def power_svg(curves: Sequence[PowerCurve]) -> str:
    """Return a panel for each aim: power over subjects, in bands of 1.96 Monte-Carlo errors.

    Parameters
    ----------
    curves : sequence of PowerCurve
        Curves of one aim share a panel.

    Returns
    -------
    str
        An SVG file's text.

    Examples
    --------
    >>> from studies.power import PowerPoint
    >>> points = (PowerPoint(10, 0.3, 0.02), PowerPoint(40, 0.9, 0.01))
    >>> curve = PowerCurve("60 % against 50 %", "these scenes", points, 0.8, 30, 28, 32)
    >>> power_svg([curve])[:4]
    '<svg'
    """
    aims = list(dict.fromkeys(curve.aim for curve in curves))
    rows = -(-len(aims) // 2)
    columns = min(len(aims), 2)
    with plot_style():
        size = (columns * PANEL[0], rows * PANEL[1])
        figure = Figure(figsize=size, layout="constrained", facecolor="white")
        panels = figure.subplots(rows, columns, squeeze=False, sharey=True).ravel()
        for panel in panels[len(aims) :]:
            panel.set_visible(False)
        for panel, aim in zip(panels, aims, strict=False):
            _draw(panel, [curve for curve in curves if curve.aim == aim])
        return print_svg(page_svg(figure, "power"))


def write_power_figure(path: Path, curves: Sequence[PowerCurve]) -> None:
    """Write the plot of `power_svg`.

    Parameters
    ----------
    path : Path
    curves : sequence of PowerCurve

    Raises
    ------
    RelightlabError
        If the file cannot be written.
    """
    with atomic_path(path) as temporary:
        temporary.write_text(power_svg(curves) + "\n", encoding="utf-8")


def _draw(panel: Axes, curves: Sequence[PowerCurve]) -> None:
    for curve, (colour, line) in zip(curves, LOOKS, strict=False):
        subjects = np.array([point.subjects for point in curve.points])
        power = np.array([point.power for point in curve.points])
        reach = 1.96 * np.array([point.error for point in curve.points])
        panel.fill_between(subjects, power - reach, power + reach, color=colour, alpha=0.2, lw=0)
        panel.plot(subjects, power, line, color=colour, label=curve.scope)
        if curve.needed is not None:
            panel.plot(curve.needed, curve.wanted, "o", color=colour)
    panel.axhline(curves[0].wanted, color=INK, linestyle=":", linewidth=1)
    panel.set(xscale="log", ylim=(0, 1.02), title=curves[0].aim)
    panel.set(xlabel="subjects in each task", ylabel="power")
    panel.xaxis.set_major_formatter(ScalarFormatter())
    panel.legend(loc="best", fontsize="small")
