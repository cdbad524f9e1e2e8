"""Pictures and masks read from files, as linear float64.

Sixteen-bit files are linear already; eight-bit files hold sRGB values and are linearised. Pillow
checks every file (it refuses a truncated one, where OpenCV returns what it has) and reads
eight-bit pictures; OpenCV reads sixteen-bit ones, which Pillow would cut to eight.
"""

from __future__ import annotations

import os
import struct
import warnings
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image as PillowImage
from PIL import ImageOps

from datasets.atomic import atomic_path
from shading_model.arrays import Float, Image, Mask
from shading_model.errors import RelightlabError

FilePath: TypeAlias = str | os.PathLike[str]
MAX_PIXELS = 150_000_000
"""Pictures of more pixels are refused."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture as its file holds it.

    Parameters
    ----------
    colour : (h, w) or (h, w, 3) array of uint8 or uint16
        Gray or RGB; eight bits are sRGB, sixteen linear.
    alpha : (h, w) array of the same type, or None
        Opacity, None where the file has none.
    """

    colour: NDArray[Any]
    alpha: NDArray[Any] | None

    @property
    def opaque(self) -> Mask | None:
        """Where the opacity is above one half; None where the file has none."""
        if self.alpha is None:
            return None
        opaque: Mask = self.alpha > np.iinfo(self.alpha.dtype).max / 2
        return opaque


def read_picture(path: FilePath) -> Picture:
    """Return a picture as its file holds it, turned upright by its EXIF orientation.

    Parameters
    ----------
    path : path

    Returns
    -------
    Picture

    Raises
    ------
    RelightlabError
        If the file is missing, truncated, too large, or not an 8-bit or 16-bit picture.
    """
    raw = _read_raw(path)
    if raw.ndim == 2:
        return Picture(raw, None)
    if raw.shape[-1] == 4:
        return Picture(raw[..., :3], raw[..., 3])
    return Picture(raw, None)


def linearised(colour: NDArray[Any]) -> Image:
    """Return the values of a picture as linear RGB of shape (h, w, 3).

    Parameters
    ----------
    colour : (h, w) or (h, w, 3) array of uint8 or uint16
        A gray picture is repeated over three channels.

    Returns
    -------
    (h, w, 3) float64 array
        In [0, 1].

    Examples
    --------
    >>> linearised(np.array([[255]], np.uint8))
    array([[[1., 1., 1.]]])
    """
    gray_or_rgb = colour if colour.ndim == 3 else np.repeat(colour[..., None], 3, axis=-1)
    if colour.dtype == np.uint8:
        linear: Float = _SRGB_TABLE[gray_or_rgb]
        return linear
    return gray_or_rgb / np.float64(65535.0)


def read_image(path: FilePath) -> Image:
    """Return a picture as linear RGB of shape (h, w, 3), in [0, 1].

    Eight-bit values are sRGB and are linearised; sixteen-bit values are divided by 65535. A gray
    picture is repeated over three channels; an alpha channel is dropped (see `read_picture`).

    Raises
    ------
    RelightlabError
        As for `read_picture`.
    """
    return linearised(read_picture(path).colour)


def read_mask(path: FilePath) -> Mask:
    """Return a mask picture as booleans of shape (h, w).

    A picture in two values is True where it is above zero, whatever its bit depth; one with more
    values (an anti-aliased or lossy mask) is True above half of its format's range. Where there
    is an alpha channel that is not fully opaque, it is the mask.

    Raises
    ------
    RelightlabError
        As for `read_picture`.
    """
    picture = read_picture(path)
    opaque = picture.opaque
    if opaque is not None and not opaque.all():
        return opaque
    values = picture.colour.max(axis=-1) if picture.colour.ndim == 3 else picture.colour
    two_valued = bool(((values == values.min()) | (values == values.max())).all())
    mask: Mask = values > 0 if two_valued else values > np.iinfo(values.dtype).max / 2
    return mask


def read_linear_png(path: FilePath) -> Float:
    """Return a sixteen-bit PNG divided by 65535, (h, w) or (h, w, channels), at full depth.

    Raises
    ------
    RelightlabError
        If the file is missing, damaged or not sixteen-bit.
    """
    raw = _read_raw(path)
    if raw.dtype != np.uint16:
        raise RelightlabError(f"expected a 16-bit PNG, got {raw.dtype.itemsize * 8}-bit: {path}")
    return raw / np.float64(65535.0)


