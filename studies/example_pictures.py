"""Pictures for the example study, computed: a blob on a floor, as six methods might insert it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw
from scipy import ndimage

from shading_model.seeds import generator_for

Array = npt.NDArray[np.float64]

WIDTH, HEIGHT = 400, 300
HORIZON = 160
"""Row where the wall meets the floor."""


@dataclass(frozen=True)
class Insertion:
    """How a method's picture of a scene differs from the real one.

    Parameters
    ----------
    detail : float
        Weight of the surface's bumps in its shading.
    texture : float
        Weight of the surface's pattern.
    turn : float
        Radians by which the light is wrong.
    shadow : float
        Strength of the cast shadow.
    softness : float
        Its blur in pixels.
    gloss : float
        Strength of a highlight.
    """

    detail: float = 1.0
    texture: float = 1.0
    turn: float = 0.0
    shadow: float = 0.55
    softness: float = 9.0
    gloss: float = 0.0


INSERTIONS = {
    "real": Insertion(),
    "ours": Insertion(detail=0.8, turn=0.25, softness=11.0),
    "one-layer": Insertion(detail=0.4, turn=0.25, softness=11.0),
    "no-detail": Insertion(detail=0.0, turn=0.25, softness=11.0),
    "barron-malik": Insertion(detail=0.15, texture=0.8, turn=0.6, softness=14.0),
    "karsch": Insertion(detail=0.0, texture=0.0, turn=0.1, softness=4.0, gloss=0.5),
}
"""The conditions of the example study; its answers to them mean nothing."""


def scene_picture(scene: str, insertion: Insertion) -> Image.Image:
    """Return a picture of a scene with its object inserted.

    Parameters
    ----------
    scene : str
        Its name decides room, object, pattern and light.
    insertion : Insertion

    Returns
    -------
    PIL.Image.Image
        RGB, 400 x 300 pixels.

    Examples
    --------
    >>> scene_picture("scene-01", INSERTIONS["ours"]).size
    (400, 300)
    """
    return Image.fromarray(_eight_bits(_picture(_scene(scene), insertion)))


def cartoon_picture(scene: str) -> Image.Image:
    """Return the scene in a few flat colors with black outlines.

    Parameters
    ----------
    scene : str

    Returns
    -------
    PIL.Image.Image
        RGB, 400 x 300 pixels.

    Examples
    --------
    >>> len(cartoon_picture("scene-01").getcolors(400 * 300)) < 40
    True
    """
    plain = _picture(_scene(scene), Insertion(detail=0.0, texture=0.0, softness=1.0), roughness=0)
    flat = np.round(plain * 5) / 5
    brightness: Array = flat.sum(axis=-1)
    edges = ndimage.morphological_gradient(brightness, size=(3, 3)) > 0.1
    return Image.fromarray(_eight_bits(np.where(edges[..., None], 0.0, flat)))


def spheres_picture(*, plausible: bool) -> Image.Image:
    """Return three spheres under one light, or one of them lit from the other side.

    Parameters
    ----------
    plausible : bool

    Returns
    -------
    PIL.Image.Image
        RGB, 400 x 300 pixels.

    Examples
    --------
    >>> spheres_picture(plausible=True) == spheres_picture(plausible=False)
    False
    """
    picture = _room(np.array([0.72, 0.70, 0.68]), np.array([0.62, 0.60, 0.58]))
    colors = ((0.75, 0.35, 0.30), (0.35, 0.60, 0.40), (0.35, 0.45, 0.75))
    for number, color in enumerate(colors):
        turned = number == 1 and not plausible
        light = _light(np.pi - 0.7 if turned else 0.7)
        height = _dome((90 + 110 * number, 205), 44, 1.0)
        picture = _insert(picture, height, np.array(color), light, Insertion())
    return Image.fromarray(_eight_bits(picture))


def perspective_picture(*, plausible: bool) -> Image.Image:
    """Return a line drawing of a street whose lines meet in one point, or do not.

    Parameters
    ----------
    plausible : bool

    Returns
    -------
    PIL.Image.Image
        RGB, 400 x 300 pixels.

    Examples
    --------
    >>> perspective_picture(plausible=True).size
    (400, 300)
    """
    scale = 3
    picture = Image.new("RGB", (WIDTH * scale, HEIGHT * scale), "white")
    draw = ImageDraw.Draw(picture)

    def line(start: tuple[float, float], end: tuple[float, float]) -> None:
        draw.line([(x * scale, y * scale) for x, y in (start, end)], fill="black", width=5)

    meet = (210.0, 140.0)
    # The implausible roofs run to points of their own, one above and one below the horizon.
    ends = {"left": meet, "right": meet} if plausible else {"left": (210, 50), "right": (210, 220)}
    for side, x, depths in (("left", 15.0, (0, 0.3, 0.55)), ("right", 385.0, (0, 0.35, 0.6))):
        for base, end in ((270.0, meet), (50.0, ends[side])):
            line((x, base), _between((x, base), end, depths[-1]))
        for depth in depths:
            line(_between((x, 270.0), meet, depth), _between((x, 50.0), ends[side], depth))
    line((0, meet[1]), (WIDTH, meet[1]))
    for x in (125.0, 295.0):
        line((x, HEIGHT), _between((x, HEIGHT), meet, 0.9))
    return picture.resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS)


CLOSING_PICTURES: dict[str, Callable[..., Image.Image]] = {
    "spheres": spheres_picture,
    "perspective": perspective_picture,
}


def _between(
    start: tuple[float, float], end: tuple[float, float], share: float
) -> tuple[float, float]:
    return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])


@dataclass(frozen=True)
class _Scene:
    """What every method's picture of a scene has in common."""

    room: Array
    height: Array
    color: Array
    angle: float
    smooth: Array
    fine: Array


