"""The README's picture, from the synthetic set: ``python -m reports.readme_picture [FILE]``."""

from __future__ import annotations

import io
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image as PillowImage

from datasets.atomic import atomic_path
from datasets.model_parameters import shipped_parameters
from datasets.records import Dataset
from datasets.synthetic import synthesize
from reports.pictures import (
    Picture,
    diverging_picture,
    photograph_picture,
    symmetric_limit,
    with_light,
)
from reports.style import plot_style
from reports.subject import BuiltObject, build_object
from shading_model.illumination import C2, C4, LogHarmonics
from shading_model.object_model import ModelParameters, Weights

OBJECTS = ("duck", "turtle", "pumpkin")
SETTING = "laboratory"
WEIGHTS = Weights(0.8, 0.8)
PIXELS_PER_INCH = 100
LAMPS = (
    ((-0.75, 0.5, 0.45), (0.4, 0.34, 0.26)),
    ((0.8, 0.35, 0.45), (0.32, 0.37, 0.42)),
    ((0.0, 1.0, 0.2), (0.4, 0.39, 0.38)),
)
"""Directions (x right, y up, z toward the viewer) and colours of the lights relit by."""
CONTRAST = 1.5
"""Half the log of the brightest over the darkest shading under a lamp."""
CELL = 1.71
"""Inches of one picture: seven of them make 1200 pixels."""
TITLES = ("photograph", "albedo", "coarse shading", "detail", *["relit"] * len(LAMPS))
TILE, INK = "#d3d5d3", "#1b1d21"
DEFAULT_FILE = Path(__file__).resolve().parents[1] / "docs" / "relit.png"


def write_readme_picture(
    path: str | os.PathLike[str],
    dataset: Dataset,
    parameters: ModelParameters,
    names: Sequence[str] = OBJECTS,
) -> None:
    """Write photograph, layers and relit pictures of some objects as one PNG, a row for each.

    The same arguments give the same bytes.

    Parameters
    ----------
    path : path
    dataset : Dataset
    parameters : ModelParameters
    names : sequence of str
        Objects of the dataset.

    Raises
    ------
    RelightlabError
        If a name is unknown or the file cannot be written.
    """
    lights = [lamp(direction, colour) for direction, colour in LAMPS]
    rows = [picture_row(build_object(dataset, name, SETTING, parameters), lights) for name in names]
    with atomic_path(path) as temporary, PillowImage.open(io.BytesIO(_drawn(rows))) as picture:
        picture.convert("RGB").save(temporary, "PNG", optimize=True)


def _drawn(rows: Sequence[Sequence[Picture]]) -> bytes:
    """Return rows of pictures under their titles, as a PNG."""
    inches = (CELL * len(TITLES), CELL * len(rows) + 0.3)
    with plot_style():
        figure = Figure(figsize=inches, dpi=PIXELS_PER_INCH, facecolor="white")
        figure.subplots_adjust(0.004, 0.01, 0.996, 1 - 0.28 / inches[1], 0.05, 0.05)
        axes = figure.subplots(len(rows), len(TITLES), squeeze=False)
        for row_axes, row in zip(axes, rows, strict=True):
            for axis, picture in zip(row_axes, row, strict=True):
                _show(axis, picture)
        for axis, title in zip(axes[0], TITLES, strict=True):
            axis.set_title(title, color=INK, loc="center", fontweight="normal")
        stream = io.BytesIO()
        figure.savefig(stream, format="png", facecolor="white")
        return stream.getvalue()


def lamp(direction: Sequence[float], colour: Sequence[float]) -> LogHarmonics:
    """Return a soft coloured light from a direction: ``colour * exp(CONTRAST N . d)``.

    Parameters
    ----------
    direction : three floats
        Of any length.
    colour : three floats
        Above zero.

    Returns
    -------
    LogHarmonics

    Examples
    --------
    >>> lamp((0, 0, 2), (1, 1, 1)).shade(np.array([0.0, 1.0, 0.0])).round(6).tolist()
    [1.0, 1.0, 1.0]
    """
    x, y, z = np.asarray(direction) / np.linalg.norm(direction)
    coefficients = np.zeros((9, 3))
    coefficients[0] = np.log(colour) / C4
    coefficients[1:4] = CONTRAST / (2 * C2) * np.array([[y], [z], [x]])
    return LogHarmonics(coefficients)


def picture_row(built: BuiltObject, lights: Sequence[LogHarmonics]) -> list[Picture]:
    """Return the pictures of one object in the order of `TITLES`.

    Parameters
    ----------
    built : BuiltObject
    lights : sequence of LogHarmonics

    Returns
    -------
    list of (h, w, 4) uint8 arrays
    """
    model = built.model
    image = np.where(model.mask[..., None], built.capture.photograph.image, np.nan)
    residual = model.parametric_residual
    pictures = [
        photograph_picture(image),
        photograph_picture(model.albedo),
        photograph_picture(built.parts.shading - residual),
        diverging_picture(residual, symmetric_limit(residual)),
    ]
    for light in lights:
        relit = photograph_picture(model.relight(light, WEIGHTS))
        pictures.append(with_light(relit, light))
    return pictures


def _show(axis: Axes, picture: Picture) -> None:
    side = max(picture.shape[:2])
    height, width = picture.shape[:2]
    axis.imshow(picture, interpolation="antialiased")
    axis.set_xlim(width / 2 - side / 2, width / 2 + side / 2)
    axis.set_ylim(height / 2 + side / 2, height / 2 - side / 2)
    axis.set_facecolor(TILE)
    axis.grid(visible=False)
    axis.set_xticks([])
    axis.set_yticks([])
    for spine in axis.spines.values():
        spine.set_visible(False)


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the picture of the README, of objects synthesized for it."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    path = Path(given[0]) if given else DEFAULT_FILE
    with tempfile.TemporaryDirectory() as folder:
        dataset = synthesize(folder, objects=OBJECTS)
        write_readme_picture(path, dataset, shipped_parameters())


if __name__ == "__main__":
    main()
