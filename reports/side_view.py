"""Surfaces of white clay seen from aside: height maps, turned and drawn without perspective.

Turned about the vertical, a height map keeps every point in its row. So each row is a line of its
own that hides itself, and no general renderer is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from reports.pictures import Picture, photograph_picture
from shading_model.arrays import Float, Map, Mask, Normals

LAMP = (-0.4, 0.5, 0.77)
"""Direction to the lamp, which goes with the viewer: right, up, toward the viewer."""
AMBIENT, BRIGHTEST, BACK = 0.12, 0.85, 0.35
"""Light from everywhere, what the lamp adds up to, and the share of it on the surface's back."""
TURN = np.deg2rad(50)
"""How far the viewer goes around the object."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface to be seen.

    Parameters
    ----------
    height : (h, w) array
        Pixels, larger is nearer to the camera; NaN outside.
    normals : (h, w, 3) array
    """

    height: Map
    normals: Normals


def clay_pictures(surfaces: Sequence[Surface], side: str) -> tuple[Picture, ...]:
    """Return surfaces as white clay, seen from one side at one scale, in pictures of one size.

    Heights are compared by their medians, since their offset is arbitrary. Pictures have the
    proportions of the maps.

    Parameters
    ----------
    surfaces : sequence of Surface
        Of one size, each with at least one finite height.
    side : {"front", "left", "below"}

    Returns
    -------
    tuple of (k, l, 4) uint8 arrays

    Examples
    --------
    >>> up = np.broadcast_to([0.0, 0.0, 1.0], (4, 6, 3))
    >>> (picture,) = clay_pictures([Surface(np.zeros((4, 6)), up)], "front")
    >>> picture.shape
    (4, 6, 4)
    """
    upright = [_upright(surface, side) for surface in surfaces]
    turn = 0.0 if side == "front" else TURN
    places = [_turned(height, turn) for height, _ in upright]
    left, right = (
        reach(np.nanmin(across) if low else np.nanmax(across) for across, _ in places)
        for low, reach in ((True, min), (False, max))
    )
    width = int(np.ceil(right - left)) + 1
    seen = [
        _visible(across - left, depth, shade, width)
        for (across, depth), (_, shade) in zip(places, upright, strict=True)
    ]
    proportions = surfaces[0].height.shape
    back = [shade.T[::-1] if side == "below" else shade for shade in seen]
    return tuple(photograph_picture(_padded(shade, proportions), 1.0) for shade in back)


def _upright(surface: Surface, side: str) -> tuple[Map, Map]:
    """Return height and brightness so that the side looked at is on the left."""
    height = surface.height - np.nanmedian(surface.height)
    shade = _clay(surface.normals, side)
    return (height[::-1].T, shade[::-1].T) if side == "below" else (height, shade)


def _clay(normals: Normals, side: str) -> Map:
    """Return the brightness of white clay under the lamp, the back of the surface darker."""
    cosine, sine = np.cos(TURN), np.sin(TURN)
    right, up, toward = {
        "front": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        "left": ((cosine, 0, sine), (0, 1, 0), (-sine, 0, cosine)),
        "below": ((1, 0, 0), (0, cosine, sine), (0, -sine, cosine)),
    }[side]
    lamp = np.array(LAMP) @ np.array([right, up, toward], dtype=np.float64)
    facing = normals @ np.array(toward, dtype=np.float64)
    lit = np.maximum(np.where(facing >= 0, 1.0, -1.0) * (normals @ lamp), 0.0)
    shade: Map = (AMBIENT + (BRIGHTEST - AMBIENT) * lit) * np.where(facing >= 0, 1.0, BACK)
    return shade


def _turned(height: Map, angle: float) -> tuple[Map, Map]:
    """Return how far right each point is seen, and how near, by a viewer gone left by an angle."""
    across = np.arange(height.shape[1], dtype=np.float64)
    cosine, sine = np.cos(angle), np.sin(angle)
    return across * cosine + height * sine, height * cosine - across * sine


def _visible(across: Map, depth: Map, shade: Map, width: int) -> Map:
    """Return the brightness of what is nearest at each place, NaN where nothing is."""
    known: Mask = np.asarray(np.isfinite(across) & np.isfinite(shade))
    rows, columns = np.nonzero(known[:, :-1] & known[:, 1:])
    ends = [(values[rows, columns], values[rows, columns + 1]) for values in (across, depth, shade)]
    counts = np.ceil(np.abs(ends[0][1] - ends[0][0])).astype(int) + 1
    owner = np.repeat(np.arange(rows.size), counts)
    first = np.cumsum(counts) - counts
    share = (np.arange(owner.size) - first[owner]) / np.maximum(counts[owner] - 1, 1)
    place, near, bright = (a[owner] + share * (b - a)[owner] for a, b in ends)
    order = np.argsort(near, kind="stable")  # the nearest is drawn last
    canvas = np.full((across.shape[0], width), np.nan)
    canvas[rows[owner][order], np.rint(place[order]).astype(int)] = bright[order]
    return canvas


def _padded(shade: Map, proportions: tuple[int, ...]) -> Float:
    """Return a map in the middle of the smallest canvas of these proportions that holds it."""
    scale = max(own / given for own, given in zip(shade.shape, proportions, strict=True))
    shape = [
        max(own, round(scale * given)) for own, given in zip(shade.shape, proportions, strict=True)
    ]
    canvas = np.full(shape, np.nan)
    top, left = ((whole - own) // 2 for whole, own in zip(shape, shade.shape, strict=True))
    canvas[top : top + shade.shape[0], left : left + shade.shape[1]] = shade
    return canvas
