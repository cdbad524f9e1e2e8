"""Pictures of spheres that tests of light probes share."""

from __future__ import annotations

import numpy as np

from shading_model.arrays import Float, Image, Mask
from shading_model.illumination import LinearHarmonics
from shading_model.probe_sphere import fit_sphere

SHAPE = (90, 120)
CENTRE = (43.3, 61.8)
RADIUS = 38.0


def sphere_mask(
    shape: tuple[int, int] = SHAPE,
    centre: tuple[float, float] = CENTRE,
    radius: float = RADIUS,
    flattening: float = 0.0,
) -> Mask:
    """Return the pixels whose middle is on a sphere, or on an upright ellipse."""
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    x, y = columns - centre[1], (rows - centre[0]) / (1 - flattening)
    inside: Mask = np.hypot(x, y) < radius
    return inside


def diffuse_picture(light: LinearHarmonics, mask: Mask) -> Image:
    """Return a white sphere's unclamped shading on the circle of its mask, black elsewhere."""
    shape = (mask.shape[0], mask.shape[1])
    picture = light.shade(fit_sphere(mask).normals(shape))
    return np.where(np.isnan(picture), 0.0, picture)


def bright_light(seed: int) -> LinearHarmonics:
    """Return random coefficients of three colours, bright enough to shade without the clamp."""
    coefficients = np.random.default_rng(seed).normal(scale=0.02, size=(9, 3))
    coefficients[0] += 0.5
    return LinearHarmonics(coefficients)


def chrome_picture(direction: Float, mask: Mask, width: float = 0.05) -> Image:
    """Return a mirror sphere in a dim room, with one light `width` radians wide, saturated."""
    normals = fit_sphere(mask).normals((mask.shape[0], mask.shape[1]))
    mirrored = 2 * normals[..., 2:] * normals - np.array([0.0, 0.0, 1.0])
    away = np.arccos(np.clip(mirrored @ direction, -1, 1))
    brightness = np.minimum(1.0, 0.05 + 3 * np.exp(-((away / width) ** 2)))
    return np.where(np.isnan(brightness), 0.0, brightness)[..., None] * np.ones(3)


def degrees_between(first: Float, second: Float) -> float:
    """Return the angle between unit vectors in degrees."""
    return float(np.degrees(np.arccos(np.clip(first @ second, -1.0, 1.0))))
