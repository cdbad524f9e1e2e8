"""Procedural animals: unions of parts, with warts, plates, feathers, fur and scales.

See `datasets.synthetic_shapes` for what a shape is.
"""

from __future__ import annotations

import numpy as np

from datasets.synthetic_patterns import bump, cells, grooves, smooth_noise, smooth_step
from datasets.synthetic_solids import blend, capsule, ellipsoid, seen_height
from shading_model.arrays import Map


def frog(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a squatting frog with a warty skin.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    parts = [
        ellipsoid((0.0, -0.12, 0.0), (0.52, 0.46, 0.42)),
        ellipsoid((0.0, 0.28, 0.14), (0.42, 0.28, 0.34)),
    ]
    for side in (-1.0, 1.0):
        parts += [
            ellipsoid((0.24 * side, 0.50, 0.26), (0.13, 0.14, 0.13)),
            ellipsoid((0.56 * side, -0.32, 0.04), (0.24, 0.32, 0.26), -24.0 * side),
            ellipsoid((0.66 * side, -0.62, 0.18), (0.24, 0.08, 0.12), 8.0 * side),
            capsule((0.26 * side, -0.1, 0.36), (0.30 * side, -0.58, 0.38), 0.09),
        ]
    warts = np.maximum(smooth_noise(x, y, 7.5, generator) - 0.6, 0.0)
    mouth = 0.03 * grooves(_arc(x, y, 0.24), 30.0) * (np.abs(x) < 0.32) * (np.abs(y - 0.22) < 0.1)
    return seen_height(blend(*parts), x, y) + 0.014 * warts + mouth


def turtle(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a turtle from above: a plated dome, a head, four legs and a tail.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    parts = [
        ellipsoid((0.0, -0.04, 0.04), (0.56, 0.60, 0.44)),
        ellipsoid((0.0, 0.72, 0.06), (0.17, 0.20, 0.17)),
        capsule((0.0, -0.6, 0.0), (0.06, -0.86, 0.0), 0.05),
    ]
    for side in (-1.0, 1.0):
        parts += [
            ellipsoid((0.56 * side, 0.42, 0.0), (0.30, 0.13, 0.12), 30.0 * side),
            ellipsoid((0.52 * side, -0.46, 0.0), (0.25, 0.13, 0.12), -38.0 * side),
        ]
    _, border = cells(x, y, 80, generator, wobble=0.012)
    plates = 0.035 * smooth_step(border, 0.045) * smooth_step(0.52 - np.hypot(x, y + 0.04), 0.05)
    return seen_height(blend(*parts, reach=0.04), x, y) + plates


def duck(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a duck in profile with a folded wing of rows of feathers.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    solid = blend(
        ellipsoid((-0.06, -0.28, 0.0), (0.66, 0.42, 0.42), 6.0),
        capsule((0.34, -0.1, 0.0), (0.40, 0.38, 0.0), 0.18),
        ellipsoid((0.44, 0.50, 0.02), (0.25, 0.24, 0.23)),
        ellipsoid((0.72, 0.44, 0.02), (0.19, 0.07, 0.12), -8.0),
        ellipsoid((-0.70, -0.08, 0.0), (0.22, 0.12, 0.14), 152.0),
        ellipsoid((-0.14, -0.22, 0.34), (0.40, 0.24, 0.14), 8.0),
        reach=0.09,
    )
    wing = smooth_step(1.0 - np.hypot((x + 0.14) / 0.40, (y + 0.22) / 0.24), 0.4)
    rows = 0.016 * grooves(5.0 * x - 4.0 * np.abs(y + 0.22) + 0.4, 4.0) * wing
    return seen_height(solid, x, y) + rows + 0.003 * smooth_noise(x, y, 8.0, generator)


def bear(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a sitting toy bear with a knitted coat.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    parts = [
        ellipsoid((0.0, -0.28, 0.0), (0.44, 0.46, 0.38)),
        ellipsoid((0.0, 0.42, 0.06), (0.37, 0.34, 0.33)),
        ellipsoid((0.0, 0.33, 0.36), (0.17, 0.13, 0.14)),
        ellipsoid((0.0, 0.39, 0.49), (0.06, 0.045, 0.05)),
    ]
    for side in (-1.0, 1.0):
        parts += [
            ellipsoid((0.29 * side, 0.72, 0.0), (0.14, 0.14, 0.10)),
            ellipsoid((0.50 * side, -0.14, 0.16), (0.16, 0.33, 0.17), 32.0 * side),
            ellipsoid((0.36 * side, -0.66, 0.28), (0.20, 0.22, 0.24), -14.0 * side),
        ]
    knit = (
        0.006 * grooves(15.0 * x + 0.5 * np.round(11.0 * y), 2.0) * np.abs(np.cos(11 * np.pi * y))
    )
    return seen_height(blend(*parts, reach=0.05), x, y) + knit + _fur(x, y, generator)


def fish(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a fish in profile with rows of scales and rayed fins.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    solid = blend(
        ellipsoid((0.12, 0.0, 0.0), (0.66, 0.36, 0.26)),
        ellipsoid((-0.46, 0.0, 0.0), (0.26, 0.13, 0.11)),
        ellipsoid((-0.70, 0.17, 0.0), (0.27, 0.12, 0.05), 128.0),
        ellipsoid((-0.70, -0.17, 0.0), (0.27, 0.12, 0.05), -128.0),
        ellipsoid((0.10, 0.36, 0.0), (0.34, 0.15, 0.05), -8.0),
        ellipsoid((0.16, -0.12, 0.22), (0.19, 0.08, 0.05), -30.0),
        ellipsoid((0.58, 0.08, 0.16), (0.055, 0.055, 0.05)),
        reach=0.05,
    )
    row, column = np.round(13.0 * y), 10.0 * x
    scale = np.hypot(np.mod(column + 0.5 * np.mod(row, 2.0), 1.0) - 0.2, 13.0 * y - row)
    on_body = smooth_step(1.0 - np.hypot((x - 0.05) / 0.45, y / 0.33), 0.25)
    scales = 0.020 * np.maximum(1.0 - scale, 0.0) * on_body
    return seen_height(solid, x, y) + scales + 0.002 * smooth_noise(x, y, 8.0, generator)


def rabbit(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a sitting rabbit with long ears and a furry coat.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    parts = [
        ellipsoid((0.0, -0.36, 0.0), (0.42, 0.44, 0.38)),
        ellipsoid((0.0, 0.18, 0.12), (0.30, 0.28, 0.29)),
        ellipsoid((0.0, 0.10, 0.40), (0.12, 0.09, 0.08)),
    ]
    for side in (-1.0, 1.0):
        parts += [
            ellipsoid((0.19 * side, 0.63, 0.04), (0.10, 0.31, 0.07), -12.0 * side),
            ellipsoid((0.34 * side, -0.52, 0.14), (0.19, 0.25, 0.24)),
            ellipsoid((0.28 * side, -0.80, 0.30), (0.17, 0.09, 0.19)),
            capsule((0.14 * side, -0.25, 0.34), (0.12 * side, -0.62, 0.40), 0.085),
        ]
    hollow = sum(bump(x, y, (0.19 * side, 0.64), (0.05, 0.2)) for side in (-1.0, 1.0))
    return seen_height(blend(*parts), x, y) - 0.05 * hollow + 1.4 * _fur(x, y, generator)


def _arc(x: Map, y: Map, level: float) -> Map:
    return y - level + 0.35 * x * x


def _fur(x: Map, y: Map, generator: np.random.Generator) -> Map:
    return 0.004 * smooth_noise(x + 0.3 * y, 0.45 * y, 14.0, generator)
