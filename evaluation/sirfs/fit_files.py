"""Fits in files: a `SirfsFit` as one ``.npz``, readable by anything that reads NumPy arrays.

Format, version 1
-----------------
A ZIP archive whose members are dated 1980, so that the same fit gives the same bytes:

``format.npy``
    "relightlab sirfs fit 1".
``mask.npy``
    (h, w) bool.
``height.npy``, ``normals.npy``, ``albedo.npy``, ``shading.npy``
    (h, w), (h, w, 3) and twice (h, w, c) float64, little-endian, NaN outside the mask: c is 3 for
    a fit in colour, 1 in gray. Heights in pixels, larger is nearer; normals x right, y up, z
    toward the viewer; albedo times shading is the photograph.
``light.npy``
    (9,) or (9, 3): coefficients of log shading in nine harmonics of those normals.
``final_loss.npy``, ``terms.npy``, ``term_names.npy``
    The loss, and the weighted terms that it is the sum of.
``evaluations.npy``, ``stopped.npy``
    Evaluations of the loss, and why the fit ended.

No member holds a pickle, and none is read as one.
"""

from __future__ import annotations

import io
import os
import struct
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets.array_archive import add_member, npy_bytes
from datasets.atomic import atomic_path
from evaluation.sirfs.result import SirfsFit
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics

FORMAT = "relightlab sirfs fit 1"
SUFFIX = ".npz"
MAPS = ("mask", "height", "normals", "albedo", "shading")
_MEMBERS = (
    *("format", *MAPS, "light", "final_loss", "terms", "term_names"),
    *("evaluations", "stopped"),
)
_FASTEST = 1
_DAMAGE = (
    *(zipfile.BadZipFile, zlib.error, struct.error, ValueError, KeyError, TypeError),
    *(EOFError, NotImplementedError, RuntimeError, SyntaxError, RelightlabError),
)


def save_fit(path: str | os.PathLike[str], fit: SirfsFit) -> None:
    """Write a fit to a file, whole or not at all; the same fit gives the same bytes.

    Parameters
    ----------
    path : path
        Ends in ``.npz``; replaced if it exists.
    fit : SirfsFit

    Raises
    ------
    RelightlabError
        If the name has another suffix, or the file cannot be written.
    """
    target = Path(path)
    if target.suffix != SUFFIX:
        raise RelightlabError(f"expected the name of a fit's file to end in {SUFFIX}, got {target}")
    arrays: dict[str, Any] = {
        "format": FORMAT,
        **{name: getattr(fit, name) for name in MAPS},
        "light": fit.illumination.coefficients,
        "final_loss": fit.final_loss,
        "terms": np.array(list(fit.terms.values()), dtype=np.float64),
        "term_names": np.array(list(fit.terms), dtype=np.str_),
        "evaluations": fit.evaluations,
        "stopped": fit.stopped,
    }
    with atomic_path(target) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name in _MEMBERS:
            content = npy_bytes(np.asarray(arrays[name]))
            add_member(archive, f"{name}.npy", content, _FASTEST)


def load_fit(path: str | os.PathLike[str]) -> SirfsFit:
    """Return the fit of a file that `save_fit` wrote.

    Parameters
    ----------
    path : path

    Returns
    -------
    SirfsFit
        Equal to the one saved, bit by bit.

    Raises
    ------
    RelightlabError
        If the file is missing, holds no fit, or is damaged.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            return _fit({name: _array(archive, name) for name in _MEMBERS})
    except FileNotFoundError:
        raise RelightlabError(f"no such file: {path}") from None
    except OSError as error:
        raise RelightlabError(f"cannot read {path}: {error.strerror or error}") from error
    except _DAMAGE as error:
        raise RelightlabError(
            f"{path} is damaged, or no {FORMAT!r} ({error}): fit the photograph again"
        ) from error


def _array(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    content = io.BytesIO(archive.read(f"{name}.npy"))
    values: NDArray[Any] = np.lib.format.read_array(content, allow_pickle=False)
    return values


def _fit(arrays: dict[str, NDArray[Any]]) -> SirfsFit:
    if str(arrays["format"]) != FORMAT:
        raise ValueError(f"its format is {arrays['format']}")
    size = arrays["mask"].shape
    if len(size) != 2 or any(arrays[name].shape[:2] != size for name in MAPS):
        raise ValueError("its maps have several sizes")
    names, values = arrays["term_names"].tolist(), arrays["terms"].tolist()
    return SirfsFit(
        **{name: arrays[name] for name in MAPS},
        illumination=LogHarmonics(arrays["light"]),
        final_loss=float(arrays["final_loss"]),
        terms=dict(zip(names, values, strict=True)),
        evaluations=float(arrays["evaluations"]),
        stopped=str(arrays["stopped"]),
    )
