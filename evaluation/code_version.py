"""The version of the code that measured numbers depend on."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

FOLDERS = ("shading_model", "datasets", "evaluation")
NUMERIC_PACKAGES = ("numpy", "scipy", "pyamg", "opencv-python-headless", "numba")


@cache
def code_hash(places: tuple[str, ...] = FOLDERS) -> str:
    """Return a SHA-256 over every module that can change a number, and the numeric packages.

    Reports, studies and tests cannot. A changed comment counts as a change: measuring once too
    often is safer than mixing.

    Parameters
    ----------
    places : tuple of str
        Folders with all that is in them, and single modules by their paths, where less than all
        of them matters.

    Examples
    --------
    >>> len(code_hash())
    64
    """
    root = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256()
    for place in places:
        whole = root / place
        for path in [whole] if whole.is_file() else sorted(whole.rglob("*.py")):
            digest.update(f"{path.relative_to(root).as_posix()}\0".encode())
            digest.update(hashlib.sha256(path.read_bytes()).digest())
    for package in NUMERIC_PACKAGES:
        digest.update(f"{package} {version(package)}\0".encode())
    return digest.hexdigest()
