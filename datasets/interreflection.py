"""The longer paths of light in a hollow, which make a time-of-flight sensor read too far."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from shading_model.arrays import Float, Map, Mask
from shading_model.depth_map import Registration
from shading_model.height_field import normals_inside_outline

PATCHES = 24
"""Patches along the longer side of the object: the offset is smooth, and costs their square."""


def path_offset(depth: Map, reflectance: Map, mask: Mask, pixel_mm: float) -> Map:
    """Return by how much light that was reflected once more lengthens the measured depth.

    The surface is Lambertian and lit from the sensor. Light that goes by way of another patch adds
    to the direct light, and the reading is the mean of both paths, weighted by their light. Every
    patch in front of another's tangent plane is taken to see it. Planes and convex surfaces get
    nothing, hollows read farther.

    Parameters
    ----------
    depth : (h, w) array
        Millimetres.
    reflectance : (h, w) array
        Between 0 and 1.
    mask : (h, w) bool array
        Where depth and reflectance are known.
    pixel_mm : float
        Width of a pixel.

    Returns
    -------
    (h, w) array
        Millimetres, not negative; NaN outside the mask.

    Examples
    --------
    >>> rows, columns = np.mgrid[-9:10, -9:10]
    >>> bowl = 500.0 - (rows**2 + columns**2) / 18
    >>> offset = path_offset(bowl, np.full((19, 19), 0.5), np.ones((19, 19), bool), 1.0)
    >>> bool(offset[9, 9] > 0.05)
    True
    """
    place, shape = _patch_grid(mask)
    coverage = place.coverage(mask, shape)
    held = coverage > 0.25
    mean_depth, mean_reflectance = (
        np.divide(
            place.average(np.where(mask, values, 0.0), shape),
            coverage,
            out=np.full(shape, np.nan),
            where=held,
        )
        for values in (depth, reflectance)
    )
    offset = np.full(shape, np.nan)
    width = place.scale * pixel_mm
    area = width**2 * coverage[held]
    offset[held] = _offset_of_patches(mean_depth, mean_reflectance[held], held, width, area)
    nearest = ndimage.distance_transform_edt(~held, return_distances=False, return_indices=True)
    positions = np.meshgrid(*place.sensor_positions(mask.shape), indexing="ij")
    spread = ndimage.map_coordinates(offset[tuple(nearest)], positions, order=1, mode="nearest")
    return np.where(mask, spread, np.nan)


def _patch_grid(mask: Mask) -> tuple[Registration, tuple[int, int]]:
    rows, columns = ndimage.find_objects(mask.astype(np.int8))[0]
    sides = rows.stop - rows.start, columns.stop - columns.start
    scale = max(max(sides) / PATCHES, 1.0)
    shape = int(np.ceil(sides[0] / scale)), int(np.ceil(sides[1] / scale))
    first = (scale - 1) / 2
    return Registration(scale, rows.start + first, columns.start + first), shape


def _offset_of_patches(
    depth: Map, reflectance: Float, held: Mask, width: float, area: Float
) -> Float:
    """Return the offset (n,) of patches, the sum over all pairs of patches p <- q."""
    points = np.column_stack([np.argwhere(held)[:, ::-1] * [width, -width], -depth[held]])
    normals = normals_inside_outline(-depth / width)[held]
    # How far each patch lies in front of the other's tangent plane.
    heights = points @ normals.T
    own = np.diagonal(heights)
    q_over_p, p_over_q = np.maximum(heights.T - own[:, None], 0), np.maximum(heights - own, 0)
    apart = points[:, None] - points
    distance = np.sqrt(np.einsum("pqi,pqi->pq", apart, apart))
    longer = (distance + apart[:, :, 2]) / 2
    np.fill_diagonal(distance, np.inf)
    # The light that falls on q is that on its projected area, whichever way it is turned.
    relative = (reflectance * area / np.pi) * q_over_p * p_over_q / distance**4
    relative /= normals[:, 2:]
    offset: Float = (relative * longer).sum(axis=1) / (1 + relative.sum(axis=1))
    return offset
