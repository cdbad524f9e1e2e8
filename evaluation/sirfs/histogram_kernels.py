"""Compiled kernels of the histogram of gray log albedo: splat, and the gradient of a potential.

Knots lie evenly; a value is shared between the two knots around it. Values beyond the last knots
count at them and have no gradient.
"""

from __future__ import annotations

from numba import njit

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
