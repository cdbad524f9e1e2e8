"""Compiled kernels of the histogram of log albedo: splat, and the gradient of a potential.

Knots lie evenly; a value is shared between the knots around it (linear, or trilinear in colour).
Values beyond the last knots count at them and have no gradient.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from evaluation.sirfs.regions import Runs
from shading_model.arrays import Float


@njit(cache=True, error_model="numpy")
def splat(
    values: Float, runs: Runs, first: float, spacing: float, histogram: Float
) -> None:  # pragma: no cover  compiled
    """Add the values of runs to a histogram.

    Parameters
    ----------
    values : (h, w) array
    runs : (r, 3) array
    first, spacing : float
        Of the knots.
    histogram : (k,) array
    """
    last = histogram.shape[0] - 1
    for k in range(runs.shape[0]):
        row = values[runs[k, 0]]
        for j in range(runs[k, 1], runs[k, 2]):
            place = min(max((row[j] - first) / spacing, 0.0), float(last))
            knot = min(int(place), last - 1)
            share = place - knot
            histogram[knot] += 1.0 - share
            histogram[knot + 1] += share


@njit(cache=True, error_model="numpy")
def add_slopes(
    values: Float, runs: Runs, first: float, spacing: float, potential: Float, gradient: Float
) -> None:  # pragma: no cover  compiled
    """Add the gradient of the sum of a potential over the values.

    Parameters
    ----------
    values : (h, w) array
    runs : (r, 3) array
    first, spacing : float
    potential : (k,) array
    gradient : (h, w) array
    """
    last = potential.shape[0] - 1
    for k in range(runs.shape[0]):
        row, out = values[runs[k, 0]], gradient[runs[k, 0]]
        for j in range(runs[k, 1], runs[k, 2]):
            place = (row[j] - first) / spacing
            if 0.0 <= place <= last:
                knot = min(int(place), last - 1)
                out[j] += (potential[knot + 1] - potential[knot]) / spacing


@njit(cache=True, error_model="numpy")
def occupied_box(
    values: Float, runs: Runs, first: float, spacing: float, knots: int
) -> NDArray[np.int64]:  # pragma: no cover  compiled
    """Return the first knot that values touch, and one past the last, along each axis.

    Parameters
    ----------
    values : (3, h, w) array
    runs : (r, 3) array
    first, spacing : float
    knots : int
        Along each axis.

    Returns
    -------
    (3, 2) array
    """
    box = np.empty((3, 2), np.int64)
    for c in range(3):
        least, most = np.inf, -np.inf
        for k in range(runs.shape[0]):
            row = values[c, runs[k, 0]]
            for j in range(runs[k, 1], runs[k, 2]):
                least, most = min(least, row[j]), max(most, row[j])
        low = min(max((least - first) / spacing, 0.0), knots - 2.0)
        high = min(max((most - first) / spacing, 0.0), knots - 2.0)
        box[c, 0], box[c, 1] = int(low), int(high) + 2
    return box


@njit(cache=True, error_model="numpy")
def splat_color(
    values: Float,
    runs: Runs,
    first: float,
    spacing: float,
    knots: int,
    corner: NDArray[np.int64],
    histogram: Float,
) -> None:  # pragma: no cover  compiled
    """Add the colours of runs to a histogram over a box of knots.

    Parameters
    ----------
    values : (3, h, w) array
    runs : (r, 3) array
    first, spacing : float
    knots : int
        Along each axis of the whole grid.
    corner : (3,) int array
        The box's first knots.
    histogram : (k1, k2, k3) array
    """
    top = knots - 1.0
    for k in range(runs.shape[0]):
        i = runs[k, 0]
        for j in range(runs[k, 1], runs[k, 2]):
            x = min(max((values[0, i, j] - first) / spacing, 0.0), top)
            y = min(max((values[1, i, j] - first) / spacing, 0.0), top)
            z = min(max((values[2, i, j] - first) / spacing, 0.0), top)
            a, b, c = min(int(x), knots - 2), min(int(y), knots - 2), min(int(z), knots - 2)
            x, y, z = x - a, y - b, z - c
            a, b, c = a - corner[0], b - corner[1], c - corner[2]
            for m in range(2):
                along_x = x if m else 1.0 - x
                for n in range(2):
                    share = along_x * (y if n else 1.0 - y)
                    histogram[a + m, b + n, c] += share * (1.0 - z)
                    histogram[a + m, b + n, c + 1] += share * z


@njit(cache=True, error_model="numpy")
def add_color_slopes(
    values: Float,
    runs: Runs,
    first: float,
    spacing: float,
    knots: int,
    corner: NDArray[np.int64],
    potential: Float,
    gradient: Float,
) -> None:  # pragma: no cover  compiled
    """Fill the gradient of the sum of a trilinear potential over the colours of runs.

    Parameters
    ----------
    values : (3, h, w) array
    runs : (r, 3) array
    first, spacing : float
    knots : int
    corner : (3,) int array
    potential : (k1, k2, k3) array
        On the box of knots.
    gradient : (3, h, w) array
        Filled on the runs.
    """
    top = knots - 1.0
    for k in range(runs.shape[0]):
        i = runs[k, 0]
        for j in range(runs[k, 1], runs[k, 2]):
            u = (values[0, i, j] - first) / spacing
            v = (values[1, i, j] - first) / spacing
            w = (values[2, i, j] - first) / spacing
            x, y, z = min(max(u, 0.0), top), min(max(v, 0.0), top), min(max(w, 0.0), top)
            a, b, c = min(int(x), knots - 2), min(int(y), knots - 2), min(int(z), knots - 2)
            x, y, z = x - a, y - b, z - c
            a, b, c = a - corner[0], b - corner[1], c - corner[2]
            p000, p001 = potential[a, b, c], potential[a, b, c + 1]
            p010, p011 = potential[a, b + 1, c], potential[a, b + 1, c + 1]
            p100, p101 = potential[a + 1, b, c], potential[a + 1, b, c + 1]
            p110, p111 = potential[a + 1, b + 1, c], potential[a + 1, b + 1, c + 1]
            p00, p01 = p000 + z * (p001 - p000), p010 + z * (p011 - p010)
            p10, p11 = p100 + z * (p101 - p100), p110 + z * (p111 - p110)
            by_x = (p10 - p00) + y * ((p11 - p10) - (p01 - p00))
            by_y = (p01 - p00) + x * ((p11 - p10) - (p01 - p00))
            lower = (p001 - p000) + y * ((p011 - p010) - (p001 - p000))
            upper = (p101 - p100) + y * ((p111 - p110) - (p101 - p100))
            by_z = lower + x * (upper - lower)
            gradient[0, i, j] = by_x / spacing if 0.0 <= u <= top else 0.0
            gradient[1, i, j] = by_y / spacing if 0.0 <= v <= top else 0.0
            gradient[2, i, j] = by_z / spacing if 0.0 <= w <= top else 0.0
