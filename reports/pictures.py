"""Maps of an object as pictures: tone, colour scales, and images held inside a page's text.

Every picture is (h, w, 4) of 8-bit sRGB with the background transparent, so that it lies on the
page in light and dark mode.
"""

from __future__ import annotations

import base64
import io

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from PIL import Image as PillowImage

from shading_model.arrays import Float, Image, Map, Mask, Normals
from shading_model.illumination import LogHarmonics

Picture = npt.NDArray[np.uint8]
"""(h, w, 4), 8-bit sRGB and opacity."""

DIVERGING = "PuOr"
"""Orange below zero, purple above: told apart with every kind of colour blindness."""
BRIGHT_PERCENTILE = 99.0
WHITE = 0.9
"""What `exposure` maps the bright percentile to."""
SPHERE_SHARE = 0.72
"""Diameter of the sphere that shows a light, over the shorter side of its picture."""
INSET_SHARE = 0.3
"""Side of the picture of a light set into another, over that picture's shorter side."""
QUALITY, PRINT_QUALITY = 86, 90
TILE = (236, 237, 235)
"""What lies behind a printed picture, sRGB."""


def exposure(image: Float) -> float:
    """Return the factor that makes the bright parts of a linear image nearly white.

    Parameters
    ----------
    image : array
        Linear; NaN outside the mask.

    Returns
    -------
    float
        One for an image that is black or empty.

    Examples
    --------
    >>> exposure(np.full((2, 2), 0.45))
    2.0
    """
    known = image[np.isfinite(image)]
    bright = float(np.percentile(known, BRIGHT_PERCENTILE)) if known.size else 0.0
    return WHITE / bright if bright > 0 else 1.0


def photograph_picture(image: Image, factor: float | None = None) -> Picture:
    """Return a linear image as it looks on a screen, brightened by a factor and clipped.

    Parameters
    ----------
    image : (h, w, 3) or (h, w) array
        Linear; NaN outside the mask.
    factor : float, optional
        Its own `exposure` by default.

    Returns
    -------
    (h, w, 4) uint8 array

    Examples
    --------
    >>> photograph_picture(np.array([[0.9, np.nan]]), 1.0).tolist()
    [[[243, 243, 243, 255], [0, 0, 0, 0]]]
    """
    colour = np.repeat(image[..., None], 3, axis=-1) if image.ndim == 2 else image
    scaled = np.clip(colour * (exposure(image) if factor is None else factor), 0.0, 1.0)
    return _with_opacity(srgb(scaled))


def srgb(linear: Float) -> Float:
    """Return linear intensities in [0, 1] encoded for an sRGB screen (IEC 61966-2-1).

    Examples
    --------
    >>> srgb(np.array([0.0, 1.0])).round(6).tolist()
    [0.0, 1.0]
    """
    encoded: Float = np.where(
        linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0) ** (1 / 2.4) - 0.055
    )
    return encoded


def diverging_picture(values: Map, limit: float) -> Picture:
    """Return a signed map in `DIVERGING` colours, from minus to plus `limit`.

    Parameters
    ----------
    values : (h, w) array
        NaN outside the mask.
    limit : float
        Above zero.

    Returns
    -------
    (h, w, 4) uint8 array
    """
    colours = mpl.colormaps[DIVERGING](np.clip(0.5 + values / (2 * limit), 0.0, 1.0))[..., :3]
    return _with_opacity(np.where(np.isfinite(values)[..., None], colours, np.nan))


def diverging_stops(count: int = 9) -> tuple[str, ...]:
    """Return the colours of `DIVERGING` from low to high, for a scale drawn by the page.

    Examples
    --------
    >>> diverging_stops(3)[1]
    '#f6f6f7'
    """
    colours = mpl.colormaps[DIVERGING](np.linspace(0.0, 1.0, count))[:, :3]
    rounded = np.rint(colours * 255).astype(int)
    return tuple("#" + "".join(f"{channel:02x}" for channel in colour) for colour in rounded)


def symmetric_limit(*maps: Map) -> float:
    """Return a round number that nearly all absolute values of the maps stay below.

    Examples
    --------
    >>> symmetric_limit(np.array([[0.0, 0.26]]))
    0.3
    """
    known = np.concatenate([np.abs(values[np.isfinite(values)]) for values in maps])
    largest = float(np.percentile(known, BRIGHT_PERCENTILE)) if known.size else 0.0
    if largest <= 0:
        return 1.0
    unit = 10.0 ** np.floor(np.log10(largest))
    return float(f"{np.ceil(largest / unit) * unit:.1g}")


