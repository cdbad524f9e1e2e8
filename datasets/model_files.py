"""Model files: an `ObjectModel` as one ``.npz``, readable by anything that reads NumPy arrays.

Format, version 1
-----------------
A ZIP archive whose members are dated 1980, so that the same model gives the same bytes:

``header.json``
    UTF-8 JSON with the keys ``format`` ("relightlab object model"), ``version`` (1), ``written_by``
    (version of relightlab), ``name`` and ``source`` of the photograph, ``conventions`` (in words),
    ``arrays`` (shape and dtype of each), ``light`` (``positions``, m by 3 in pixels, and
    ``intensities`` of the point lights fitted to the photograph) and ``sha256`` (in hexadecimal,
    over the arrays: for each, in the order of their names, its name and its ``.npy`` bytes).
``mask.npy``
    (h, w) bool.
``albedo.npy``, ``normals.npy``
    (h, w, 3) float64, little-endian; NaN outside the mask.
``height.npy``, ``parametric_residual.npy``, ``geometric_detail.npy``
    (h, w) float64, little-endian; NaN outside the mask.

No member holds a pickle, and none is read as one. Maps stay in double precision, so a model that
was saved and loaded relights to the same bits.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import struct
import zipfile
import zlib
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets.array_archive import add_member, npy_bytes
from datasets.atomic import atomic_path
from shading_model.errors import RelightlabError
from shading_model.illumination import PointLights
from shading_model.object_model import ObjectModel

FORMAT = "relightlab object model"
FORMAT_VERSION = 1
SUFFIX = ".npz"
HEADER = "header.json"
MAPS = ("albedo", "geometric_detail", "height", "mask", "normals", "parametric_residual")
"""The arrays of a model, in the order they are hashed."""

CONVENTIONS = {
    "arrays": "(row, column); NaN outside the mask",
    "axes": "x right, y up, z toward the viewer",
    "albedo": "linear RGB; image = albedo * shading, and the photograph's mean shading is one half",
    "height": "pixels, larger is nearer",
    "light": "point lights; x is the column, y is minus the row, z the height, in pixels",
}

_FASTEST = 1
_DAMAGE = (
    *(zipfile.BadZipFile, zlib.error, struct.error, ValueError, KeyError, TypeError),
    *(EOFError, NotImplementedError, RuntimeError, SyntaxError),
)


def save_model(
    path: str | os.PathLike[str], model: ObjectModel, *, name: str = "", source: str = ""
) -> None:
    """Write a model to a file, whole or not at all; the same model gives the same bytes.

    Parameters
    ----------
    path : path
        Ends in ``.npz``; replaced if it exists.
    model : ObjectModel
    name, source : str
        What the object is called and where its photograph came from.

    Raises
    ------
    RelightlabError
        If the name has another suffix, the light is not finite, or the file cannot be written.
    """
    target = Path(path)
    if target.suffix != SUFFIX:
        raise RelightlabError(f"expected a model file's name to end in {SUFFIX}, got {target}")
    arrays = {member: npy_bytes(getattr(model, member)) for member in MAPS}
    header = _header(model, _digest(arrays), name, source)
    with atomic_path(target) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        add_member(archive, HEADER, header, _FASTEST)
        for member, content in arrays.items():
            add_member(archive, f"{member}.npy", content, _FASTEST)


def load_model(path: str | os.PathLike[str]) -> ObjectModel:
    """Return the model of a file that `save_model` wrote, after checking its SHA-256.

    Parameters
    ----------
    path : path

    Returns
    -------
    ObjectModel
        Equal to the one saved, bit by bit.

    Raises
    ------
    RelightlabError
        If the file is missing, is not a model file, is of another version, or is damaged.
    """
    header, arrays = _read(Path(path), MAPS)
    if _digest(arrays) != header.get("sha256"):
        raise _damaged(path, "its arrays do not match the SHA-256 in its header")
    try:
        maps = {member: _array(content) for member, content in arrays.items()}
        lights = header["light"]
        light = PointLights(np.array(lights["positions"]), np.array(lights["intensities"]))
        return ObjectModel(illumination=light, **maps)
    except (*_DAMAGE, RelightlabError) as error:
        raise _damaged(path, str(error)) from error


def read_model_header(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the header of a model file; see this module for its keys.

    Parameters
    ----------
    path : path

    Returns
    -------
    dict

    Raises
    ------
    RelightlabError
        As `load_model`, but the arrays are not read.
    """
    return _read(Path(path), ())[0]


def _read(path: Path, members: tuple[str, ...]) -> tuple[dict[str, Any], dict[str, bytes]]:
    if path.suffix != SUFFIX:
        raise RelightlabError(
            f"expected a model file ({SUFFIX}, made by 'model build'), got {path}"
        )
    try:
        with zipfile.ZipFile(path) as archive:
            header = _checked_header(path, archive)
            return header, {member: archive.read(f"{member}.npy") for member in members}
    except FileNotFoundError:
        raise RelightlabError(f"no such file: {path}") from None
    except OSError as error:
        raise RelightlabError(f"cannot read {path}: {error.strerror or error}") from error
    except _DAMAGE as error:
        raise _damaged(path, str(error)) from error


def _checked_header(path: Path, archive: zipfile.ZipFile) -> dict[str, Any]:
    if HEADER not in archive.namelist():
        raise RelightlabError(f"{path} is not a model file: it has no {HEADER}")
    header = json.loads(archive.read(HEADER))
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise RelightlabError(f"{path} is not a model file: its header says no {FORMAT!r}")
    if header.get("version") != FORMAT_VERSION:
        raise RelightlabError(
            f"{path} is a model file of version {header.get('version')}, and this relightlab reads"
            f" version {FORMAT_VERSION}: build the model again, or use the relightlab that wrote it"
            f" ({header.get('written_by')})"
        )
    return header


def _header(model: ObjectModel, digest: str, name: str, source: str) -> bytes:
    light = model.illumination
    document = {
        "format": FORMAT,
        "version": FORMAT_VERSION,
        "written_by": version("relightlab"),
        "name": name,
        "source": source,
        "conventions": CONVENTIONS,
        "arrays": {
            member: {
                "shape": list(getattr(model, member).shape),
                "dtype": str(getattr(model, member).dtype),
            }
            for member in MAPS
        },
        "light": {
            "positions": light.positions.tolist(),
            "intensities": light.intensities.tolist(),
        },
        "sha256": digest,
    }
    try:
        return (json.dumps(document, indent=1, allow_nan=False) + "\n").encode()
    except ValueError as error:
        raise RelightlabError("the model's light holds NaN or infinite values") from error


def _array(content: bytes) -> NDArray[Any]:
    values: NDArray[Any] = np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)
    return values


def _digest(arrays: dict[str, bytes]) -> str:
    digest = hashlib.sha256()
    for member, content in arrays.items():
        digest.update(member.encode())
        digest.update(content)
    return digest.hexdigest()


def _damaged(path: str | os.PathLike[str], reason: str) -> RelightlabError:
    return RelightlabError(f"{path} is damaged: build the model again ({reason})")
