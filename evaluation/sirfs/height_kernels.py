"""Compiled kernels of the shape: slopes, curvature, the shape's terms of the loss, and adjoints.

Slopes are 3x3 Sobel derivatives over 8, down the rows and right along the columns; second
derivatives are 3x3 stencils; borders are replicated. Kernels that take gradients add to them.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from evaluation.sirfs.regions import Runs
from shading_model.arrays import Float

CURVATURE_FLOOR = 1e-4
SLANT_FLOOR = 0.01
_FAST = {"reassoc", "contract", "nsz"}
FLAT_ENDS = 1e-3
"""Within this of parallel or opposed to the outline's normal, the contour term has no gradient."""


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def padded_height(height: Float, padded: Float) -> None:  # pragma: no cover  compiled
    """Copy a height map (h, w) into one with a replicated border of one pixel, (h + 2, w + 2).

    Parameters
    ----------
    height, padded : arrays
    """
    rows, columns = height.shape
    for i in range(rows + 2):
        source = min(max(i - 1, 0), rows - 1)
        padded[i, 0] = height[source, 0]
        for j in range(columns):
            padded[i, j + 1] = height[source, j]
        padded[i, columns + 1] = height[source, columns - 1]


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def slopes_of(padded: Float, down: Float, right: Float) -> None:  # pragma: no cover  compiled
    """Fill the slopes dZ/drow and dZ/dcolumn of a padded height map.

    Parameters
    ----------
    padded : (h + 2, w + 2) array
    down, right : (h, w) arrays
    """
    rows, columns = down.shape
    for i in range(rows):
        above, here, below = padded[i], padded[i + 1], padded[i + 2]
        out_down, out_right = down[i], right[i]
        for j in range(columns):
            corner = below[j + 2] - above[j]
            across = below[j] - above[j + 2]
            out_down[j] = (corner + across + 2.0 * (below[j + 1] - above[j + 1])) / 8.0
            out_right[j] = (corner - across + 2.0 * (here[j + 2] - here[j])) / 8.0


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def curvature_of(
    padded: Float, down: Float, right: Float, runs: Runs, curvature: Float, partials: Float
) -> None:  # pragma: no cover  compiled
    """Fill mean curvature, and its partial derivatives, on runs.

    Parameters
    ----------
    padded : (h + 2, w + 2) array
    down, right : (h, w) arrays
    runs : (r, 3) array
    curvature : (h, w) array
    partials : (5, h, w) array
        By dZ/drow, dZ/dcolumn, and the second derivatives rr, cc, rc.
    """
    for k in range(runs.shape[0]):
        i, start, stop = runs[k, 0], runs[k, 1], runs[k, 2]
        above, here = padded[i, start : stop + 2], padded[i + 1, start : stop + 2]
        below, out = padded[i + 2, start : stop + 2], curvature[i, start:stop]
        slope_down, slope_right = down[i, start:stop], right[i, start:stop]
        by_p, by_q = partials[0, i, start:stop], partials[1, i, start:stop]
        by_rr, by_cc = partials[2, i, start:stop], partials[3, i, start:stop]
        by_rc = partials[4, i, start:stop]
        for j in range(stop - start):
            corners = above[j] + above[j + 2] + below[j] + below[j + 2]
            sides = here[j] + here[j + 2]
            ends = above[j + 1] + below[j + 1]
            centre = 4.0 * here[j + 1]
            rr = (corners + 2.0 * ends - 2.0 * sides - centre) / 4.0
            cc = (corners + 2.0 * sides - 2.0 * ends - centre) / 4.0
            rc = (above[j] - above[j + 2] - below[j] + below[j + 2]) / 4.0
            p, q = slope_down[j], slope_right[j]
            square = 1.0 + p * p + q * q
            inverse = 0.5 / (square * math.sqrt(square))
            with_cc, with_rr, with_rc = 1.0 + p * p, 1.0 + q * q, -2.0 * p * q
            mean = (with_cc * cc + with_rr * rr + with_rc * rc) * inverse
            out[j] = mean
            shrink = 3.0 * mean / square
            by_p[j] = 2.0 * (p * cc - q * rc) * inverse - shrink * p
            by_q[j] = 2.0 * (q * rr - p * rc) * inverse - shrink * q
            by_rr[j] = with_rr * inverse
            by_cc[j] = with_cc * inverse
            by_rc[j] = with_rc * inverse


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def curvature_adjoint(
    by_curvature: Float, scale: float, runs: Runs, partials: Float, gradients: Float
) -> None:  # pragma: no cover  compiled
    """Add the gradient by curvature to those by slopes and second derivatives.

    Parameters
    ----------
    by_curvature : (h, w) array
    scale : float
        Factor of `by_curvature`.
    runs : (r, 3) array
    partials : (5, h, w) array
    gradients : (5, h + 4, w + 4) array
        By dZ/drow, dZ/dcolumn, rr, cc, rc, with a border of two pixels; added to.
    """
    for k in range(runs.shape[0]):
        i, start, stop = runs[k, 0], runs[k, 1], runs[k, 2]
        source = by_curvature[i, start:stop]
        for m in range(5):
            part = partials[m, i, start:stop]
            target = gradients[m, i + 2, start + 2 : stop + 2]
            for j in range(stop - start):
                target[j] += scale * source[j] * part[j]


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def slant_loss(
    down: Float, right: Float, scale: float, gradients: Float
) -> float:  # pragma: no cover  compiled
    """Return the sum of ``sqrt((log N_z)^2 + floor^2)`` over pixels; add scale times its gradient.

    Parameters
    ----------
    down, right : (h, w) arrays
    scale : float
    gradients : (5, h + 4, w + 4) array
    """
    total = 0.0
    rows, columns = down.shape
    leans = np.empty(columns)
    for i in range(rows):
        slope_down, slope_right = down[i], right[i]
        by_down, by_right = (
            gradients[0, i + 2, 2 : columns + 2],
            gradients[1, i + 2, 2 : columns + 2],
        )
        for j in range(columns):
            # log N_z = -log(1 + p^2 + q^2) / 2
            p, q = slope_down[j], slope_right[j]
            leans[j] = 0.5 * math.log(1.0 + p * p + q * q)
        for j in range(columns):
            p, q, lean = slope_down[j], slope_right[j], leans[j]
            length = math.sqrt(lean * lean + SLANT_FLOOR * SLANT_FLOOR)
            total += length
            by_lean = scale * lean / (length * (1.0 + p * p + q * q))
            by_down[j] += by_lean * p
            by_right[j] += by_lean * q
    return total


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def height_adjoint(gradients: Float, by_height: Float) -> None:  # pragma: no cover  compiled
    """Fill the gradient by height from those by slopes and second derivatives.

    Parameters
    ----------
    gradients : (5, h + 4, w + 4) array
        Zero on the border of two pixels.
    by_height : (h, w) array
    """
    rows, columns = by_height.shape
    line = np.empty(columns + 2)
    for i in range(rows):
        for j in range(columns):
            by_height[i, j] = 0.0
    for i in range(rows + 2):
        # Row i of the padded height; a stencil's centre is at rows i - 1 .. i + 1 of `gradients`.
        p0, p2 = gradients[0, i], gradients[0, i + 2]
        q0, q1, q2 = gradients[1, i], gradients[1, i + 1], gradients[1, i + 2]
        r0, r1, r2 = gradients[2, i], gradients[2, i + 1], gradients[2, i + 2]
        c0, c1, c2 = gradients[3, i], gradients[3, i + 1], gradients[3, i + 2]
        m0, m2 = gradients[4, i], gradients[4, i + 2]
        for j in range(columns + 2):
            slope_down = p0[j] + 2.0 * p0[j + 1] + p0[j + 2] - p2[j] - 2.0 * p2[j + 1] - p2[j + 2]
            slope_right = q0[j] - q0[j + 2] + 2.0 * (q1[j] - q1[j + 2]) + q2[j] - q2[j + 2]
            bend_down = (
                r0[j]
                + 2.0 * r0[j + 1]
                + r0[j + 2]
                - 2.0 * (r1[j] + 2.0 * r1[j + 1] + r1[j + 2])
                + r2[j]
                + 2.0 * r2[j + 1]
                + r2[j + 2]
            )
            bend_right = (
                c0[j]
                - 2.0 * c0[j + 1]
                + c0[j + 2]
                + 2.0 * (c1[j] - 2.0 * c1[j + 1] + c1[j + 2])
                + c2[j]
                - 2.0 * c2[j + 1]
                + c2[j + 2]
            )
            twist = m0[j] - m0[j + 2] - m2[j] + m2[j + 2]
            line[j] = (slope_down + slope_right) / 8.0 + (bend_down + bend_right + twist) / 4.0
        target = by_height[min(max(i - 1, 0), rows - 1)]
        target[0] += line[0]
        for j in range(columns):
            target[j] += line[j + 1]
        target[columns - 1] += line[columns + 1]
