"""OpenEXR images, through one reader and one writer.

OpenEXR 3.5.3 writes wrong pixels, without an error, from an array that is not C-contiguous; so
nothing else in the project may write one.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import OpenEXR

from datasets.atomic import atomic_path
from shading_model.arrays import Image
from shading_model.errors import RelightlabError

_MAGIC = b"\x76\x2f\x31\x01"


def write_openexr(target: str | os.PathLike[str], image: Image) -> None:
    """Write a linear RGB image as 32-bit float OpenEXR, whole or not at all.

    Parameters
    ----------
    target : path
        Replaced if it exists.
    image : (h, w, 3) array
        Any strides; values are rounded to float32.

    Raises
    ------
    RelightlabError
        If the shape is wrong, or the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "image.exr"
    >>> write_openexr(path, np.full((2, 3, 3), 0.25))
    >>> read_openexr(path).shape
    (2, 3, 3)
    """
    given = np.asarray(image)
    if given.ndim != 3 or given.shape[-1] != 3 or given.size == 0:
        raise RelightlabError(f"expected an image of shape (h, w, 3), got {given.shape}")
    channels = {
        name: np.ascontiguousarray(given[..., index], dtype=np.float32)
        for index, name in enumerate("RGB")
    }
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with atomic_path(target) as path, OpenEXR.File(header, channels) as file:
        file.write(str(path))


def read_openexr(source: str | os.PathLike[str]) -> Image:
    """Return a linear RGB image from an OpenEXR file.

    Parameters
    ----------
    source : path
        A file with channels R, G, B, or Y alone (repeated over the three).

    Returns
    -------
    (h, w, 3) float64 array
        Values as stored: may exceed 1.

    Raises
    ------
    RelightlabError
        If the file is missing, not OpenEXR, damaged, lacks the channels, or holds NaN or
        infinite values.
    """
    path = Path(source)
    _check_magic(path)
    try:
        with OpenEXR.File(str(path), separate_channels=True) as file:
            pixels = {name: np.array(c.pixels) for name, c in file.channels().items()}
    except (RuntimeError, ValueError, OSError) as error:
        raise RelightlabError(f"{path} is damaged: fetch or write it again ({error})") from error
    names = "RGB" if set("RGB") <= set(pixels) else "YYY"
    if not set(names) <= set(pixels):
        raise RelightlabError(
            f"expected channels R, G, B or Y in {path}, got {', '.join(sorted(pixels))}"
        )
    image = np.stack([pixels[name] for name in names], axis=-1).astype(np.float64)
    if not np.isfinite(image).all():
        raise RelightlabError(f"{path} holds NaN or infinite values: repair or replace it")
    return image


def _check_magic(path: Path) -> None:
    try:
        with path.open("rb") as stream:
            magic = stream.read(len(_MAGIC))
    except OSError as error:
        raise RelightlabError(f"cannot read {path}: {error.strerror or error}") from error
    if magic != _MAGIC:
        raise RelightlabError(f"expected an OpenEXR file, got {path} which is not one")
