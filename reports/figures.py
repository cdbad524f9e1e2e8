"""Figures as a page shows them: rows of captioned pictures, or a plot with its description."""

from __future__ import annotations

from dataclasses import dataclass

from reports.pictures import Picture, data_uri, fitted
from shading_model.errors import RelightlabError

DISPLAY_WIDTH = 260
"""Pixels a panel is stored at; the page shows it no larger."""


@dataclass(frozen=True)
class Panel:
    """One picture.

    Parameters
    ----------
    source : str
        A ``data:`` address.
    width, height : int
        Pixels.
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
    """Return a picture as a panel, at display size.

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
    return Panel(data_uri(small), width, height, description, caption, note)
