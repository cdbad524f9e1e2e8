"""Twenty procedural objects of the kinds photographed for MIT-Berkeley: their heights.

Fruit, folded paper, carved relief, thin-walled cups and animals joined of parts, each with a
meso-structure of bumps or grooves. A shape is a function of picture coordinates (-1 to 1, y up)
and a generator; it returns heights in the same unit, NaN off the object.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from scipy import ndimage

from datasets.synthetic_animals import bear, duck, fish, frog, rabbit, turtle
from datasets.synthetic_fruit import apple, pear, potato, pumpkin
from datasets.synthetic_patterns import (
    grooves,
    on_object,
    smooth_noise,
    turned,
)
from datasets.synthetic_reliefs import leaf, medal, shell, sun
from datasets.synthetic_solids import (
    box,
    placed,
    ring,
    seen_height,
    vessel,
)
from shading_model.arrays import Float, Map

Shape: TypeAlias = Callable[[Map, Map, np.random.Generator], Map]


def picture_coordinates(size: int) -> tuple[Map, Map]:
    """Return the x (right) and y (up) of pixel centres of a square picture from -1 to 1.

    Examples
    --------
    >>> x, y = picture_coordinates(2)
    >>> x[0].tolist(), y[:, 0].tolist()
    ([-0.5, 0.5], [0.5, -0.5])
    """
    centres = (np.arange(size) + 0.5) * 2.0 / size - 1.0
    x, y = np.meshgrid(centres, -centres)
    return x, y


# --- paper and cardboard -------------------------------------------------------------------


def folded_paper(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a sheet folded like an accordion, its outline cut by the folds.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    turned_x, turned_y = turned(x, y, 14.0)
    phase = 2.1 * turned_x + 0.25
    zigzag = 2.0 * np.abs(phase - np.round(phase))
    edge = 0.62 + 0.05 * zigzag
    inside = (np.abs(turned_x) < 0.84) & (np.abs(turned_y) < edge)
    fine = 0.0025 * smooth_noise(x, y, 6.0, generator)
    return on_object(inside, 0.26 * zigzag + 0.10 * turned_y * zigzag + fine)


def crumpled_paper(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a sheet creased along many random straight lines.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    turned_x, turned_y = turned(x, y, -9.0)
    height = np.zeros(x.shape)
    for index in range(26):
        angle, offset = generator.uniform(0.0, np.pi), generator.uniform(-0.7, 0.7)
        along = np.cos(angle) * x + np.sin(angle) * y - offset
        height += generator.choice([-1.0, 1.0]) * (0.34 / (1.0 + 0.30 * index)) * np.abs(along)
    outline = 0.78 + 0.015 * smooth_noise(x, y, 2.0, generator)
    inside = (np.abs(turned_x) < outline) & (np.abs(turned_y) < 0.84 * outline)
    return on_object(inside, height)


def teabag(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a pillow with a crimped border and a grainy filling.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    turned_x, turned_y = turned(x, y, 22.0)
    u, v = turned_x / 0.66, turned_y / 0.74
    inside = (np.abs(u) < 1.0) & (np.abs(v) < 1.0)
    swell = np.maximum((1.0 - (u / 0.88) ** 4) * (1.0 - (v / 0.86) ** 4), 0.0) ** 0.6
    swell *= (np.abs(u) < 0.88) & (np.abs(v) < 0.86)
    crimp = 0.012 * np.cos(2 * np.pi * 9.0 * np.where(np.abs(v) > np.abs(u), u, v)) * (1 - swell)
    grain = 0.010 * swell * smooth_noise(x, y, 6.5, generator)
    folds = 0.03 * swell * smooth_noise(x, y, 1.6, generator)
    return on_object(inside, 0.30 * swell + crimp + grain + folds)


def carton(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a box seen over a corner, with pressed panels.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    solid = placed(box((0.44, 0.58, 0.40), 0.03), tilt=24.0, turn=38.0)
    height = seen_height(solid, x, y)
    dents = 0.003 * smooth_noise(x, y, 2.5, generator)
    return height + dents + 0.010 * grooves(4.0 * y + 1.2 * np.abs(x + 0.06), 8.0)


# --- cups ----------------------------------------------------------------------------------


def cup(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a thin-walled beaker tilted to show its inside, with rings around the wall.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    solid = placed(vessel(0.40, 0.56, 0.58, 0.05), tilt=32.0)
    rings = 0.006 * grooves(6.0 * (y + 0.22 * x * x), 6.0)
    return seen_height(solid, x, y) + rings + 0.0007 * smooth_noise(x, y, 6.0, generator)


def mug(x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return a mug with a handle that leaves a hole.

    Returns
    -------
    (h, w) array
        Heights, NaN off the object.
    """
    body = vessel(0.46, 0.48, 0.54, 0.055)
    handle = placed(ring(0.27, 0.06), centre=(0.58, 0.0, 0.0))
    foot = placed(ring(0.40, 0.05), tilt=90.0, centre=(0.0, -0.54, 0.0))

    def joined(points: Float) -> Float:
        inside = 0.44 - np.hypot(points[:, 0], points[:, 2])
        outer_handle = np.maximum(handle(points), inside)
        return np.minimum(np.minimum(body(points), foot(points)), outer_handle)

    height = seen_height(placed(joined, tilt=26.0, turn=-18.0, centre=(-0.12, 0.0, 0.0)), x, y)
    return height + 0.0008 * smooth_noise(x, y, 5.0, generator)


SHAPES: dict[str, Shape] = {
    shape.__name__: shape
    for shape in (
        apple,
        pear,
        potato,
        pumpkin,
        folded_paper,
        crumpled_paper,
        teabag,
        carton,
        sun,
        medal,
        leaf,
        shell,
        cup,
        mug,
        frog,
        turtle,
        duck,
        bear,
        fish,
        rabbit,
    )
}
"""Every object's shape by name."""


def shape_height(name: str, size: int, generator: np.random.Generator) -> Map:
    """Return an object's height map: one component, in pixels, NaN off the object.

    Parameters
    ----------
    name : str
        A key of `SHAPES`.
    size : int
        Side of the square picture, in pixels.
    generator : numpy.random.Generator
        For the random parts of the shape.

    Returns
    -------
    (size, size) array
        Larger is nearer; the offset is arbitrary.

    Examples
    --------
    >>> height = shape_height("medal", 32, np.random.default_rng(0))
    >>> height.shape, bool(np.isfinite(height[16, 16])), bool(np.isnan(height[0, 0]))
    ((32, 32), True, True)
    """
    x, y = picture_coordinates(size)
    return _largest_component(_without_pinholes(SHAPES[name](x, y, generator))) * (size / 2.0)


def _without_pinholes(height: Map) -> Map:
    """Fill holes of a few pixels, where a line of sight grazed past a crease."""
    holes, count = ndimage.label(np.isnan(height))
    sizes = ndimage.sum_labels(np.ones(height.shape), holes, np.arange(count + 1))
    small = (holes > 0) & (sizes[holes] <= max(2.0, 2e-4 * height.size))
    nearest = ndimage.distance_transform_edt(
        np.isnan(height), return_distances=False, return_indices=True
    )
    return np.where(small, height[tuple(nearest)], height)


def _largest_component(height: Map) -> Map:
    parts, count = ndimage.label(np.isfinite(height))
    sizes = ndimage.sum_labels(np.ones(height.shape), parts, np.arange(1, count + 1))
    return on_object(parts == 1 + int(np.argmax(sizes)), height)