def normal_picture(normals: Normals) -> Picture:
    """Return unit normals as colours, (x, y, z) from [-1, 1] to (red, green, blue).

    Parameters
    ----------
    normals : (h, w, 3) array
        NaN outside the mask.

    Returns
    -------
    (h, w, 4) uint8 array

    Examples
    --------
    >>> normal_picture(np.array([[[0.0, 0.0, 1.0]]])).tolist()
    [[[128, 128, 255, 255]]]
    """
    return _with_opacity((normals + 1) / 2)


def sphere_picture(light: LogHarmonics, height: int, width: int) -> Picture:
    """Return a white sphere under a light, centred in a picture of the given size.

    Parameters
    ----------
    light : LogHarmonics
    height, width : int
        Pixels.

    Returns
    -------
    (height, width, 4) uint8 array
    """
    radius = SPHERE_SHARE * min(height, width) / 2
    rows, columns = np.indices((height, width), dtype=np.float64)
    x = (columns - (width - 1) / 2) / radius
    y = ((height - 1) / 2 - rows) / radius
    z = np.sqrt(np.where(x**2 + y**2 <= 1, 1 - x**2 - y**2, np.nan))
    normals = np.where(np.isfinite(z)[..., None], np.stack([x, y, z], axis=-1), np.nan)
    return photograph_picture(light.shade(normals))


def with_light(picture: Picture, light: LogHarmonics) -> Picture:
    """Return a picture with the sphere under a light set into its emptiest corner.

    Parameters
    ----------
    picture : (h, w, 4) uint8 array
    light : LogHarmonics

    Returns
    -------
    (h, w, 4) uint8 array
    """
    height, width = picture.shape[:2]
    side = max(1, round(INSET_SHARE * min(height, width)))
    tops = (slice(side), slice(height - side, height))
    corners = [(top, left) for top in tops for left in (slice(side), slice(width - side, width))]
    emptiest = min(corners, key=lambda corner: int((picture[corner][..., 3] > 0).sum()))
    sphere = sphere_picture(light, side, side)
    shown = picture.copy()
    shown[emptiest] = np.where(sphere[..., 3:] > 0, sphere, shown[emptiest])
    return shown


def fitted(picture: Picture, width: int) -> Picture:
    """Return a picture made smaller, if it is wider than `width`, in the same proportions.

    Parameters
    ----------
    picture : (h, w, 4) uint8 array
    width : int
        Pixels.

    Returns
    -------
    (h, w, 4) uint8 array
    """
    height, own_width = picture.shape[:2]
    if own_width <= width:
        return picture
    size = (width, max(1, round(height * width / own_width)))
    # Pillow weights colour by opacity, so the transparent black does not bleed in.
    small = PillowImage.fromarray(picture).resize(size, PillowImage.Resampling.LANCZOS)
    return np.asarray(small, dtype=np.uint8)


def data_uri(picture: Picture) -> str:
    """Return a picture as a ``data:`` address (WebP with opacity), the same for the same pixels.

    Examples
    --------
    >>> data_uri(np.zeros((1, 1, 4), np.uint8))[:23]
    'data:image/webp;base64,'
    """
    stream = io.BytesIO()
    PillowImage.fromarray(picture).save(stream, "WEBP", quality=QUALITY, method=5)
    return "data:image/webp;base64," + base64.b64encode(stream.getvalue()).decode("ascii")


def print_jpeg(picture: Picture) -> bytes:
    """Return a picture on `TILE` as a JPEG file, the same for the same pixels.

    Parameters
    ----------
    picture : (h, w, 4) uint8 array

    Returns
    -------
    bytes

    Examples
    --------
    >>> print_jpeg(np.zeros((1, 1, 4), np.uint8))[:3].hex()
    'ffd8ff'
    """
    opacity = picture[..., 3:] / 255
    shown = np.rint(picture[..., :3] * opacity + np.array(TILE) * (1 - opacity)).astype(np.uint8)
    stream = io.BytesIO()
    PillowImage.fromarray(shown).save(stream, "JPEG", quality=PRINT_QUALITY, subsampling=0)
    return stream.getvalue()


def _with_opacity(colours: Float) -> Picture:
    """Return colours in [0, 1] as 8 bits, transparent where any channel is NaN."""
    inside: Mask = np.asarray(np.isfinite(colours).all(axis=-1))
    eight_bit = np.rint(np.where(inside[..., None], colours, 0.0) * 255)
    return np.concatenate([eight_bit, inside[..., None] * 255.0], axis=-1).astype(np.uint8)
