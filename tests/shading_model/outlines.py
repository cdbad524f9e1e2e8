"""Masks and maps that the tests of the shading model share."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from shading_model.arrays import Float, Map, Mask, Normals


def disk(radius: float, margin: int = 2) -> tuple[Mask, Map, Map]:
    """Return a disk's mask and its coordinates x (right), y (up) in units of the radius."""
    reach = int(np.ceil(radius)) + margin
    rows, columns = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    return np.hypot(rows, columns) <= radius, columns / radius, -rows / radius


def inverse_stereographic(x: Float, y: Float) -> Normals:
    """Return N = (2x, 2y, 1 - r^2) / (1 + r^2), the harmonic map of the disk to the hemisphere."""
    squared = x**2 + y**2
    return np.stack([2 * x, 2 * y, 1 - squared], axis=-1) / (1 + squared)[..., None]


def dome(radius: float) -> tuple[Mask, Map, Normals]:
    """Return the mask, height in pixels and unit normals of a spherical cap of half its radius."""
    mask, x, y = disk(radius)
    sphere = 1.25  # the sphere through the outline with its top at half the radius
    rise = np.sqrt(np.maximum(sphere**2 - x**2 - y**2, 0))
    height = np.where(mask, radius * (rise - (sphere - 0.5)), np.nan)
    normals = np.stack([x, y, rise], axis=-1) / sphere
    return mask, height, np.where(mask[..., None], normals, np.nan)


def angles(first: Normals, second: Normals, mask: Mask) -> Float:
    """Return the angles in degrees between unit normals at the pixels of a mask."""
    cosines = np.einsum("ij,ij->i", first[mask], second[mask])
    return np.degrees(np.arccos(np.clip(cosines, -1, 1)))


def unit_normals(generator: np.random.Generator, *shape: int) -> Normals:
    """Return random unit normals toward the viewer."""
    normals = generator.normal(size=(*shape, 3))
    normals[..., 2] = np.abs(normals[..., 2]) + 0.1
    return normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def masks(side: int = 9) -> st.SearchStrategy[Mask]:
    """Any mask of at least one pixel: holes, many components, thin parts, pixels on the edge."""
    sides = st.tuples(st.integers(1, side), st.integers(1, side))
    return sides.flatmap(lambda shape: arrays(bool, shape)).filter(np.any)
