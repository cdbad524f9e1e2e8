"""Compiled kernels of colour log albedo: linear maps of channels, and differences over pairs."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from evaluation.sirfs.regions import Runs
from shading_model.arrays import Float


@njit(cache=True, error_model="numpy")
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
        red, green, blue = values[0, i], values[1, i], values[2, i]
        for c in range(3):
            a, b, d = matrix[0, c], matrix[1, c], matrix[2, c]
            out = mixed[c, i]
            for j in range(start, stop):
                out[j] = a * red[j] + b * green[j] + d * blue[j]


@njit(cache=True, error_model="numpy")
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
        red, green, blue = values[0, i], values[1, i], values[2, i]
        for c in range(3):
            a, b, d = scale * matrix[0, c], scale * matrix[1, c], scale * matrix[2, c]
            out = total[c, i]
            for j in range(start, stop):
                out[j] += a * red[j] + b * green[j] + d * blue[j]


@njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def color_difference_loss(
    values: Float,
    pairs: Runs,
    table: Float,
    spacing: float,
    floor: float,
    gradient: Float,
    buffer: Float,
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
    gradient : (3, h, w) array
        Added to.
    buffer : (3, w) array
        Scratch.
    """
    total = 0.0
    last = table.shape[0] - 2
    inverse = 1.0 / spacing
    first_out, second_out, third_out = buffer[0], buffer[1], buffer[2]
    for k in range(pairs.shape[0]):
        i, start, stop = pairs[k, 0], pairs[k, 1], pairs[k, 2]
        other, shift = i + pairs[k, 3], pairs[k, 4]
        a0, a1, a2 = values[0, i], values[1, i], values[2, i]
        b0, b1, b2 = values[0, other], values[1, other], values[2, other]
        for j in range(start, stop):
            d0, d1, d2 = a0[j] - b0[j + shift], a1[j] - b1[j + shift], a2[j] - b2[j + shift]
            half = 0.5 * (d0 * d0 + d1 * d1 + d2 * d2)
            length = math.sqrt(half * half + floor * floor)
            place = length * inverse
            knot = np.uint32(min(place, float(last)))
            low = table[knot]
            rise = table[knot + np.uint32(1)] - low
            total += low + rise * (place - knot)
            slope = rise * inverse * half / length
            first_out[j], second_out[j], third_out[j] = slope * d0, slope * d1, slope * d2
        for c in range(3):
            out, here, there = buffer[c], gradient[c, i], gradient[c, other]
            for j in range(start, stop):
                here[j] += out[j]
            for j in range(start, stop):
                there[j + shift] -= out[j]
    return total
