"""Where the terms of the loss are summed: runs of valid pixels, pairs of neighbours, the outline.

A run is (row, first column, one past the last column). Kernels go along runs, so that their inner
loops are contiguous whatever the mask looks like.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion, correlate, generate_binary_structure

from shading_model.arrays import Float, Mask

Runs: TypeAlias = NDArray[np.int64]
"""(r, 3) array: row, start, stop."""

PAIR_OFFSETS = ((0, 1), (0, 2), *((row, column) for row in (1, 2) for column in range(-2, 3)))
"""Offsets (row, column) of the second pixel of a pair: half of a 5 x 5 window."""
OUTLINE_MARGIN = 5
"""Outline pixels nearer than this to the picture's edge are left out: the object is cut there."""
_WINDOW = 5


def runs_of(mask: Mask) -> Runs:
    """Return the runs of a mask, row by row.

    Parameters
    ----------
    mask : (h, w) bool array

    Returns
    -------
    (r, 3) array

    Examples
    --------
    >>> runs_of(np.array([[True, True, False, True]]))
    array([[0, 0, 2],
           [0, 3, 4]])
    """
    padded = np.pad(np.asarray(mask, dtype=np.int8), ((0, 0), (1, 1)))
    change = np.diff(padded, axis=1)
    rows, starts = np.nonzero(change == 1)
    stops = np.nonzero(change == -1)[1]
    return np.stack([rows, starts, stops], axis=-1).astype(np.int64)


def pair_runs(mask: Mask) -> Runs:
    """Return the runs of first pixels of all pairs whose two pixels are in the mask.

    Parameters
    ----------
    mask : (h, w) bool array

    Returns
    -------
    (r, 5) array
        Row, start, stop, and the offset (row, column) to the second pixel.

    Examples
    --------
    >>> pair_runs(np.ones((1, 3), bool))
    array([[0, 0, 2, 0, 1],
           [0, 0, 1, 0, 2]])
    """
    inside = np.asarray(mask, dtype=bool)
    found = []
    for down, right in PAIR_OFFSETS:
        runs = runs_of(inside & _shifted(inside, down, right))
        offsets = np.broadcast_to(np.array([down, right]), (len(runs), 2))
        found.append(np.concatenate([runs, offsets], axis=1))
    together = np.concatenate(found).astype(np.int64)
    # By rows, so that what a kernel has in the cache serves all offsets.
    return together[np.lexsort(together.T[[1, 4, 3, 0]])]


def _shifted(mask: Mask, down: int, right: int) -> Mask:
    """Return at each pixel the mask at (row + down, column + right), False outside."""
    height, width = mask.shape
    shifted = np.zeros_like(mask)
    rows = slice(0, max(height - down, 0))
    if right >= 0:
        shifted[rows, : max(width - right, 0)] = mask[down:, right:]
    else:
        shifted[rows, -right:] = mask[down:, :right]
    return shifted


@dataclass(frozen=True, eq=False)
class Outline:
    """Pixels on an object's outline with the directions that point out of it.

    Parameters
    ----------
    rows, columns : (m,) int arrays
    outward : (m, 2) array
        Unit vectors (x right, y up).
    """

    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    outward: Float


def outline_of(mask: Mask) -> Outline:
    """Return the outline of a mask; the whole silhouette counts as an occluding contour.

    Pixels with a 4-neighbour outside the mask, at least `OUTLINE_MARGIN` from the picture's edge.
    Outward is away from the weighted centroid of the object in an 11 x 11 window.

    Parameters
    ----------
    mask : (h, w) bool array

    Returns
    -------
    Outline
        Empty for an object that meets the edge all around.

    Examples
    --------
    >>> y, x = np.mgrid[-15:16, -15:16]
    >>> outline = outline_of(np.hypot(x, y) < 8)
    >>> at = list(zip(outline.rows, outline.columns)).index((15, 22))
    >>> outline.outward[at].round(6) + 0.0
    array([1., 0.])
    """
    inside = np.asarray(mask, dtype=bool)
    cross = generate_binary_structure(2, 1)
    border = inside & ~binary_erosion(inside, cross, border_value=1)
    margin = OUTLINE_MARGIN
    kept = np.zeros_like(border)
    kept[margin:-margin, margin:-margin] = border[margin:-margin, margin:-margin]
    away = _away_from_centroid(inside)[kept]
    length = np.linalg.norm(away, axis=-1, keepdims=True)
    rows, columns = np.nonzero(kept)
    known = length[:, 0] > 0
    outward = np.divide(away, length, out=np.zeros_like(away), where=length > 0)
    return Outline(rows[known].astype(np.int64), columns[known].astype(np.int64), outward[known])


def _away_from_centroid(mask: Mask) -> Float:
    down, right = np.mgrid[-_WINDOW : _WINDOW + 1, -_WINDOW : _WINDOW + 1]
    weights = np.exp(-_WINDOW * (down**2 + right**2) / _WINDOW**2)
    weight = np.asarray(mask, dtype=np.float64)
    to_right, to_below = (
        correlate(weight, weights * step, mode="constant") for step in (right, down)
    )
    # Up is minus down, and away is minus toward.
    return np.stack([-to_right, to_below], axis=-1)
