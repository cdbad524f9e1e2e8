"""The over-complete pyramid of heights, as the metric that it makes steps in.

A height map is the sum of levels, each half the size of the last and spread by the transpose of a
decimating filter: ``Z = Z_1 + D_1' (Z_2 + D_2' (Z_3 + ...)) = T z``. The filter is
``[1 3 3 1] / sqrt 8`` along each axis, so coarse levels weigh more by far. Quasi-Newton steps in z
are quasi-Newton steps in Z that start from the metric ``T T'``, which is all that is needed here:
unknowns stay as many as pixels.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numba import njit

from shading_model.arrays import Float

_FAST = {"reassoc", "contract", "nsz"}
_EDGE, _MIDDLE = 1.0 / math.sqrt(8.0), 3.0 / math.sqrt(8.0)


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def _decimated_rows(fine: Float, coarse: Float) -> None:  # pragma: no cover  compiled
    last = fine.shape[0] - 1
    for i in range(coarse.shape[0]):
        a, b = fine[max(2 * i - 1, 0)], fine[2 * i]
        c, d = fine[min(2 * i + 1, last)], fine[min(2 * i + 2, last)]
        out = coarse[i]
        for j in range(fine.shape[1]):
            out[j] = _EDGE * (a[j] + d[j]) + _MIDDLE * (b[j] + c[j])


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def _decimated_columns(fine: Float, coarse: Float) -> None:  # pragma: no cover  compiled
    last = fine.shape[1] - 1
    count = coarse.shape[1]
    for i in range(fine.shape[0]):
        row, out = fine[i], coarse[i]
        for j in range(count):
            a, b = row[max(2 * j - 1, 0)], row[2 * j]
            c, d = row[min(2 * j + 1, last)], row[min(2 * j + 2, last)]
            out[j] = _EDGE * (a + d) + _MIDDLE * (b + c)


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def _spread_rows(coarse: Float, fine: Float) -> None:  # pragma: no cover  compiled
    """Add the transpose of `_decimated_rows`."""
    last = fine.shape[0] - 1
    for i in range(coarse.shape[0]):
        source = coarse[i]
        a, b = fine[max(2 * i - 1, 0)], fine[2 * i]
        for j in range(fine.shape[1]):
            a[j] += _EDGE * source[j]
            b[j] += _MIDDLE * source[j]
        c, d = fine[min(2 * i + 1, last)], fine[min(2 * i + 2, last)]
        for j in range(fine.shape[1]):
            c[j] += _MIDDLE * source[j]
            d[j] += _EDGE * source[j]


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def _spread_columns(coarse: Float, fine: Float) -> None:  # pragma: no cover  compiled
    """Fill the transpose of `_decimated_columns`."""
    last = fine.shape[1] - 1
    for i in range(coarse.shape[0]):
        row, out = coarse[i], fine[i]
        out[:] = 0.0
        for j in range(coarse.shape[1]):
            out[max(2 * j - 1, 0)] += _EDGE * row[j]
            out[2 * j] += _MIDDLE * row[j]
            out[min(2 * j + 1, last)] += _MIDDLE * row[j]
            out[min(2 * j + 2, last)] += _EDGE * row[j]


def level_count(shape: tuple[int, ...]) -> int:
    """Return the number of levels of a height map: floor(log2(min(h, w))), at least one.

    Parameters
    ----------
    shape : (h, w)

    Examples
    --------
    >>> level_count((268, 379))
    8
    """
    return max(int(math.log2(min(shape))), 1)


class Pyramid:
    """The metric of height maps of one size; it holds its levels, so it serves one thread.

    Parameters
    ----------
    shape : (h, w)
    levels : int, optional
        By default `level_count`.

    Examples
    --------
    >>> step = np.empty((2, 2))
    >>> Pyramid((2, 2)).metric(np.ones((2, 2)), step)
    >>> step
    array([[1., 1.],
           [1., 1.]])
    """

    def __init__(self, shape: tuple[int, int], levels: int | None = None) -> None:
        sizes = [shape]
        for _ in range((level_count(shape) if levels is None else levels) - 1):
            rows, columns = sizes[-1]
            sizes.append((-(-rows // 2), -(-columns // 2)))
        self._levels = [np.empty(size) for size in sizes[1:]]
        self._halves = [np.empty((coarse[0], fine[1])) for fine, coarse in pairwise(sizes)]

    def metric(self, gradient: Float, step: Float) -> None:
        """Fill ``T T' g``: the step in heights of a gradient step in the pyramid's levels.

        Linear in the number of pixels.

        Parameters
        ----------
        gradient, step : (h, w) arrays
        """
        np.copyto(step, gradient)
        levels = [step, *self._levels]
        for half, (fine, coarse) in zip(self._halves, pairwise(levels), strict=True):
            _decimated_rows(fine, half)
            _decimated_columns(half, coarse)
        for half, (fine, coarse) in reversed(
            list(zip(self._halves, pairwise(levels), strict=True))
        ):
            _spread_columns(coarse, half)
            _spread_rows(half, fine)
