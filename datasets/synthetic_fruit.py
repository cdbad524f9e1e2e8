"""Procedural fruit: smooth round bodies with stems, ribs, lumps and pitted skins.

See `datasets.synthetic_shapes` for what a shape is.
"""

from __future__ import annotations

import numpy as np

from datasets.synthetic_patterns import cells, smooth_noise, smooth_step
from datasets.synthetic_solids import blend, capsule, ellipsoid, placed, seen_height
from shading_model.arrays import Float, Map


def apple(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a round body dented at the stem, with faint dimples.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """

    def body(points: Float) -> Float:
        radius = np.linalg.norm(points, axis=-1)
        up = points[:, 1] / np.maximum(radius, 1e-9)
        dent = 0.34 * np.exp(-((1.0 - up) / 0.10)) + 0.10 * np.exp(-((1.0 + up) / 0.08))
        surface = 0.74 - dent + 0.04 * up
        distance: Float = 0.45 * (radius - surface)
        return distance

    stem = capsule((0.0, 0.36, 0.0), (0.07, 0.72, 0.05), 0.035)
    height = seen_height(blend(placed(body, tilt=28.0), placed(stem, tilt=28.0)), x, y)
    return height + 0.0012 * smooth_noise(x, y, 7.0, generator)


def pear(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a large and a small ball fused, with a stem and a pitted skin.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    solid = blend(
        ellipsoid((0.0, -0.28, 0.0), (0.56, 0.52, 0.54)),
        ellipsoid((0.05, 0.32, 0.0), (0.30, 0.36, 0.30)),
        reach=0.35,
    )
    stem = capsule((0.06, 0.60, 0.0), (0.14, 0.85, 0.02), 0.03)
    pits = np.maximum(smooth_noise(x, y, 12.0, generator) - 0.8, 0.0)
    return seen_height(blend(solid, stem), x, y) - 0.008 * pits


def potato(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a lumpy ellipsoid with eyes.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    solid = blend(
        ellipsoid((-0.2, 0.02, 0.0), (0.62, 0.44, 0.44), 12.0),
        ellipsoid((0.34, 0.06, 0.02), (0.48, 0.40, 0.40), -20.0),
        reach=0.3,
    )
    lumps = 0.018 * smooth_noise(x, y, 1.8, generator) + 0.0015 * smooth_noise(x, y, 8.0, generator)
    _, border = cells(x, y, 16, generator)
    eyes = -0.035 * smooth_step(border - border.max() * 0.55, 0.08)
    return seen_height(solid, x, y) + lumps + eyes


def pumpkin(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a flattened ball with ribs that run from stem to base.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """

    def body(points: Float) -> Float:
        scaled = points / np.array([0.86, 0.64, 0.86])
        radius = np.linalg.norm(scaled, axis=-1)
        angle = np.arctan2(points[:, 0], points[:, 2])
        away = np.hypot(scaled[:, 0], scaled[:, 2]) / np.maximum(radius, 1e-9)
        ribs = 0.055 * np.abs(np.cos(5.0 * angle)) * away
        distance: Float = 0.38 * (radius - 0.93 - ribs + 0.2 * (1.0 - away) ** 2)
        return distance

    stem = capsule((0.0, 0.45, 0.0), (-0.08, 0.78, 0.06), 0.07)
    height = seen_height(blend(placed(body, tilt=20.0), placed(stem, tilt=20.0)), x, y)
    return height + 0.0015 * smooth_noise(x, y, 8.0, generator)
