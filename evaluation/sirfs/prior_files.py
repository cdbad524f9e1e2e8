"""Files of priors, and the one that is shipped.

An archive of ``.npy`` members, of the names of `evaluation.sirfs.priors.arrays_of`, whose bytes
depend on the numbers alone. The largest member, the cost of a colour, is a smooth function: it is
stored in steps of 1/256 as third differences of integers, one along each axis, which are mostly
zero. The member ``sha256`` is the identity of the priors.
"""

from __future__ import annotations

import io
import os
import struct
import zipfile
import zlib
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets.array_archive import add_member, npy_bytes
from datasets.atomic import atomic_path
from evaluation.sirfs.priors import SirfsPriors, arrays_of, priors_identity, priors_of
from shading_model.arrays import Float
from shading_model.errors import RelightlabError

FILE = Path(__file__).with_name("priors.npz")
SUFFIX = ".npz"
STEP = 2.0**-8
"""The cost of a colour is stored in these steps."""
_LEVEL = 9
_PACKED, _IDENTITY = "color_absolute", "sha256"
_DAMAGE = (
    *(zipfile.BadZipFile, zlib.error, struct.error, ValueError, KeyError, TypeError),
    *(EOFError, NotImplementedError, RuntimeError, SyntaxError, IndexError),
)


@cache
def shipped_priors() -> SirfsPriors:
    """Return the priors the project ships, learned by ``relightlab sirfs train``.

    Returns
    -------
    SirfsPriors

    Raises
    ------
    RelightlabError
        If the file is missing or damaged.

    Examples
    --------
    >>> shipped_priors().color_absolute.shape
    (102, 102, 102)
    """
    return load_priors(FILE)


def rounded_priors(priors: SirfsPriors) -> SirfsPriors:
    """Return priors as a file holds them: the cost of a colour in steps of 1/256.

    Parameters
    ----------
    priors : SirfsPriors

    Returns
    -------
    SirfsPriors

    Examples
    --------
    >>> rounded_priors(shipped_priors()).color_absolute is shipped_priors().color_absolute
    False
    """
    return replace(priors, color_absolute=np.rint(priors.color_absolute / STEP) * STEP)


def save_priors(path: str | os.PathLike[str], priors: SirfsPriors) -> None:
    """Write priors to a file, whole or not at all; the same priors give the same bytes.

    Parameters
    ----------
    path : path
        Ends in ``.npz``; replaced if it exists.
    priors : SirfsPriors
        Stored as `rounded_priors` returns them.

    Raises
    ------
    RelightlabError
        If the name has another suffix, or the file cannot be written.
    """
    target = Path(path)
    if target.suffix != SUFFIX:
        raise RelightlabError(f"expected a priors file's name to end in {SUFFIX}, got {target}")
    rounded = rounded_priors(priors)
    members = arrays_of(rounded)
    members[_PACKED] = _packed(rounded.color_absolute)
    members[_IDENTITY] = np.array(priors_identity(rounded))
    with atomic_path(target) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name, values in members.items():
            add_member(archive, f"{name}.npy", npy_bytes(values), _LEVEL)


def load_priors(path: str | os.PathLike[str]) -> SirfsPriors:
    """Return the priors of a file that `save_priors` wrote, after checking their SHA-256.

    Parameters
    ----------
    path : path

    Returns
    -------
    SirfsPriors

    Raises
    ------
    RelightlabError
        If the file is missing, holds no priors, or is damaged.

    Examples
    --------
    >>> load_priors("nowhere.npz")
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: no such file: nowhere.npz
    """
    try:
        with zipfile.ZipFile(path) as archive:
            names = [name.removesuffix(".npy") for name in archive.namelist()]
            arrays = {name: _array(archive.read(f"{name}.npy")) for name in names}
        identity = str(arrays.pop(_IDENTITY))
        priors = priors_of(arrays | {_PACKED: _unpacked(arrays[_PACKED])})
        found = priors_identity(priors)
    except FileNotFoundError:
        raise RelightlabError(f"no such file: {path}") from None
    except OSError as error:
        raise RelightlabError(f"cannot read {path}: {error.strerror or error}") from error
    except _DAMAGE as error:
        raise _damaged(path, str(error)) from error
    if found != identity:
        raise _damaged(path, "its numbers do not match the SHA-256 stored with them")
    return priors


def _packed(cost: Float) -> NDArray[np.int32]:
    whole = np.rint(cost / STEP).astype(np.int32)
    for axis in range(whole.ndim):
        whole = np.diff(whole, axis=axis, prepend=np.int32(0))
    return whole


def _unpacked(differences: NDArray[Any]) -> Float:
    for axis in range(differences.ndim):
        differences = np.cumsum(differences, axis=axis, dtype=np.int32)
    return differences * STEP


def _array(content: bytes) -> NDArray[Any]:
    values: NDArray[Any] = np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)
    return values


def _damaged(path: str | os.PathLike[str], reason: str) -> RelightlabError:
    return RelightlabError(
        f"{path} is damaged, or holds no priors of SIRFS ({reason}):"
        " get it again, or learn it with 'relightlab sirfs train'"
    )
