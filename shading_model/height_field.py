"""Normals of a height field."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import correlate

from shading_model.arrays import Float, Map, Normals


def normals_of_height(height: Map) -> Normals:
    """Return the normals of a height field that stands on the plane of its outline.

    Slopes are 3x3 Sobel derivatives; pixels outside the mask (NaN) count as height zero, so the
    normals turn over the crease at the outline. Use `slopes` for a surface that ends in mid-air.

    Parameters
    ----------
    height : (h, w) array
        Pixels, NaN outside the mask.

    Returns
    -------
    (h, w, 3) array
        Unit normals (x right, y up, z toward the viewer), NaN where `height` is.

    Examples
    --------
    >>> normals_of_height(np.tile(np.arange(5.0), (3, 1)))[1, 2].round(3) + 0.0
    array([-0.707,  0.   ,  0.707])
    """
    known = np.isfinite(height)
    right, up = slopes(np.where(known, height, 0.0))
    normals = normals_of_slopes(right, up)
    normals[~known] = np.nan
    return normals


def slopes(height: Map) -> tuple[Map, Map]:
    """Return dZ/dx (right) and dZ/dy (up): 3x3 Sobel over 8, borders replicated, NaN spreading.

    Parameters
    ----------
    height : (h, w) array

    Returns
    -------
    (h, w) array, (h, w) array

    Examples
    --------
    >>> right, up = slopes(np.add.outer(np.arange(4.0), np.zeros(4)))
    >>> float(right[1, 1]), float(up[1, 1])
    (0.0, -1.0)
    """
    smooth, difference = np.array([1.0, 2.0, 1.0]), np.array([-1.0, 0.0, 1.0]) / 8
    down = correlate(height, np.outer(difference, smooth), mode="nearest")
    right = correlate(height, np.outer(smooth, difference), mode="nearest")
    # The filter leaves out its zero weights, so a lone NaN would not reach its own pixel.
    unknown = np.isnan(height)
    right[unknown] = down[unknown] = np.nan
    return right, -down


def normals_of_slopes(right: Float, up: Float) -> Normals:
    """Return the unit normals (-dZ/dx, -dZ/dy, 1) / length.

    Parameters
    ----------
    right, up : (...) arrays

    Returns
    -------
    (..., 3) array

    Examples
    --------
    >>> normals_of_slopes(np.array(0.0), np.array(1.0)).round(3) + 0.0
    array([ 0.   , -0.707,  0.707])
    """
    stacked = np.stack([-right, -up, np.ones_like(right)], axis=-1)
    normals: Normals = stacked / np.linalg.norm(stacked, axis=-1, keepdims=True)
    return normals


def normals_inside_outline(height: Map) -> Normals:
    """Return the normals of a surface that ends at its outline, known wherever the height is.

    Inside they are those of `slopes`; at the outline, differences that would reach a NaN are left
    out, so a plane has its own normal up to its edge and nothing turns over the crease.

    Parameters
    ----------
    height : (h, w) array
        Pixels, NaN outside the mask.

    Returns
    -------
    (h, w, 3) array
        Unit normals (x right, y up, z toward the viewer), NaN where `height` is. A pixel without
        a neighbour along an axis has no slope along it.

    Examples
    --------
    >>> ramp = np.array([[np.nan, 1.0, 2.0], [np.nan, 1.0, 2.0]])
    >>> normals_inside_outline(ramp)[0, 1].round(3) + 0.0
    array([-0.707,  0.   ,  0.707])
    """
    right, down = _known_slope(height), _known_slope(height.T).T
    normals = normals_of_slopes(right, -down)
    normals[np.isnan(height)] = np.nan
    return normals


def _known_slope(height: Map) -> Map:
    """Return the slope along the rows: [1 2 1] across them, over the known differences alone."""
    difference = np.diff(height, axis=1)
    known = np.isfinite(difference)
    difference[~known] = 0.0
    total, count = (
        np.pad(part, ((1, 1), (1, 0))) + np.pad(part, ((1, 1), (0, 1)))
        for part in (difference, known.astype(np.float64))
    )
    # Central differences are averaged, not pooled: a row's weight does not hang on its neighbours.
    slope = np.divide(total, count, out=np.zeros_like(total), where=count > 0)
    weight = (count > 0).astype(np.float64)
    slope, weight = (2 * part[1:-1] + part[:-2] + part[2:] for part in (slope, weight))
    result: Map = np.divide(slope, weight, out=np.zeros_like(slope), where=weight > 0)
    return result
