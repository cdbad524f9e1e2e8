"""Compiled kernels of colour log albedo: linear maps of its channels."""

from __future__ import annotations

from numba import njit

from evaluation.sirfs.regions import Runs
from shading_model.arrays import Float

_FAST = {"reassoc", "contract", "nsz"}


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def mixed_channels(
    values: Float, matrix: Float, runs: Runs, mixed: Float
) -> None:  # pragma: no cover  compiled
    """Fill ``mixed = values @ matrix`` over the channels, on runs.

    Parameters
    ----------
    values : (3, h, w) array
    matrix : (3, 3) array
    runs : (r, 3) array
    mixed : (3, h, w) array
    """
    for k in range(runs.shape[0]):
        i, start, stop = runs[k, 0], runs[k, 1], runs[k, 2]
        red, green = values[0, i, start:stop], values[1, i, start:stop]
        blue = values[2, i, start:stop]
        for c in range(3):
            a, b, d = matrix[0, c], matrix[1, c], matrix[2, c]
            out = mixed[c, i, start:stop]
            for j in range(stop - start):
                out[j] = a * red[j] + b * green[j] + d * blue[j]


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def add_mixed_channels(
    values: Float, matrix: Float, scale: float, runs: Runs, total: Float
) -> None:  # pragma: no cover  compiled
    """Add ``scale * values @ matrix`` over the channels, on runs.

    Parameters
    ----------
    values : (3, h, w) array
    matrix : (3, 3) array
    scale : float
    runs : (r, 3) array
    total : (3, h, w) array
    """
    for k in range(runs.shape[0]):
        i, start, stop = runs[k, 0], runs[k, 1], runs[k, 2]
        red, green = values[0, i, start:stop], values[1, i, start:stop]
        blue = values[2, i, start:stop]
        for c in range(3):
            a, b, d = scale * matrix[0, c], scale * matrix[1, c], scale * matrix[2, c]
            out = total[c, i, start:stop]
            for j in range(stop - start):
                out[j] += a * red[j] + b * green[j] + d * blue[j]
