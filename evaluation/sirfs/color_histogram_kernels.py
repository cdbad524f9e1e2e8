"""Compiled kernels of the histogram of colour log albedo.

As `evaluation.sirfs.histogram_kernels` in three dimensions: a colour is shared between the eight
knots around it. Only the box of knots that colours touch is stored, and only its occupied rows are
worked on.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from evaluation.sirfs.regions import Runs
from shading_model.arrays import Float, Mask

_FAST = {"reassoc", "contract", "nsz"}


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def locate(
    values: Float,
    runs: Runs,
    first: float,
    spacing: float,
    knots: int,
    cells: NDArray[np.int32],
    shares: Float,
) -> NDArray[np.int64]:  # pragma: no cover  compiled
    """Fill the cells that colours lie in, and where in them; return the box of all cells.

    Parameters
    ----------
    values : (3, h, w) array
    runs : (r, 3) array
        Of n pixels.
    first, spacing : float
        Of the knots.
    knots : int
        Along each axis.
    cells : (3, n) array
        The knot below, along each axis.
    shares : (3, n) array
        Place between that knot and the next, from 0 to 1.

    Returns
    -------
    (2, 3) array
        The first knot along each axis, and the number of knots.
    """
    top, inverse = float(knots - 2), 1.0 / spacing
    box = np.empty((2, 3), np.int64)
    for c in range(3):
        least, most, n = np.int32(knots), np.int32(0), 0
        for k in range(runs.shape[0]):
            row = values[c, runs[k, 0], runs[k, 1] : runs[k, 2]]
            cell, share = cells[c, n : n + row.size], shares[c, n : n + row.size]
            for j in range(row.size):
                place = (row[j] - first) * inverse
                knot = np.int32(min(max(place, 0.0), top))
                cell[j] = knot
                share[j] = min(max(place - knot, 0.0), 1.0)
                least, most = min(least, knot), max(most, knot)
            n += row.size
        box[0, c], box[1, c] = least, most - least + 2
    return box


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def splat_color(
    cells: NDArray[np.int32], shares: Float, corner: NDArray[np.int64], histogram: Float
) -> None:  # pragma: no cover  compiled
    """Add colours to the histogram of a box.

    Parameters
    ----------
    cells, shares : (3, n) arrays
        Of `locate`.
    corner : (3,) array
        First knots of the box.
    histogram : (k1, k2, k3) array
    """
    along_second = histogram.shape[2]
    along_first = histogram.shape[1] * along_second
    flat = histogram.reshape(-1)
    for j in range(cells.shape[1]):
        at = (
            (cells[0, j] - corner[0]) * along_first
            + (cells[1, j] - corner[1]) * along_second
            + (cells[2, j] - corner[2])
        )
        x, y, z = shares[0, j], shares[1, j], shares[2, j]
        both = x * y
        for step, share in (
            (0, 1.0 - x - y + both),
            (along_second, y - both),
            (along_first, x - both),
            (along_first + along_second, both),
        ):
            flat[at + step] += share * (1.0 - z)
            flat[at + step + 1] += share * z


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def fill_color_slopes(
    cells: NDArray[np.int32],
    shares: Float,
    corner: NDArray[np.int64],
    potential: Float,
    runs: Runs,
    spacing: float,
    gradient: Float,
) -> None:  # pragma: no cover  compiled
    """Fill the gradient of the sum of a trilinear potential over colours.

    Parameters
    ----------
    cells, shares : (3, n) arrays
        Of `locate`.
    corner : (3,) array
    potential : (k1, k2, k3) array
    runs : (r, 3) array
    spacing : float
    gradient : (3, h, w) array
        Filled on the runs; zero along an axis beyond whose last knots a colour lies.
    """
    along_second = potential.shape[2]
    along_first = potential.shape[1] * along_second
    flat = potential.reshape(-1)
    inverse, n = 1.0 / spacing, 0
    for k in range(runs.shape[0]):
        i, start, stop = runs[k, 0], runs[k, 1], runs[k, 2]
        for j in range(start, stop):
            at = (
                (cells[0, n] - corner[0]) * along_first
                + (cells[1, n] - corner[1]) * along_second
                + (cells[2, n] - corner[2])
            )
            x, y, z = shares[0, n], shares[1, n], shares[2, n]
            n += 1
            p000, p010 = flat[at], flat[at + along_second]
            p100, p110 = flat[at + along_first], flat[at + along_first + along_second]
            up00, up01 = flat[at + 1] - p000, flat[at + along_second + 1] - p010
            up10 = flat[at + along_first + 1] - p100
            up11 = flat[at + along_first + along_second + 1] - p110
            p00, p01, p10, p11 = p000 + z * up00, p010 + z * up01, p100 + z * up10, p110 + z * up11
            mixed = (p11 - p10) - (p01 - p00)
            near, far = up00 + y * (up01 - up00), up10 + y * (up11 - up10)
            gradient[0, i, j] = _inside(x) * inverse * ((p10 - p00) + y * mixed)
            gradient[1, i, j] = _inside(y) * inverse * ((p01 - p00) + x * mixed)
            gradient[2, i, j] = _inside(z) * inverse * (near + x * (far - near))


@njit(cache=True, error_model="numpy")
def _inside(share: float) -> float:  # pragma: no cover  compiled
    return 1.0 if 0.0 < share < 1.0 else 0.0


def smoothed_histogram(histogram: Float, kernel: Float) -> Float:
    """Return a histogram convolved along its three axes, where its rows are occupied.

    Rows along the last axis that hold nothing stay zero in the result: nobody asks for them.

    Parameters
    ----------
    histogram : (a, b, c) array
    kernel : (2 r + 1,) array
        Even; the histogram is zero beyond its box.

    Returns
    -------
    (a, b, c) array

    Examples
    --------
    >>> histogram = np.zeros((3, 3, 3))
    >>> histogram[1, 1, 1] = 8.0
    >>> smoothed_histogram(histogram, np.array([0.25, 0.5, 0.25]))[1, 1]
    array([0.5, 1. , 0.5])
    """
    occupied = np.asarray(histogram.any(axis=2))
    once, twice, thrice = (np.zeros(histogram.shape) for _ in range(3))
    _smooth_last(histogram, kernel, occupied, once)
    _smooth_middle(once, kernel, occupied, twice)
    reached = np.asarray(twice.any(axis=2))
    # The first axis is the middle one of the transposed arrays.
    _smooth_middle(
        twice.transpose(1, 0, 2), kernel, reached.T, thrice.transpose(1, 0, 2), occupied.T
    )
    return thrice


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def _smooth_last(
    values: Float, kernel: Float, occupied: Mask, out: Float
) -> None:  # pragma: no cover  compiled
    reach, count = kernel.size // 2, values.shape[2]
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            if occupied[i, j]:
                for k in range(kernel.size):
                    shift = k - reach
                    low, high = max(0, -shift), min(count, count - shift)
                    if low < high:
                        row = values[i, j, low + shift : high + shift]
                        _add_scaled(row, kernel[k], out[i, j, low:high])


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def _smooth_middle(
    values: Float, kernel: Float, occupied: Mask, out: Float, wanted: Mask | None = None
) -> None:  # pragma: no cover  compiled
    reach, count = kernel.size // 2, values.shape[1]
    for i in range(values.shape[0]):
        for j in range(count):
            if wanted is None or wanted[i, j]:
                for k in range(max(0, j - reach), min(count, j + reach + 1)):
                    if occupied[i, k]:
                        _add_scaled(values[i, k], kernel[k - j + reach], out[i, j])


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def _add_scaled(row: Float, factor: float, out: Float) -> None:  # pragma: no cover  compiled
    for m in range(out.size):
        out[m] += factor * row[m]
