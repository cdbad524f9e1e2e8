"""The rectangle of a photograph that SIRFS works on, and its results put back in place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from shading_model.arrays import Float, Mask, check_image, check_mask
from shading_model.errors import RelightlabError

Values = TypeVar("Values", bound=NDArray[Any])

MARGIN = 20
"""Background kept on each side of the object, in pixels, where the photograph has it."""
FEWEST_PIXELS = 64
"""An object of fewer pixels has no shading to tell its shape from."""


@dataclass(frozen=True)
class Frame:
    """A rectangle of a photograph.

    Parameters
    ----------
    size : (h, w)
        Of the photograph.
    rows, columns : (int, int)
        First, and one past the last.
    """

    size: tuple[int, int]
    rows: tuple[int, int]
    columns: tuple[int, int]

    def cut(self, values: Values) -> Values:
        """Return the part of an (h, w, ...) array inside the frame."""
        part = np.ascontiguousarray(values[slice(*self.rows), slice(*self.columns)])
        return cast(Values, part)

    def pasted(self, values: Float) -> Float:
        """Return an (h, w, ...) array of the photograph's size, NaN outside the frame."""
        whole = np.full((*self.size, *values.shape[2:]), np.nan)
        whole[slice(*self.rows), slice(*self.columns)] = values
        return whole


def frame_around(mask: Mask, margin: int = MARGIN) -> Frame:
    """Return the rectangle around an object with a margin of background, inside the photograph.

    Parameters
    ----------
    mask : (h, w) bool array
    margin : int

    Returns
    -------
    Frame

    Examples
    --------
    >>> mask = np.zeros((50, 90), bool)
    >>> mask[10:30, 40:60] = True
    >>> frame_around(mask)
    Frame(size=(50, 90), rows=(0, 50), columns=(20, 80))
    """
    ends = []
    for axis, count in ((1, mask.shape[0]), (0, mask.shape[1])):
        inside = np.flatnonzero(mask.any(axis=axis))
        ends.append((max(int(inside[0]) - margin, 0), min(int(inside[-1]) + 1 + margin, count)))
    return Frame((mask.shape[0], mask.shape[1]), ends[0], ends[1])


def checked_photograph(image: Float, mask: Mask, channels: str) -> tuple[Float, Mask]:
    """Return a photograph in the channels that are fitted, and its valid pixels.

    Parameters
    ----------
    image : (h, w, 3) or (h, w) array
        Linear intensities.
    mask : (h, w) bool array
    channels : {"gray", "color"}

    Returns
    -------
    (h, w, c) array
        The mean of the channels for ``gray``.
    (h, w) bool array
        Where the object is above zero in every channel; there is no logarithm of zero.

    Raises
    ------
    RelightlabError
        For sizes that differ, NaN, negative or all-black pixels, or an object of fewer than
        `FEWEST_PIXELS` pixels above zero.
    """
    inside = check_mask(mask)
    checked = check_image(image, inside)
    if channels == "gray":
        checked = checked.mean(axis=-1, keepdims=True)
    with np.errstate(invalid="ignore"):
        valid: Mask = inside & (checked > 0).all(axis=-1)
    count = int(valid.sum())
    if count < FEWEST_PIXELS:
        raise RelightlabError(
            f"expected at least {FEWEST_PIXELS} pixels above zero on the object, got {count}:"
            " give a larger mask, or a photograph that is not black"
        )
    return np.where(valid[..., None], checked, 0.0), valid
