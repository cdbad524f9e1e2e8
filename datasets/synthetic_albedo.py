"""Painted albedo for the procedural objects: flat patches of paint over a fine texture.

Values are linear reflectances between 0.03 and 0.9.
"""

from __future__ import annotations

import numpy as np

from datasets.synthetic_patterns import cells, smooth_noise
from datasets.synthetic_shapes import picture_coordinates
from shading_model.arrays import Float, Image, Map
from shading_model.errors import unknown_name

# Linear reflectances of paints; the first of a row is the ground, the others are painted over it.
PALETTES: dict[str, tuple[tuple[float, float, float], ...]] = {
    "apple": ((0.55, 0.06, 0.04), (0.62, 0.42, 0.08), (0.36, 0.03, 0.03)),
    "pear": ((0.55, 0.52, 0.12), (0.42, 0.46, 0.08), (0.60, 0.32, 0.08)),
    "potato": ((0.50, 0.34, 0.17), (0.40, 0.26, 0.13), (0.56, 0.42, 0.24)),
    "pumpkin": ((0.75, 0.28, 0.04), (0.62, 0.20, 0.03), (0.30, 0.34, 0.08)),
    "folded_paper": ((0.78, 0.76, 0.70), (0.12, 0.28, 0.55), (0.70, 0.12, 0.10)),
    "crumpled_paper": ((0.72, 0.64, 0.48), (0.18, 0.42, 0.24), (0.60, 0.45, 0.12)),
    "teabag": ((0.74, 0.70, 0.60), (0.55, 0.42, 0.24), (0.16, 0.40, 0.18)),
    "carton": ((0.58, 0.42, 0.26), (0.75, 0.72, 0.66), (0.58, 0.10, 0.08)),
    "sun": ((0.72, 0.46, 0.12), (0.66, 0.22, 0.08), (0.78, 0.64, 0.30)),
    "medal": ((0.60, 0.44, 0.20), (0.50, 0.36, 0.16), (0.20, 0.34, 0.44)),
    "leaf": ((0.16, 0.36, 0.07), (0.42, 0.40, 0.08), (0.10, 0.26, 0.06)),
    "shell": ((0.76, 0.56, 0.46), (0.62, 0.34, 0.28), (0.80, 0.72, 0.62)),
    "cup": ((0.72, 0.70, 0.64), (0.10, 0.26, 0.50), (0.66, 0.42, 0.10)),
    "mug": ((0.22, 0.44, 0.48), (0.76, 0.72, 0.62), (0.60, 0.16, 0.10)),
    "frog": ((0.24, 0.44, 0.10), (0.10, 0.24, 0.07), (0.52, 0.54, 0.16)),
    "turtle": ((0.32, 0.34, 0.12), (0.20, 0.16, 0.07), (0.50, 0.42, 0.16)),
    "duck": ((0.76, 0.58, 0.12), (0.72, 0.30, 0.06), (0.46, 0.34, 0.14)),
    "bear": ((0.46, 0.28, 0.14), (0.66, 0.48, 0.28), (0.22, 0.13, 0.08)),
    "fish": ((0.50, 0.54, 0.58), (0.72, 0.34, 0.12), (0.16, 0.26, 0.40)),
    "rabbit": ((0.62, 0.54, 0.46), (0.78, 0.74, 0.68), (0.38, 0.30, 0.24)),
}

_STRIPED = {"pumpkin", "folded_paper", "cup", "fish", "duck", "shell"}
_RINGED = {"sun", "medal", "mug", "carton"}
_DARKEST, _BRIGHTEST = 0.03, 0.9


def painted_albedo(name: str, size: int, generator: np.random.Generator) -> Image:
    """Return the albedo of an object over the whole square picture.

    Patches, stripes or rings of constant paint, times a fine gray texture of about 6 per cent.

    Parameters
    ----------
    name : str
        A key of `PALETTES`.
    size : int
        Side of the picture in pixels.
    generator : numpy.random.Generator
        Places the patches and the texture.

    Returns
    -------
    (size, size, 3) array
        Between 0.03 and 0.9.

    Raises
    ------
    RelightlabError
        If the name is unknown.

    Examples
    --------
    >>> painted_albedo("apple", 16, np.random.default_rng(0)).shape
    (16, 16, 3)
    """
    if name not in PALETTES:
        raise unknown_name("object", name, PALETTES)
    x, y = picture_coordinates(size)
    paint = _regions(name, x, y, generator).astype(np.intp)
    colours = np.array(PALETTES[name], dtype=np.float64)[paint]
    texture = _texture(x, y, generator)
    painted: Image = np.clip(colours * texture[..., None], _DARKEST, _BRIGHTEST)
    return painted


def _regions(name: str, x: Map, y: Map, generator: np.random.Generator) -> Map:
    """Return the number of the paint, 0 to 2, at each pixel."""
    if name in _STRIPED:
        return _bands(3.2 * (0.9 * x + 0.35 * y) + 0.12 * smooth_noise(x, y, 1.2, generator))
    if name in _RINGED:
        return _bands(2.6 * np.hypot(x, y) + 0.08 * smooth_noise(x, y, 1.2, generator) + 0.3)
    index, border = cells(x, y, 22, generator, wobble=0.06)
    paint = np.take(generator.choice([0, 0, 1, 2], 22), index.astype(np.intp))
    # Paint keeps clear of the cells' borders, so that patches of one paint stay apart.
    return np.where(border > 0.02, paint, 0.0)


def _bands(phase: Float) -> Float:
    share = np.mod(phase, 1.0)
    return np.select([share < 0.55, share < 0.8], [0.0, 1.0], 2.0)


def _texture(x: Map, y: Map, generator: np.random.Generator) -> Map:
    coarse = smooth_noise(x, y, 7.0, generator)
    fine = smooth_noise(x, y, 20.0, generator)
    return 1.0 + 0.04 * coarse + 0.04 * fine
