"""Figures as a page shows them: rows of captioned pictures, or a plot with its description."""

from __future__ import annotations

from dataclasses import dataclass

from reports.pictures import Picture, data_uri, fitted, print_jpeg
from shading_model.errors import RelightlabError

DISPLAY_WIDTH = 260
"""Pixels a panel is stored at; the page shows it no larger."""
PRINT_WIDTH = 480
"""Pixels it is printed from: 290 to the inch, four side by side on A4."""


@dataclass(frozen=True)
class Panel:
    """One picture.

    Parameters
    ----------
    source : str
        A ``data:`` address, for the page.
    width, height : int
        Pixels of it.
    printed : bytes
        The same as a JPEG, for print.
    description : str
        What is seen, for who cannot see it.
    caption : str
        Short; shown below the picture.
    note : str
        A figure that belongs to the picture, such as its error; may be empty.
    """

    source: str
    width: int
    height: int
    printed: bytes
    description: str
    caption: str
    note: str = ""


@dataclass(frozen=True)
class Scale:
    """The range of a row's signed maps: colours from ``-limit`` through 0 to ``limit``."""

    limit: float
    meaning: str


@dataclass(frozen=True)
class PanelRow:
    """Panels that belong together, under a title of their own.

    Parameters
    ----------
    title : str
    panels : tuple of Panel
    columns : int
        Panels side by side where there is room.
    scales : tuple of Scale
    """

    title: str
    panels: tuple[Panel, ...]
    columns: int
    scales: tuple[Scale, ...] = ()


@dataclass(frozen=True)
class PanelFigure:
    """Rows of panels.

    Parameters
    ----------
    identifier : str
        Unique on the page, fit for an address.
    title, caption : str
    rows : tuple of PanelRow
    """

    identifier: str
    title: str
    caption: str
    rows: tuple[PanelRow, ...]


@dataclass(frozen=True)
class PlotFigure:
    """A plot as an SVG element.

    Parameters
    ----------
    identifier : str
        Unique on the page, fit for an address.
    title, caption : str
    svg : str
    description : str
        What the plot shows, in words.
    """

    identifier: str
    title: str
    caption: str
    svg: str
    description: str


def panel(picture: Picture, description: str, caption: str, note: str = "") -> Panel:
    """Return a picture as a panel, at display size and at print size.

    Parameters
    ----------
    picture : (h, w, 4) uint8 array
    description, caption, note : str
        See `Panel`.

    Returns
    -------
    Panel

    Raises
    ------
    RelightlabError
        If the description is empty.

    Examples
    --------
    >>> import numpy as np
    >>> panel(np.zeros((4, 520, 4), np.uint8), "nothing", "empty").width
    260
    """
    if not description:
        raise RelightlabError("expected a description of the picture, got an empty one")
    small = fitted(picture, DISPLAY_WIDTH)
    height, width = small.shape[:2]
    printed = print_jpeg(fitted(picture, PRINT_WIDTH))
    return Panel(data_uri(small), width, height, printed, description, caption, note)
