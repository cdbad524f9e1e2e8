"""Compiled kernels of the light: log albedo from slopes and light, and the adjoint.

``A = log I - B(N) . L`` on the runs of valid pixels, with ``N = (-dZ/dcolumn, dZ/drow, 1)`` over
its length (x right, y up, z toward the viewer) and the nine harmonics of
`shading_model.illumination.harmonics`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from evaluation.sirfs.regions import Runs
from shading_model.arrays import Float
from shading_model.illumination import C1, C2, C3, C4, C5

_FAST = {"reassoc", "contract", "nsz"}


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def log_albedo(
    down: Float,
    right: Float,
    runs: Runs,
    light: Float,
    log_image: Float,
    albedo: Float,
) -> None:  # pragma: no cover  compiled
    """Fill log albedo on runs.

    Parameters
    ----------
    down, right : (h, w) arrays
        Slopes.
    runs : (r, 3) array
    light : (c, 9) array
        Coefficients.
    log_image, albedo : (c, h, w) arrays
    """
    normal = np.empty((3, down.shape[1]))
    for k in range(runs.shape[0]):
        i, start, stop = runs[k, 0], runs[k, 1], runs[k, 2]
        count = stop - start
        _normals(down[i, start:stop], right[i, start:stop], normal)
        x_of, y_of, z_of = normal[0], normal[1], normal[2]
        for c in range(light.shape[0]):
            one = light[c]
            constant = C4 * one[0] - C5 * one[6]
            by_y, by_z, by_x = 2 * C2 * one[1], 2 * C2 * one[2], 2 * C2 * one[3]
            by_xy, by_yz, by_xz = 2 * C1 * one[4], 2 * C1 * one[5], 2 * C1 * one[7]
            by_zz, by_square = C3 * one[6], C1 * one[8]
            source, target = log_image[c, i, start:stop], albedo[c, i, start:stop]
            for j in range(count):
                x, y, z = x_of[j], y_of[j], z_of[j]
                shading = (
                    constant
                    + x * (by_x + by_xy * y + by_xz * z + by_square * x)
                    + y * (by_y + by_yz * z - by_square * y)
                    + z * (by_z + by_zz * z)
                )
                target[j] = source[j] - shading


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def log_albedo_adjoint(
    down: Float,
    right: Float,
    runs: Runs,
    light: Float,
    by_albedo: Float,
    gradients: Float,
    by_light: Float,
) -> None:  # pragma: no cover  compiled
    """Add the gradient by log albedo to those by slopes and light.

    Parameters
    ----------
    down, right : (h, w) arrays
    runs : (r, 3) array
    light : (c, 9) array
    by_albedo : (c, h, w) array
    gradients : (5, h + 4, w + 4) array
        The first two, by dZ/drow and dZ/dcolumn, are added to.
    by_light : (c, 9) array
        Added to.
    """
    width = down.shape[1]
    normal, by_normal = np.empty((3, width)), np.empty((3, width))
    for k in range(runs.shape[0]):
        i, start, stop = runs[k, 0], runs[k, 1], runs[k, 2]
        count = stop - start
        _normals(down[i, start:stop], right[i, start:stop], normal)
        x_of, y_of, z_of = normal[0], normal[1], normal[2]
        by_x_of, by_y_of, by_z_of = by_normal[0], by_normal[1], by_normal[2]
        for j in range(count):
            by_x_of[j] = by_y_of[j] = by_z_of[j] = 0.0
        for c in range(light.shape[0]):
            one, source = light[c], by_albedo[c, i, start:stop]
            by_y, by_z, by_x = 2 * C2 * one[1], 2 * C2 * one[2], 2 * C2 * one[3]
            by_xy, by_yz, by_xz = 2 * C1 * one[4], 2 * C1 * one[5], 2 * C1 * one[7]
            by_zz, by_square = 2 * C3 * one[6], 2 * C1 * one[8]
            total = s_x = s_y = s_z = s_xy = s_yz = s_zz = s_xz = s_square = 0.0
            for j in range(count):
                x, y, z = x_of[j], y_of[j], z_of[j]
                # The shading is subtracted.
                given = -source[j]
                total += given
                s_x += given * x
                s_y += given * y
                s_z += given * z
                s_xy += given * x * y
                s_yz += given * y * z
                s_xz += given * x * z
                s_zz += given * z * z
                s_square += given * (x * x - y * y)
                by_x_of[j] += given * (by_x + by_xy * y + by_xz * z + by_square * x)
                by_y_of[j] += given * (by_y + by_xy * x + by_yz * z - by_square * y)
                by_z_of[j] += given * (by_z + by_yz * y + by_xz * x + by_zz * z)
            out = by_light[c]
            out[0] += C4 * total
            out[1] += 2 * C2 * s_y
            out[2] += 2 * C2 * s_z
            out[3] += 2 * C2 * s_x
            out[4] += 2 * C1 * s_xy
            out[5] += 2 * C1 * s_yz
            out[6] += C3 * s_zz - C5 * total
            out[7] += 2 * C1 * s_xz
            out[8] += C1 * s_square
        by_down = gradients[0, i + 2, start + 2 : stop + 2]
        by_right = gradients[1, i + 2, start + 2 : stop + 2]
        for j in range(count):
            x, y, z = x_of[j], y_of[j], z_of[j]
            along = by_x_of[j] * x + by_y_of[j] * y + by_z_of[j] * z
            # z is one over the length of (-dZ/dcolumn, dZ/drow, 1).
            by_down[j] += z * (by_y_of[j] - along * y)
            by_right[j] -= z * (by_x_of[j] - along * x)


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def _normals(down: Float, right: Float, normal: Float) -> None:  # pragma: no cover  compiled
    x_of, y_of, z_of = normal[0], normal[1], normal[2]
    for j in range(down.size):
        z = 1.0 / math.sqrt(1.0 + down[j] * down[j] + right[j] * right[j])
        x_of[j] = -right[j] * z
        y_of[j] = down[j] * z
        z_of[j] = z


@njit(cache=True, error_model="numpy")
def contour_loss(
    down: Float,
    right: Float,
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    outward: Float,
    power: float,
    flat_ends: float,
    scale: float,
    gradients: Float,
) -> float:  # pragma: no cover  compiled
    """Return the sum of ``max(0, 1 - N . b)^power`` over the outline; add scale times its gradient.

    Parameters
    ----------
    down, right : (h, w) arrays
    rows, columns : (m,) int arrays
    outward : (m, 2) array
        b, (x right, y up).
    power : float
    flat_ends : float
        Within this of N . b = 1 or -1 there is no gradient.
    scale : float
    gradients : (5, h + 4, w + 4) array
    """
    total = 0.0
    for k in range(rows.shape[0]):
        i, j = rows[k], columns[k]
        p, q = down[i, j], right[i, j]
        z = 1.0 / math.sqrt(1.0 + p * p + q * q)
        x, y = -q * z, p * z
        along = x * outward[k, 0] + y * outward[k, 1]
        rest = max(0.0, 1.0 - along)
        total += rest**power
        if abs(along) <= 1.0 - flat_ends:
            given = -scale * power * rest ** (power - 1.0)
            gradients[0, i + 2, j + 2] += given * z * (outward[k, 1] - along * y)
            gradients[1, i + 2, j + 2] -= given * z * (outward[k, 0] - along * x)
    return total
