"""Pictures of one view under several lights: numbered eight-bit files whose values are linear.

Photometric-stereo sets store the sensor's values as they are. `datasets.image_files` takes
eight-bit values for sRGB, which is right for photographs and wrong for these.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from datasets.image_files import read_mask, read_picture
from shading_model.arrays import Float, Image, Mask, check_mask
from shading_model.errors import RelightlabError

MARGIN = 8
"""Pixels of background kept around an object's mask."""
FULL = 255


@dataclass(frozen=True, eq=False)
class PictureSeries:
    """One view under K lights.

    Parameters
    ----------
    images : (K, h, w, 3) array
        Linear, in [0, 1]; 1 is the sensor's end.
    mask : (h, w) bool array
    names : tuple of str
        The file of each picture.
    """

    images: Float
    mask: Mask
    names: tuple[str, ...]

    @property
    def mean(self) -> Image:
        """The mean picture: what the view looks like with all lights on, over their number."""
        mean: Image = self.images.mean(axis=0)
        return mean

    @property
    def saturated(self) -> Mask:
        """Where a channel of a picture is at the sensor's end, (K, h, w)."""
        full: Mask = np.asarray((self.images >= 1.0).any(axis=-1))
        return full

    def cropped(self, margin: int = MARGIN) -> PictureSeries:
        """Return the series cut to the mask and `margin` pixels around it."""
        rows, columns = box_of(self.mask, margin)
        return replace(self, images=self.images[:, rows, columns], mask=self.mask[rows, columns])


def read_series(pictures: tuple[Path, ...], mask: Path, lights: int) -> PictureSeries:
    """Return numbered pictures of one view and its mask.

    Parameters
    ----------
    pictures : tuple of Path
        Eight-bit files of linear values, in the order of their lights.
    mask : Path
    lights : int
        How many pictures there have to be.

    Returns
    -------
    PictureSeries

    Raises
    ------
    RelightlabError
        If pictures and lights differ in number, a file is missing, damaged or not of eight bits,
        or sizes differ.

    Examples
    --------
    >>> read_series((), Path("cat.mask.png"), 12)
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: there are 0 pictures beside cat.mask.png but 12 lights...
    """
    if len(pictures) != lights:
        raise RelightlabError(
            f"there are {len(pictures)} pictures beside {mask} but {lights} lights: each light"
            " needs its picture, so fetch the set again"
        )
    inside = check_mask(read_mask(mask))
    images = np.stack([_linear(path, inside.shape) for path in pictures])
    return PictureSeries(images, inside, tuple(path.name for path in pictures))


def numbered(folder: Path, before: str, suffix: str = ".png") -> tuple[Path, ...]:
    """Return the files ``<before><number><suffix>`` of a folder in the order of their numbers.

    Parameters
    ----------
    folder : Path
    before : str
        What comes before the number.
    suffix : str

    Raises
    ------
    RelightlabError
        If a number between the first and the last is missing.

    Examples
    --------
    >>> numbered(Path("no such folder"), "light")
    ()
    """
    found = {}
    for path in folder.glob(f"{before}*{suffix}"):
        number = path.name.removeprefix(before).removesuffix(suffix)
        if number.isdecimal():
            found[int(number)] = path
    missing = [k for k in range(min(found, default=0), max(found, default=0)) if k not in found]
    if missing:
        raise RelightlabError(
            f"{folder} lacks {before}{missing[0]}{suffix}, though it holds pictures of higher"
            " numbers: fetch the set again"
        )
    return tuple(found[number] for number in sorted(found))


def box_of(mask: Mask, margin: int = 0) -> tuple[slice, slice]:
    """Return the rows and columns of a mask's bounding box and a margin, within the picture.

    Parameters
    ----------
    mask : (h, w) bool array
        With at least one pixel.
    margin : int
        Pixels.

    Examples
    --------
    >>> mask = np.zeros((9, 9), bool)
    >>> mask[3, 4:6] = True
    >>> box_of(mask, 1)
    (slice(2, 5, None), slice(3, 7, None))
    """
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return _span(rows[0], rows[-1], margin), _span(columns[0], columns[-1], margin)


def _span(first: int, last: int, margin: int) -> slice:
    return slice(max(0, int(first) - margin), int(last) + 1 + margin)


def _linear(path: Path, shape: tuple[int, ...]) -> Image:
    colour = read_picture(path).colour
    if colour.dtype != np.uint8 or colour.ndim != 3:
        raise RelightlabError(f"expected an eight-bit colour picture: {path}")
    if colour.shape[:2] != shape:
        raise RelightlabError(
            f"{path} is {colour.shape[1]}x{colour.shape[0]} pixels but its mask is"
            f" {shape[1]}x{shape[0]}: they have to be of one view"
        )
    return colour / np.float64(FULL)
