"""Solids described by their distance functions, and their heights as an orthographic viewer sees.

A distance function takes points (n, 3) as (x right, y up, z toward the viewer) and returns (n,)
distances, negative inside. Unions may understate a distance, never overstate it by much.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from shading_model.arrays import Float, Map

Solid: TypeAlias = Callable[[Float], Float]

_NEAREST, _FARTHEST = 1.4, -1.4
_STEPS = 140
_TOUCH = 2e-4
# Blends, bends and ellipsoids understate distances unevenly; shorter steps cannot pass through.
_STEP_SHARE = 0.85


def ellipsoid(
    centre: tuple[float, float, float], radii: tuple[float, float, float], degrees: float = 0.0
) -> Solid:
    """Return an ellipsoid, turned in the picture plane (anticlockwise).

    Examples
    --------
    >>> ellipsoid((0, 0, 0), (1, 1, 1))(np.array([[2.0, 0.0, 0.0]]))
    array([1.])
    """
    middle, axes = np.array(centre, dtype=np.float64), np.array(radii, dtype=np.float64)
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])

    def distance(points: Float) -> Float:
        scaled = ((points - middle) @ turn.T) / axes
        first = np.linalg.norm(scaled, axis=-1)
        second = np.linalg.norm(scaled / axes, axis=-1)
        found: Float = first * (first - 1.0) / np.maximum(second, 1e-9)
        return found

    return distance


def capsule(
    start: tuple[float, float, float], end: tuple[float, float, float], radius: float
) -> Solid:
    """Return the set of points within `radius` of a segment.

    Examples
    --------
    >>> capsule((0, 0, 0), (0, 1, 0), 0.5)(np.array([[0.0, 2.0, 0.0]]))
    array([0.5])
    """
    first = np.array(start, dtype=np.float64)
    along = np.array(end, dtype=np.float64) - first

    def distance(points: Float) -> Float:
        relative = points - first
        share = np.clip(relative @ along / (along @ along), 0.0, 1.0)
        found: Float = np.linalg.norm(relative - share[:, None] * along, axis=-1) - radius
        return found

    return distance


def ring(radius: float, thickness: float) -> Solid:
    """Return a torus about the z axis.

    Examples
    --------
    >>> ring(1.0, 0.25)(np.array([[1.0, 0.0, 0.0]]))
    array([-0.25])
    """

    def distance(points: Float) -> Float:
        from_circle = np.hypot(points[:, 0], points[:, 1]) - radius
        found: Float = np.hypot(from_circle, points[:, 2]) - thickness
        return found

    return distance


def vessel(base_radius: float, rim_radius: float, half_height: float, wall: float) -> Solid:
    """Return an open cup about the y axis with a wall of the given thickness.

    Examples
    --------
    >>> cup = vessel(0.4, 0.5, 0.5, 0.05)
    >>> bool(cup(np.array([[0.0, 0.2, 0.0]]))[0] > 0)  # the inside is hollow
    True
    """
    lean = (rim_radius - base_radius) / (2.0 * half_height)
    slant = 1.0 / np.hypot(1.0, lean)
    middle = 0.5 * (rim_radius + base_radius)

    def distance(points: Float) -> Float:
        radial = np.hypot(points[:, 0], points[:, 2])
        height = points[:, 1]
        side = (radial - middle - lean * height) * slant
        outer = np.maximum(side, np.abs(height) - half_height)
        hollow = np.maximum(side + wall, wall - half_height - height)
        found: Float = np.maximum(outer, -hollow)
        return found

    return distance


def box(half_sizes: tuple[float, float, float], rounding: float) -> Solid:
    """Return a box about the origin with rounded edges.

    Examples
    --------
    >>> box((1, 1, 1), 0.0)(np.array([[0.0, 3.0, 0.0]]))
    array([2.])
    """
    inner = np.array(half_sizes, dtype=np.float64) - rounding

    def distance(points: Float) -> Float:
        beyond = np.abs(points) - inner
        outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
        found: Float = outside + np.minimum(beyond.max(axis=-1), 0.0) - rounding
        return found

    return distance


def blend(*solids: Solid, reach: float = 0.06) -> Solid:
    """Return the union of solids, fused smoothly where they are within `reach` of each other.

    Examples
    --------
    >>> ball = ellipsoid((0, 0, 0), (1, 1, 1))
    >>> bool(blend(ball, ball)(np.array([[1.0, 0.0, 0.0]]))[0] < 0)
    True
    """

    def distance(points: Float) -> Float:
        nearest = solids[0](points)
        for solid in solids[1:]:
            other = solid(points)
            near = np.maximum(reach - np.abs(nearest - other), 0.0) / reach
            nearest = np.minimum(nearest, other) - near * near * reach * 0.25
        return nearest

    return distance


def placed(
    solid: Solid,
    tilt: float = 0.0,
    turn: float = 0.0,
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Solid:
    """Return the solid turned about the vertical, then its top tilted to the viewer, then moved.

    Parameters
    ----------
    solid : Solid
        Described about the origin.
    tilt, turn : float
        Degrees.
    centre : tuple of three floats
        Where the origin goes.

    Examples
    --------
    >>> tall = placed(box((0.1, 1.0, 0.1), 0.0), tilt=90.0)
    >>> tall(np.array([[0.0, 0.0, 2.0]])).round(6)
    array([1.])
    """
    a, b = np.radians(tilt), np.radians(turn)
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    to_world = about_x @ about_y
    origin = np.array(centre, dtype=np.float64)

    def distance(points: Float) -> Float:
        return solid((points - origin) @ to_world)

    return distance


def seen_height(solid: Solid, x: Map, y: Map) -> Map:
    """Return the z of the first surface point on each line of sight, NaN where there is none.

    Parameters
    ----------
    solid : Solid
        Inside the cube from -1.4 to 1.4.
    x, y : (h, w) arrays
        Where the lines of sight meet the picture plane.

    Returns
    -------
    (h, w) array

    Examples
    --------
    >>> ball = ellipsoid((0, 0, 0), (1, 1, 1))
    >>> seen_height(ball, np.array([[0.0, 2.0]]), np.array([[0.0, 0.0]])).round(3)
    array([[ 1., nan]])
    """
    flat_x, flat_y = np.ravel(x), np.ravel(y)
    depth = np.full(flat_x.size, _NEAREST)
    found = np.full(flat_x.size, np.nan)
    active = np.arange(flat_x.size)
    for _ in range(_STEPS):
        points = np.stack([flat_x[active], flat_y[active], depth[active]], axis=-1)
        distance = solid(points)
        hit = distance < _TOUCH
        found[active[hit]] = depth[active[hit]] - distance[hit]
        depth[active] -= _STEP_SHARE * distance
        active = active[~hit & (depth[active] > _FARTHEST)]
        if active.size == 0:
            break
    return found.reshape(np.shape(x))
