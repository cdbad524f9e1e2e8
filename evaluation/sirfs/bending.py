"""The bending of a function of three variables, softly absolute, and its gradient."""

from __future__ import annotations

import numpy as np
from numba import njit

from shading_model.arrays import Float


@njit(cache=True)
def bending(values: Float, softness: float, gradient: Float) -> float:
    """Return ``sum sqrt(Fxx^2 + Fyy^2 + Fzz^2 + 2 (Fxy^2 + Fyz^2 + Fxz^2) + softness)``.

    Second differences of neighbouring knots; those that would reach beyond the grid are zero.

    Parameters
    ----------
    values : (n, n, n) array
        F.
    softness : float
        Above zero.
    gradient : (n, n, n) array
        Overwritten with the derivatives by the values.

    Returns
    -------
    float

    Examples
    --------
    >>> plane = np.add.outer(np.add.outer(np.arange(3.0), np.arange(3.0)), np.arange(3.0))
    >>> round(bending(plane, 1e-4, np.empty((3, 3, 3))), 6)  # of 27 knots
    0.27
    """
    n = values.shape[0]
    total = 0.0
    gradient[:] = 0.0
    for i in range(n):
        for j in range(n):
            for k in range(n):
                bends = _second_differences(values, i, j, k)
                straight = bends[0] ** 2 + bends[1] ** 2 + bends[2] ** 2
                twisted = bends[3] ** 2 + bends[4] ** 2 + bends[5] ** 2
                length = np.sqrt(straight + 2 * twisted + softness)
                total += length
                _add_gradient(gradient, i, j, k, bends, 1 / length)
    return total


@njit(cache=True)
def _second_differences(
    values: Float, i: int, j: int, k: int
) -> tuple[float, float, float, float, float, float]:
    """Return Fxx, Fyy, Fzz, Fxy, Fyz and Fxz at a knot."""
    last, here = values.shape[0] - 1, values[i, j, k]
    xx = yy = zz = xy = yz = xz = 0.0
    if 0 < i < last:
        xx = values[i - 1, j, k] - 2 * here + values[i + 1, j, k]
    if 0 < j < last:
        yy = values[i, j - 1, k] - 2 * here + values[i, j + 1, k]
    if 0 < k < last:
        zz = values[i, j, k - 1] - 2 * here + values[i, j, k + 1]
    if i < last and j < last:
        xy = values[i + 1, j + 1, k] - values[i + 1, j, k] - values[i, j + 1, k] + here
    if j < last and k < last:
        yz = values[i, j + 1, k + 1] - values[i, j + 1, k] - values[i, j, k + 1] + here
    if i < last and k < last:
        xz = values[i + 1, j, k + 1] - values[i + 1, j, k] - values[i, j, k + 1] + here
    return xx, yy, zz, xy, yz, xz


@njit(cache=True)
def _add_gradient(
    gradient: Float,
    i: int,
    j: int,
    k: int,
    bends: tuple[float, float, float, float, float, float],
    factor: float,
) -> None:
    """Add the derivative of the length of a knot's second differences."""
    last = gradient.shape[0] - 1
    xx, yy, zz = factor * bends[0], factor * bends[1], factor * bends[2]
    xy, yz, xz = 2 * factor * bends[3], 2 * factor * bends[4], 2 * factor * bends[5]
    gradient[i, j, k] += xy + yz + xz - 2 * (xx + yy + zz)
    if 0 < i < last:
        gradient[i - 1, j, k] += xx
        gradient[i + 1, j, k] += xx
    if 0 < j < last:
        gradient[i, j - 1, k] += yy
        gradient[i, j + 1, k] += yy
    if 0 < k < last:
        gradient[i, j, k - 1] += zz
        gradient[i, j, k + 1] += zz
    if i < last and j < last:
        gradient[i + 1, j + 1, k] += xy
        gradient[i + 1, j, k] -= xy
        gradient[i, j + 1, k] -= xy
    if j < last and k < last:
        gradient[i, j + 1, k + 1] += yz
        gradient[i, j + 1, k] -= yz
        gradient[i, j, k + 1] -= yz
    if i < last and k < last:
        gradient[i + 1, j, k + 1] += xz
        gradient[i + 1, j, k] -= xz
        gradient[i, j, k + 1] -= xz
