"""The one style of all plots: colours that colour-blind readers tell apart, and plain SVG."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

ORANGE, SKY, GREEN, BLUE = "#e69f00", "#56b4e9", "#009e73", "#0072b2"
VERMILION, PURPLE = "#d55e00", "#cc79a7"
"""The palette of Okabe and Ito (2008)."""

INK, RULE = "#010203", "#010204"
"""Stand-ins that `page_svg` turns into the page's own colours, so that plots follow dark mode."""

_PAGE_COLOURS = {INK: "currentColor", RULE: "var(--rule)"}
_PRINT_COLOURS = {"currentColor": "#1b1d21", "var(--rule)": "#c9ccd1", "inherit": "DejaVu Sans"}
_SETTINGS: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "relightlab",
    "font.family": "sans-serif",
    "font.size": 9.0,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": RULE,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": RULE,
    "grid.linewidth": 0.6,
    "xtick.color": RULE,
    "xtick.labelcolor": INK,
    "ytick.color": RULE,
    "ytick.labelcolor": INK,
    "lines.markersize": 5.5,
    "legend.frameon": False,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
}


@contextmanager
def plot_style() -> Iterator[None]:
    """Hold the house's plot style while a figure is drawn and written.

    Yields
    ------
    None

    Examples
    --------
    >>> with plot_style():
    ...     mpl.rcParams["svg.fonttype"]
    'none'
    """
    with mpl.rc_context(_SETTINGS):
        yield


def page_svg(figure: Figure, identifier: str) -> str:
    """Return a figure as an SVG element that takes its text and rule colours from the page.

    Drawn twice, a figure gives the same text: no date, salted identifiers. Text stays text.

    Parameters
    ----------
    figure : Figure
        Drawn under `plot_style`.
    identifier : str
        Put before every identifier inside, so that two plots can share a page.

    Returns
    -------
    str
        ``<svg ...>...</svg>``, hidden from assistive technology: the page describes it in words.
    """
    stream = io.StringIO()
    figure.savefig(stream, format="svg", metadata=dict.fromkeys(_METADATA))
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="', f'id="{identifier}-', text)
    text = re.sub(r'(href="|url\()#', rf"\1#{identifier}-", text)
    # Namespaces are implied inside HTML, and the page holds no address that looks like a link.
    text = re.sub(r'\sxmlns(:xlink)?="[^"]*"', "", text).replace("xlink:href", "href")
    for stand_in, colour in _PAGE_COLOURS.items():
        text = text.replace(stand_in, colour)
    text = text.replace("sans-serif", "inherit").replace("<svg ", '<svg aria-hidden="true" ', 1)
    return text.rstrip()


def print_svg(svg: str) -> str:
    """Return a plot of `page_svg` as a file of its own, in the colours and font of print.

    Parameters
    ----------
    svg : str

    Returns
    -------
    str

    Examples
    --------
    >>> print_svg('<svg aria-hidden="true" width="1pt"></svg>')
    '<svg xmlns="http://www.w3.org/2000/svg" width="1pt"></svg>'
    """
    for colour, printed in _PRINT_COLOURS.items():
        svg = svg.replace(colour, printed)
    return svg.replace('aria-hidden="true"', 'xmlns="http://www.w3.org/2000/svg"', 1)


_METADATA = ("Date", "Creator", "Format", "Type")
