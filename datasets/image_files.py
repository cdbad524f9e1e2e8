"""Pictures and masks read from files, as linear float64.

Sixteen-bit and floating-point files are linear already; eight-bit files hold sRGB values and are
linearised. Pillow checks every file (it refuses a truncated one, where OpenCV returns what it
has) and reads eight-bit pictures; OpenCV reads sixteen-bit ones, which Pillow would cut to eight.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image as PillowImage
from PIL import ImageOps, UnidentifiedImageError

from datasets.atomic import atomic_path
from shading_model.arrays import Float, Image, Mask
from shading_model.errors import RelightlabError

FilePath: TypeAlias = str | os.PathLike[str]
MAX_PIXELS = 200_000_000


def read_image(path: FilePath) -> Image:
    """Return a picture as linear RGB of shape (h, w, 3).

    Eight-bit values are sRGB and are linearised; sixteen-bit values are divided by 65535. A gray
    picture is repeated over three channels; an alpha channel is dropped (see `read_alpha`).

    Raises
    ------
    RelightlabError
        If the file is missing, truncated, too large, or not a picture.
    """
    raw = _read_raw(path)
    colour = raw[..., :3] if raw.ndim == 3 else raw
    linear = _linear(colour)
    if linear.ndim == 3 and linear.shape[-1] == 2:
        linear = linear[..., 0]
    if linear.ndim == 2:
        linear = np.repeat(linear[..., None], 3, axis=-1)
    return linear


def read_alpha(path: FilePath) -> Mask | None:
    """Return where the picture's alpha channel is above one half, or None if it has none.

    Raises
    ------
    RelightlabError
        As for `read_image`.
    """
    raw = _read_raw(path)
    if raw.ndim != 3 or raw.shape[-1] not in {2, 4}:
        return None
    opaque: Mask = raw[..., -1] > np.iinfo(raw.dtype).max / 2
    return opaque


def read_mask(path: FilePath) -> Mask:
    """Return a mask picture as booleans of shape (h, w).

    A picture in two values is True where it is above zero, whatever its bit depth; one with more
    values (an anti-aliased or lossy mask) is True above half of its format's range. Where there
    is an alpha channel that is not fully opaque, it is the mask.

    Raises
    ------
    RelightlabError
        As for `read_image`.
    """
    raw = _read_raw(path)
    if raw.ndim == 3 and raw.shape[-1] in {2, 4}:
        alpha = raw[..., -1]
        raw = alpha if (alpha < np.iinfo(raw.dtype).max).any() else raw[..., :-1]
    values = raw.max(axis=-1) if raw.ndim == 3 else raw
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


def write_image(path: FilePath, image: Image) -> None:
    """Write a linear RGB image as an eight-bit sRGB or (``.png`` with 16 bits) picture.

    NaN pixels are written as black; values are clipped to [0, 1].

    Raises
    ------
    RelightlabError
        If the folder cannot be written to, or the name has no known suffix.
    """
    if Path(path).suffix.lower() not in {".png", ".jpg", ".jpeg"}:
        raise RelightlabError(f"expected a name ending in .png or .jpg for a picture, got {path}")
    encoded = encode_srgb(np.nan_to_num(image, nan=0.0))
    with atomic_path(path) as temporary:
        PillowImage.fromarray(encoded).save(temporary)


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
    array([0.    , 0.214 , 1.    ])
    """
    values = np.asarray(encoded, dtype=np.float64)
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def _linear(raw: NDArray[Any]) -> Float:
    if raw.dtype == np.uint8:
        linear: Float = _SRGB_TABLE[raw]
        return linear
    return raw / np.float64(65535.0)


_SRGB_TABLE = decode_srgb(np.arange(256) / 255.0)


def _read_raw(path: FilePath) -> NDArray[Any]:
    if not Path(path).is_file():
        raise RelightlabError(f"no such file: {path}")
    sixteen_bit, eight_bit = _check_with_pillow(Path(path))
    if not sixteen_bit:
        return eight_bit
    raw = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if raw is None:
        raise RelightlabError(f"cannot read the picture {path}: the file is damaged")
    return _to_rgb_order(raw)


def _check_with_pillow(path: Path) -> tuple[bool, NDArray[Any]]:
    """Return whether the file has sixteen bits a channel, and its eight-bit content."""
    try:
        with PillowImage.open(path) as picture:
            if picture.width * picture.height > MAX_PIXELS:
                raise RelightlabError(
                    f"{path} has {picture.width}x{picture.height} pixels, more than the"
                    f" {MAX_PIXELS} that are read: make it smaller"
                )
            depth = _png_depth(path)
            picture.load()
            if depth == 16:
                return True, np.empty(0, np.uint8)
            upright = ImageOps.exif_transpose(picture)
            return False, _eight_bit(upright)
    except (OSError, SyntaxError, UnidentifiedImageError, PillowImage.DecompressionBombError) as e:
        raise RelightlabError(f"cannot read the picture {path}: {e}") from e


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
    if raw.ndim == 3 and raw.shape[-1] >= 3:
        return np.concatenate([raw[..., 2::-1], raw[..., 3:]], axis=-1)
    return raw