@cache
def _scene(name: str) -> _Scene:
    generator = generator_for("example picture", name)
    wall, floor, color = generator.uniform(0.3, 0.8, (3, 3))
    wall, floor = (0.3 * one + 0.7 * one.mean() for one in (wall, floor))
    angle = float(generator.uniform(0.4, 2.7))
    center = (float(generator.uniform(130, 270)), float(generator.uniform(175, 205)))
    height = _dome(center, float(generator.uniform(60, 80)), float(generator.uniform(0.8, 1.1)))
    noise = generator.normal(size=(2, HEIGHT, WIDTH))
    smooth = ndimage.gaussian_filter(noise[0], 9)
    fine = ndimage.gaussian_filter(noise[1], 2)
    return _Scene(_room(wall, floor), height, color, angle, smooth, fine)


def _picture(scene: _Scene, insertion: Insertion, roughness: float = 1.0) -> Array:
    pattern = np.clip(1 + insertion.texture * 4 * scene.smooth, 0.5, 1.5)[..., None]
    room = scene.room * (1 + 0.25 * roughness * scene.fine[..., None])
    bumps = 9 * insertion.detail * scene.fine
    light = _light(scene.angle + insertion.turn)
    return _insert(room, scene.height, scene.color * pattern, light, insertion, bumps)


def _room(wall: Array, floor: Array) -> Array:
    """Return a wall above a floor, both darker away from the middle."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    dimming = 1.05 - 0.5 * ((columns / WIDTH - 0.5) ** 2 + (rows / HEIGHT - 0.5) ** 2)
    on_floor = ndimage.gaussian_filter((rows >= HORIZON).astype(float), 1)[..., None]
    room: Array = (on_floor * floor + (1 - on_floor) * wall) * dimming[..., None]
    return room


def _dome(center: tuple[float, float], radius: float, flatness: float) -> Array:
    """Return the height of a dome in pixels, zero beside it."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    squared = ((columns - center[0]) / radius) ** 2 + (
        (rows - center[1]) / (radius * flatness)
    ) ** 2
    height: Array = radius * np.sqrt(np.clip(1 - squared, 0, None))
    return height


def _light(angle: float) -> Array:
    direction = np.array([np.cos(angle), 0.9 * np.sin(angle), 0.8])
    unit: Array = direction / np.linalg.norm(direction)
    return unit


def _insert(
    room: Array,
    height: Array,
    albedo: Array,
    light: Array,
    insertion: Insertion,
    bumps: Array | float = 0.0,
) -> Array:
    """Return the room with a shaded dome in it and the shadow that it casts."""
    down, right = np.gradient(height + bumps * (height > 0))
    normals = np.stack([-right, down, np.ones_like(height)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    lit = np.clip(normals @ light, 0, None)
    shading = 0.3 + 0.85 * lit
    shine = insertion.gloss * np.clip(2 * lit * normals[..., 2] - light[2], 0, None) ** 30
    inside = ndimage.gaussian_filter((height > 0).astype(float), 0.7)[..., None]
    offset = (0.35 * height.max(), -0.6 * height.max() * light[0])
    shade = ndimage.shift((height > 0).astype(float), offset, order=1)
    shade = ndimage.gaussian_filter(shade, (insertion.softness / 2, insertion.softness))
    around = room * (1 - insertion.shadow * shade[..., None])
    surface = albedo * shading[..., None] + shine[..., None]
    picture: Array = inside * surface + (1 - inside) * around
    return picture


def _eight_bits(picture: Array) -> npt.NDArray[np.uint8]:
    return np.round(255 * np.clip(picture, 0, 1)).astype(np.uint8)
