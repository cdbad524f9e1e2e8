"""Small objects, pictures and models that tests of several packages share."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import cv2
import numpy as np
from PIL import Image as PillowImage

from datasets.model_parameters import shipped_parameters
from shading_model.arrays import Image, Mask
from shading_model.object_model import ModelParameters, ObjectModel, build_model


@cache
def parameters() -> ModelParameters:
    """Return the shipped parameters, read once."""
    return shipped_parameters()


def disk(size: int = 40, radius: float | None = None) -> Mask:
    """Return a disk in the middle of a square picture."""
    rows, columns = np.mgrid[:size, :size] - (size - 1) / 2
    inside: Mask = np.hypot(rows, columns) < (radius or 0.4 * size)
    return inside


def painted(mask: Mask) -> Image:
    """Return a photograph of a shaded object in two colours, positive everywhere."""
    rows, columns = np.indices(mask.shape)
    shading = 0.2 + 0.6 * columns / mask.shape[1]
    paint = np.where((rows > mask.shape[0] / 2)[..., None], [0.8, 0.5, 0.3], [0.2, 0.3, 0.6])
    return paint * shading[..., None]


@cache
def disk_model() -> ObjectModel:
    """Return the model of a painted disk."""
    return build_model(painted(disk()), disk(), parameters())


def write_picture(path: Path, values: np.ndarray) -> Path:
    """Write 8-bit or 16-bit values, gray, RGB or RGBA, as they are."""
    if values.dtype == np.uint16:
        order = [2, 1, 0, 3][: values.shape[-1]] if values.ndim == 3 else ...
        stored = values[..., order] if values.ndim == 3 else values
        assert cv2.imwrite(str(path), stored)
    else:
        PillowImage.fromarray(values).save(path)
    return path


def photograph_and_mask(folder: Path, size: int = 40) -> tuple[Path, Path]:
    """Write a painted disk as an 8-bit photograph, and its mask."""
    mask = disk(size)
    levels = np.round(255 * painted(mask)).astype(np.uint8)
    photograph = write_picture(folder / "photograph.png", levels)
    return photograph, write_picture(folder / "mask.png", np.uint8(255) * mask.astype(np.uint8))
