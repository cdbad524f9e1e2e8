"""An ordinary photograph and its mask, made ready for a model.

A large photograph is cropped to its object, and an object of too many pixels is reduced by a whole
factor, so that time and memory stay bounded.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets.image_files import FilePath, Picture, linearised, read_mask, read_picture
from datasets.records import Photograph
from shading_model.arrays import Image, Mask, check_image, check_mask
from shading_model.errors import RelightlabError

MAX_PIXELS = 1_000_000
"""Object pixels that a model is built from at most: about 15 s and 1.3 GB."""
MARGIN = 4
"""Background kept on each side of a cropped object, in pixels."""
MOST_SATURATED = 0.01
"""Share of saturated pixels that is passed over in silence."""

_STRIP = 64
"""Rows of the reduced picture made at once."""


def load_photograph(
    path: FilePath, mask_path: FilePath | None = None, *, max_pixels: int = MAX_PIXELS
) -> tuple[Photograph, str | None]:
    """Return a photograph with its mask, and a sentence about what was cropped or reduced.

    The photograph keeps its size unless it has more than `max_pixels` pixels; then it is cropped
    to the object and a margin of `MARGIN` pixels. If the object itself has more pixels, it is
    reduced by the smallest whole factor that brings it below: intensities are averaged, linear,
    over the object's pixels only, so that no background bleeds in.

    Parameters
    ----------
    path : path
        An 8-bit (sRGB) or 16-bit (linear) picture, gray or RGB.
    mask_path : path, optional
        A picture of the same size; by default the photograph's alpha channel is the mask.
    max_pixels : int
        At least 1.

    Returns
    -------
    photograph : Photograph
        Named after the file.
    notice : str or None
        One sentence, None if the photograph was taken as it is.

    Raises
    ------
    RelightlabError
        If a file cannot be read, there is no mask, it is empty or of another size, or the object
        is black all over.
    """
    if max_pixels < 1:
        raise RelightlabError(f"expected at least one pixel to build from, got {max_pixels}")
    picture = read_picture(path)
    mask = _mask_for(picture, path, mask_path)
    frame = _frame_for(mask, max_pixels)
    image, kept = _reduced(picture.colour[frame.region], mask[frame.region], frame.factor)
    photograph = Photograph(check_image(image, kept), kept, Path(path).stem, str(path))
    return photograph, frame.notice(mask.shape)


def saturation_notice(photograph: Photograph) -> str | None:
    """Return a sentence if much of the object is saturated, else None.

    Parameters
    ----------
    photograph : Photograph

    Returns
    -------
    str or None

    Examples
    --------
    >>> saturation_notice(Photograph(np.ones((2, 2, 3)), np.ones((2, 2), bool), "white", ""))
    '100 % of the object is saturated: shading and colour are lost there'
    """
    share = float((photograph.image[photograph.mask] >= 1.0).any(axis=-1).mean())
    if share <= MOST_SATURATED:
        return None
    return f"{100 * share:.0f} % of the object is saturated: shading and colour are lost there"


@dataclass(frozen=True)
class _Frame:
    """The part of a photograph that is used, and the factor it is reduced by."""

    rows: tuple[int, int]
    columns: tuple[int, int]
    factor: int

    @property
    def region(self) -> tuple[slice, slice]:
        return slice(*self.rows), slice(*self.columns)

    def notice(self, size: tuple[int, ...]) -> str | None:
        parts = []
        if (self.rows, self.columns) != ((0, size[0]), (0, size[1])):
            parts.append(
                f"cropped to rows {self.rows[0]} to {self.rows[1] - 1} and columns"
                f" {self.columns[0]} to {self.columns[1] - 1} of the photograph"
            )
        if self.factor > 1:
            parts.append(f"built at 1/{self.factor} of the photograph's resolution")
        return " and ".join(parts) or None


def _mask_for(picture: Picture, path: FilePath, mask_path: FilePath | None) -> Mask:
    if mask_path is not None:
        mask = read_mask(mask_path)
    elif picture.opaque is None or picture.opaque.all():
        why = "has no alpha channel" if picture.opaque is None else "is opaque everywhere"
        raise RelightlabError(f"{path} {why}, so it holds no mask: give a mask with --mask")
    else:
        mask = picture.opaque
    size = picture.colour.shape
    if mask.shape != size[:2]:
        raise RelightlabError(
            f"the photograph {path} is {size[1]}x{size[0]} pixels but its mask"
            f" {mask.shape[1]}x{mask.shape[0]}: give a mask of the photograph's size"
        )
    return check_mask(mask)


def _frame_for(mask: Mask, max_pixels: int) -> _Frame:
    if mask.size <= max_pixels:
        return _Frame((0, mask.shape[0]), (0, mask.shape[1]), 1)
    rows, columns = (_extent(mask, axis) for axis in (1, 0))
    return _Frame(rows, columns, math.ceil(math.sqrt(int(mask.sum()) / max_pixels)))


def _extent(mask: Mask, axis: int) -> tuple[int, int]:
    inside = np.flatnonzero(mask.any(axis=axis))
    last = mask.shape[1 - axis]
    return max(int(inside[0]) - MARGIN, 0), min(int(inside[-1]) + 1 + MARGIN, last)


def _reduced(colour: NDArray[Any], mask: Mask, factor: int) -> tuple[Image, Mask]:
    """Average blocks of `factor` squared pixels, strip by strip to bound the memory."""
    if factor == 1:
        return linearised(colour), mask
    height, width = (-(-size // factor) for size in mask.shape)
    image, kept = np.zeros((height, width, 3)), np.zeros((height, width), bool)
    for first in range(0, height, _STRIP):
        rows = slice(first * factor, (first + _STRIP) * factor)
        inside = mask[rows, :, None].astype(np.float64)
        counts = _block_sums(inside, factor, width)[..., 0]
        sums = _block_sums(linearised(colour[rows]) * inside, factor, width)
        strip = slice(first, first + len(counts))
        kept[strip] = counts >= factor**2 / 2
        image[strip] = sums / np.maximum(counts, 1.0)[..., None]
    return image, check_mask(kept)


def _block_sums(values: Image, factor: int, width: int) -> Image:
    missing = -values.shape[0] % factor, width * factor - values.shape[1]
    padded = np.pad(values, ((0, missing[0]), (0, missing[1]), (0, 0)))
    blocks = padded.reshape(-1, factor, width, factor, values.shape[-1])
    sums: Image = blocks.sum(axis=(1, 3))
    return sums
