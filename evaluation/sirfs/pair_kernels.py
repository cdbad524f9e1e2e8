"""Compiled kernels of differences between neighbours, in numbers and in colour.

The work on a run of pairs is split into loops over short buffers: arithmetic that the processor
does on several pairs at once, then the look-up in the table, then arithmetic again.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from evaluation.sirfs.regions import Runs
from shading_model.arrays import Float

LINES = 4
"""Rows of the scratch array that each kernel needs, as wide as the picture."""
_FAST = {"reassoc", "contract", "nsz"}


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def difference_loss(
    values: Float,
    pairs: Runs,
    table: Float,
    spacing: float,
    start_of_table: float,
    floor: float,
    gradient: Float,
    scratch: Float,
) -> float:  # pragma: no cover  compiled
    """Return the summed cost of differences over pairs, and add its gradient.

    The cost is a table over ``sqrt(difference^2 + floor^2)``, linear between its knots and beyond.

    Parameters
    ----------
    values : (h, w) array
    pairs : (r, 5) array
        See `evaluation.sirfs.regions.pair_runs`.
    table : (k,) array
    spacing, start_of_table : float
        Of the table's knots.
    floor : float
        Above zero.
    gradient : (h, w) array
        Added to.
    scratch : (4, w) array
    """
    total = 0.0
    knots = np.empty(values.shape[1], np.int32)
    places, slopes = scratch[0], scratch[1]
    inverse, last = 1.0 / spacing, float(table.shape[0] - 2)
    for k in range(pairs.shape[0]):
        i, start, stop = pairs[k, 0], pairs[k, 1], pairs[k, 2]
        other, shift = i + pairs[k, 3], pairs[k, 4]
        here = values[i, start:stop]
        there = values[other, start + shift : stop + shift]
        count = stop - start
        for j in range(count):
            difference = here[j] - there[j]
            length = math.sqrt(difference * difference + floor * floor)
            place = (length - start_of_table) * inverse
            knots[j] = np.int32(min(last, place))
            places[j] = place
            slopes[j] = difference / length
        total += _looked_up(table, knots, count, inverse, scratch)
        onto, off = gradient[i, start:stop], gradient[other, start + shift : stop + shift]
        for j in range(count):
            onto[j] += slopes[j]
        for j in range(count):
            off[j] -= slopes[j]
    return total


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def color_difference_loss(
    values: Float,
    pairs: Runs,
    table: Float,
    spacing: float,
    floor: float,
    gradient: Float,
    scratch: Float,
) -> float:  # pragma: no cover  compiled
    """Return the summed cost of colour differences over pairs, and add its gradient.

    The cost is a table from zero on over ``sqrt((|difference|^2 / 2)^2 + floor^2)``, linear between
    its knots and beyond.

    Parameters
    ----------
    values : (3, h, w) array
        White: log albedo times the root of the precision.
    pairs : (r, 5) array
    table : (k,) array
    spacing : float
        Of the table's knots.
    floor : float
        Above zero.
    gradient : (3, h, w) array
        Added to.
    scratch : (4, w) array
    """
    total = 0.0
    knots = np.empty(values.shape[2], np.int32)
    places, slopes, steps = scratch[0], scratch[1], scratch[2]
    inverse, last = 1.0 / spacing, float(table.shape[0] - 2)
    for k in range(pairs.shape[0]):
        i, start, stop = pairs[k, 0], pairs[k, 1], pairs[k, 2]
        other, begin, end = i + pairs[k, 3], start + pairs[k, 4], stop + pairs[k, 4]
        count = stop - start
        a0, a1, a2 = values[0, i, start:stop], values[1, i, start:stop], values[2, i, start:stop]
        b0, b1 = values[0, other, begin:end], values[1, other, begin:end]
        b2 = values[2, other, begin:end]
        for j in range(count):
            d0, d1, d2 = a0[j] - b0[j], a1[j] - b1[j], a2[j] - b2[j]
            half = 0.5 * (d0 * d0 + d1 * d1 + d2 * d2)
            length = math.sqrt(half * half + floor * floor)
            place = length * inverse
            knots[j] = np.int32(min(last, place))
            places[j] = place
            slopes[j] = half / length
        total += _looked_up(table, knots, count, inverse, scratch)
        for c in range(3):
            here, there = values[c, i, start:stop], values[c, other, begin:end]
            onto, off = gradient[c, i, start:stop], gradient[c, other, begin:end]
            for j in range(count):
                steps[j] = slopes[j] * (here[j] - there[j])
            for j in range(count):
                onto[j] += steps[j]
            for j in range(count):
                off[j] -= steps[j]
    return total


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def _looked_up(
    table: Float, knots: NDArray[np.int32], count: int, inverse: float, scratch: Float
) -> float:  # pragma: no cover  compiled
    """Return the summed table at `places`, and multiply `slopes` by the table's slope there."""
    places, slopes, lows, rises = scratch[0], scratch[1], scratch[2], scratch[3]
    for j in range(count):
        knot = knots[j]
        low = table[knot]
        lows[j], rises[j] = low, table[knot + 1] - low
    total = 0.0
    for j in range(count):
        total += lows[j] + rises[j] * (places[j] - knots[j])
        slopes[j] *= rises[j] * inverse
    return total