def write_image(path: FilePath, image: Image, *, opaque: Mask | None = None) -> None:
    """Write a linear RGB image as an eight-bit sRGB ``.png`` or ``.jpg``, whole or not at all.

    NaN pixels are written as black; values are clipped to [0, 1].

    Parameters
    ----------
    path : path
    image : (h, w, 3) array
    opaque : (h, w) bool array, optional
        Everything else is made transparent; ``.png`` only.

    Raises
    ------
    RelightlabError
        If the folder cannot be written to, or the name has no suffix that fits.
    """
    suffixes = (".png",) if opaque is not None else (".png", ".jpg", ".jpeg")
    if Path(path).suffix.lower() not in suffixes:
        kind = "a picture" if opaque is None else "a picture with transparency"
        raise RelightlabError(
            f"expected a name ending in {' or '.join(suffixes)} for {kind}, got {path}"
        )
    encoded = encode_srgb(np.nan_to_num(image, nan=0.0))
    if opaque is not None:
        encoded = np.concatenate([encoded, 255 * opaque[..., None].astype(np.uint8)], axis=-1)
    with atomic_path(path) as temporary:
        PillowImage.fromarray(encoded).save(temporary, quality=95)


def encode_srgb(linear: Float) -> NDArray[np.uint8]:
    """Return linear values as eight-bit sRGB (IEC 61966-2-1), clipped to [0, 1].

    Examples
    --------
    >>> encode_srgb(np.array([0.0, 0.2140411, 1.0]))
    array([  0, 127, 255], dtype=uint8)
    """
    clipped = np.clip(linear, 0.0, 1.0)
    low = clipped * 12.92
    high = 1.055 * clipped ** (1 / 2.4) - 0.055
    encoded = np.where(clipped <= 0.0031308, low, high)
    return np.round(encoded * 255).astype(np.uint8)


def decode_srgb(encoded: Float) -> Float:
    """Return sRGB values in [0, 1] as linear values (IEC 61966-2-1).

    Examples
    --------
    >>> decode_srgb(np.array([0.0, 0.5, 1.0])).round(4)
    array([0.   , 0.214, 1.   ])
    """
    values = np.asarray(encoded, dtype=np.float64)
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


_SRGB_TABLE = decode_srgb(np.arange(256) / 255.0)


def _read_raw(path: FilePath) -> NDArray[Any]:
    if not Path(path).is_file():
        raise RelightlabError(f"no such file: {path}")
    eight_bit = _check_with_pillow(Path(path))
    if eight_bit is not None:
        return eight_bit
    raw = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if raw is None or raw.dtype != np.uint16:
        raise RelightlabError(f"cannot read the picture {path}: expected 8 or 16 bits a channel")
    return _to_rgb_order(raw)


def _check_with_pillow(path: Path) -> NDArray[np.uint8] | None:
    """Return the content of an eight-bit file, None for a whole file of more bits."""
    try:
        with warnings.catch_warnings():
            # Large pictures are our own to judge, and broken metadata harm no pixel.
            warnings.simplefilter("ignore")
            with PillowImage.open(path) as picture:
                _check_size(path, picture)
                deep = _png_depth(path) == 16 or picture.mode not in _EIGHT_BIT_MODES
                picture.load()
                return None if deep else _eight_bit(ImageOps.exif_transpose(picture))
    except (*_DAMAGE, PillowImage.DecompressionBombError) as error:
        raise RelightlabError(f"cannot read the picture {path}: {error}") from error


_EIGHT_BIT_MODES = ("1", "L", "P", "LA", "PA", "RGB", "RGBA", "RGBX", "CMYK", "YCbCr", "LAB", "HSV")
_DAMAGE = (OSError, SyntaxError, ValueError, EOFError, struct.error, zlib.error)


def _check_size(path: Path, picture: PillowImage.Image) -> None:
    if picture.width * picture.height > MAX_PIXELS:
        raise RelightlabError(
            f"{path} has {picture.width}x{picture.height} pixels, more than the {MAX_PIXELS} that"
            " are read: make it smaller"
        )


def _png_depth(path: Path) -> int:
    """Return the bit depth in a PNG's header, 8 for any other format."""
    with path.open("rb") as stream:
        header = stream.read(25)
    return header[24] if header.startswith(b"\x89PNG\r\n\x1a\n") else 8


def _eight_bit(picture: PillowImage.Image) -> NDArray[np.uint8]:
    transparent = "transparency" in picture.info or picture.mode in {"LA", "PA", "RGBA"}
    if picture.mode in {"1", "L"} and not transparent:
        return np.asarray(picture.convert("L"))
    return np.asarray(picture.convert("RGBA" if transparent else "RGB"))


def _to_rgb_order(raw: NDArray[Any]) -> NDArray[Any]:
    if raw.ndim == 3:
        return np.concatenate([raw[..., 2::-1], raw[..., 3:]], axis=-1)
    return raw
