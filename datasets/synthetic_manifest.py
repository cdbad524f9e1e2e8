"""The manifest of a synthetic set: how it was made, and the SHA-256 of every file.

It is written last, so a folder without it is unfinished; a file that does not match it is damaged.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from shading_model.errors import RelightlabError

GENERATOR_VERSION = 1
"""Raised whenever the same parameters would give other bytes."""

FORMAT = "relightlab synthetic set 1"
MANIFEST = "manifest.json"


def parameters_of(size: int, seed: int, samples: int) -> dict[str, Any]:
    """Return the part of a manifest that says how a set is made.

    Examples
    --------
    >>> parameters_of(300, 0, 16)["size"]
    300
    """
    return {
        "format": FORMAT,
        "generator": GENERATOR_VERSION,
        "size": size,
        "seed": seed,
        "samples": samples,
    }


def read_manifest(folder: Path) -> dict[str, Any]:
    """Return the manifest of a folder.

    Parameters
    ----------
    folder : Path
        Of a finished set.

    Raises
    ------
    RelightlabError
        If there is none, or it is another format's.
    """
    path = folder / MANIFEST
    try:
        manifest: Any = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise RelightlabError(
            f"{folder} holds no finished synthetic set: make one (relightlab data synthesize)"
        ) from error
    known = isinstance(manifest, dict) and manifest.get("format") == FORMAT
    if not known or not isinstance(manifest.get("files"), dict):
        raise RelightlabError(f"expected {path} to say {FORMAT!r}: make the synthetic set again")
    found: dict[str, Any] = manifest
    return found


def is_whole(folder: Path, parameters: dict[str, Any], names: Sequence[str]) -> bool:
    """Return whether a folder holds the given objects, made with the given parameters, undamaged.

    Parameters
    ----------
    folder : Path
        May be absent.
    parameters : dict
        What its manifest must say of format, generator, size, seed and samples.
    names : sequence of str
        Objects that must be there, with the SHA-256 the manifest gives.

    Examples
    --------
    >>> is_whole(Path("no such folder"), {}, [])
    False
    """
    try:
        manifest = read_manifest(folder)
    except RelightlabError:
        return False
    if any(manifest.get(key) != value for key, value in parameters.items()):
        return False
    files = manifest["files"]
    return all(
        f"{name}.npz" in files and digest_of(folder / f"{name}.npz") == files[f"{name}.npz"]
        for name in names
    )


def digest_of(path: Path) -> str:
    """Return the SHA-256 of a file in hexadecimal, or "" where it cannot be read.

    Examples
    --------
    >>> digest_of(Path("no such file"))
    ''
    """
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return ""
