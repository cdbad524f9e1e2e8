"""The README's picture, from the synthetic set: ``python -m reports.readme_picture [FILE]``."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image as PillowImage

from datasets.atomic import atomic_path
from datasets.environment_maps import shipped_lights
from datasets.model_parameters import shipped_parameters
from datasets.records import Dataset
from datasets.synthetic import Synthetic, synthetic_root
from reports.pictures import (
    Picture,
    diverging_picture,
    photograph_picture,
    symmetric_limit,
    with_light,
)
from reports.style import plot_style
from reports.subject import BuiltObject, build_object, varied_lights
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ModelParameters, Weights

OBJECTS = ("bear", "shell")
LIGHTS = 3
SETTING = "laboratory"
WEIGHTS = Weights(0.7, 0.7)
PIXELS_PER_INCH = 100
CELL = 1.71
"""Inches of one picture: seven of them make 1200 pixels."""
TITLES = ("photograph", "albedo", "coarse shading", "detail", *["relit"] * LIGHTS)
TILE, INK = "#d3d5d3", "#1b1d21"
DEFAULT_FILE = Path(__file__).resolve().parents[1] / "docs" / "relit.png"


def write_readme_picture(
    path: str | os.PathLike[str],
    dataset: Dataset,
    lights: Sequence[LogHarmonics],
    parameters: ModelParameters,
    names: Sequence[str] = OBJECTS,
) -> None:
    """Write photograph, layers and relit pictures of some objects as one PNG, a row for each.

    The same arguments give the same bytes.

    Parameters
    ----------
    path : path
    dataset : Dataset
    lights : sequence of LogHarmonics
        One colour each; the `LIGHTS` that differ most are used.
    parameters : ModelParameters
    names : sequence of str
        Objects of the dataset.

    Raises
    ------
    RelightlabError
        If a name is unknown or the file cannot be written.
    """
    chosen = [lights[number] for number in varied_lights(lights, LIGHTS)]
    rows = [picture_row(build_object(dataset, name, SETTING, parameters), chosen) for name in names]
    with plot_style(), atomic_path(path) as temporary:
        figure = Figure(figsize=(CELL * len(TITLES), CELL * len(rows) + 0.3), dpi=PIXELS_PER_INCH)
        figure.subplots_adjust(0.004, 0.01, 0.996, 1 - 0.28 / figure.get_figheight(), 0.05, 0.05)
        axes = figure.subplots(len(rows), len(TITLES), squeeze=False)
        for row_axes, row in zip(axes, rows, strict=True):
            for axis, picture in zip(row_axes, row, strict=True):
                _show(axis, picture)
        for axis, title in zip(axes[0], TITLES, strict=True):
            axis.set_title(title, color=INK, loc="center", fontweight="normal")
        figure.savefig(temporary, format="png", facecolor="white", metadata={"Software": None})
        _with_fewer_colours(temporary)


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


def _with_fewer_colours(path: Path) -> None:
    """Replace a PNG by one of 256 colours, a third of its size."""
    with PillowImage.open(path) as picture:
        few = picture.convert("RGB").quantize(256, dither=PillowImage.Dither.FLOYDSTEINBERG)
    few.save(path, "PNG", optimize=True)


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the picture of the README, making the synthetic set first where it is missing."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    lights = [light.monochrome() for light in shipped_lights()]
    dataset = Synthetic(synthetic_root())
    path = Path(given[0]) if given else DEFAULT_FILE
    write_readme_picture(path, dataset, lights, shipped_parameters())


if __name__ == "__main__":
    main()
