"""Procedural carved reliefs: flat pieces with an outline, rounded off toward their edge.

See `datasets.synthetic_shapes` for what a shape is.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from datasets.synthetic_patterns import (
    bump,
    grooves,
    on_object,
    smooth_noise,
    smooth_step,
    turned,
)
from shading_model.arrays import Map, Mask


def sun(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a carved sun: a face on a dome, in a wreath of rays.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    radius, angle = np.hypot(x, y), np.arctan2(x, y)
    wave = 12.0 * angle / (2.0 * np.pi)
    ray = 1.0 - 2.0 * np.abs(wave - np.round(wave))
    inside = radius < 0.60 + 0.32 * ray**1.3
    rays = 0.05 + 0.16 * ray * smooth_step(0.98 - radius, 0.5)
    dome = 0.14 + 0.36 * np.sqrt(np.maximum(1.0 - (radius / 0.58) ** 2, 0.0))
    height = np.where(radius < 0.56, np.maximum(dome, rays), rays)
    features = bump(x, y, (0.0, -0.02), (0.07, 0.16)) * 0.13
    for side in (-1.0, 1.0):
        features += 0.09 * bump(x, y, (0.30 * side, -0.16), (0.13, 0.11))
        features -= 0.09 * bump(x, y, (0.20 * side, 0.13), (0.085, 0.05))
        features += 0.06 * bump(x, y, (0.20 * side, 0.24), (0.13, 0.03))
    smile = y + 0.30 - 0.55 * x * x
    features -= 0.07 * np.exp(-((smile / 0.025) ** 2)) * (np.abs(x) < 0.24)
    return bevelled(inside, height + features + 0.003 * smooth_noise(x, y, 9.0, generator), 0.06)


def medal(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a coin with a raised rim, a star and a ring of beads.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    radius, angle = np.hypot(x, y), np.arctan2(x, y)
    rim = 0.10 * (smooth_step(radius - 0.74, 0.04) - smooth_step(radius - 0.84, 0.05))
    spoke = 5.0 * angle / (2.0 * np.pi)
    pointed = 1.0 - 2.0 * np.abs(spoke - np.round(spoke))
    inside_star = (0.22 + 0.34 * pointed) - radius
    star = 0.14 * smooth_step(inside_star, 0.14) * (0.6 + 0.4 * pointed)
    bead_angle = np.mod(angle, np.pi / 16.0) - np.pi / 32.0
    bead = np.hypot(radius - 0.67, 0.67 * bead_angle) / 0.045
    beads = 0.05 * np.sqrt(np.maximum(1.0 - bead**2, 0.0))
    wear = 0.003 * smooth_noise(x, y, 7.0, generator)
    return bevelled(radius < 0.88, 0.10 * (1.0 - radius**2) + rim + star + beads + wear, 0.07)


def leaf(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a curled leaf with a midrib and side veins.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    turned_x, turned_y = turned(x, y, -32.0)
    share = (turned_y + 0.92) / 1.84
    width = 0.58 * np.sin(np.pi * np.clip(share, 0.0, 1.0) ** 0.8) ** 0.85
    width *= 1.0 + 0.05 * np.cos(2.0 * np.pi * 11.0 * share)
    inside = (np.abs(turned_x) < width) & (share > 0.0) & (share < 1.0)
    curl = 0.34 * turned_x**2 + 0.22 * np.sin(2.4 * turned_y + 0.6)
    veins = grooves(6.5 * share - 3.6 * np.abs(turned_x), 7.0) * smooth_step(width, 0.2)
    midrib = 0.05 * np.exp(-((turned_x / 0.035) ** 2))
    quilting = 0.006 * smooth_noise(x, y, 6.0, generator)
    return bevelled(inside, curl + midrib + 0.022 * veins + quilting, 0.03)


def shell(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a scallop: ribs that fan out of the hinge over a dome, and growth rings.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    low_y = y + 0.62
    radius, angle = np.hypot(x, low_y), np.arctan2(x, low_y)
    fan = np.clip(angle / 0.98, -1.0, 1.0)
    reach = 1.30 * np.cos(0.62 * fan) ** 0.5 + 0.03 * np.cos(2.0 * np.pi * 6.5 * fan)
    inside = (radius < reach) & (np.abs(angle) < 0.98)
    share = radius / reach
    dome = 0.55 * np.sqrt(np.maximum(share * (1.0 - share**3), 0.0)) * (1.0 - 0.75 * fan**4)
    ribs = 0.035 * share * np.abs(np.cos(np.pi * 6.5 * fan))
    rings = 0.008 * grooves(6.0 * share, 5.0)
    grain = 0.002 * smooth_noise(x, y, 10.0, generator)
    return bevelled(inside, dome + ribs + rings + grain, 0.05)


def bevelled(inside: Mask, height: Map, width: float) -> Map:
    """Return the height rounded off toward the outline over `width`, NaN outside `inside`.

    Examples
    --------
    >>> inside = np.zeros((5, 5), bool)
    >>> inside[1:4, 1:4] = True
    >>> rounded = bevelled(inside, np.zeros((5, 5)), 0.8)
    >>> bool(rounded[2, 2] > rounded[1, 2]), bool(np.isnan(rounded[0, 0]))
    (True, True)
    """
    pixel = 2.0 / inside.shape[0]
    from_edge = np.clip(ndimage.distance_transform_edt(inside) * pixel / width, 0.0, 1.0)
    return on_object(inside, height + 0.8 * width * np.sqrt(1.0 - (1.0 - from_edge) ** 2))
