"""Folders of files seen by their content: SHA-256 of a file, of a set of files, and their sizes."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path

from shading_model.errors import RelightlabError


def file_sha256(path: Path) -> str:
    """Return the SHA-256 of a file's content, in hexadecimal.

    Raises
    ------
    RelightlabError
        If the file is missing or cannot be read.

    Examples
    --------
    >>> file_sha256(Path(__file__)) == hashlib.sha256(Path(__file__).read_bytes()).hexdigest()
    True
    """
    try:
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise RelightlabError(
            f"cannot read {path}: {error.strerror or error}; check that it is there and readable"
        ) from error


def relative_files(root: Path) -> tuple[str, ...]:
    """Return the names of all files below `root`, relative to it, with ``/``, in sorted order.

    Empty if `root` is not a folder. Hidden files, and files in hidden folders, are left out: they
    are never part of a set.

    Examples
    --------
    >>> "file_tree.py" in relative_files(Path(__file__).parent)
    True
    >>> relative_files(Path(__file__))
    ()
    """
    paths = (path.relative_to(root) for path in root.rglob("*") if path.is_file())
    visible = (path for path in paths if not any(part.startswith(".") for part in path.parts))
    return tuple(sorted(path.as_posix() for path in visible))


def folder_fingerprint(root: Path, paths: Iterable[Path] | None = None) -> str:
    """Return one SHA-256 over the names and contents of files below a folder.

    It depends on the relative names and the bytes alone: not on where the folder lies, the order
    of `paths`, times or permissions. The content is read every time; nothing is remembered.

    Parameters
    ----------
    root : Path
        The folder the names are relative to.
    paths : iterable of Path, optional
        The files, each below `root`; all visible files by default.

    Returns
    -------
    str
        64 hexadecimal digits.

    Raises
    ------
    RelightlabError
        If a file is missing, cannot be read or does not lie below `root`.

    Examples
    --------
    >>> here = Path(__file__).parent
    >>> one, two = here / "atomic.py", here / "records.py"
    >>> folder_fingerprint(here, [one, two]) == folder_fingerprint(here, [two, one])
    True
    >>> folder_fingerprint(here, [one]) == folder_fingerprint(here, [two])
    False
    """
    chosen = [root / name for name in relative_files(root)] if paths is None else paths
    contents = {_relative_name(root, path): path for path in chosen}
    digest = hashlib.sha256()
    for name in sorted(contents):
        # A name cannot hold NUL, so no two lists of files give the same bytes.
        digest.update(f"{file_sha256(contents[name])} {name}\0".encode())
    return digest.hexdigest()


def size_on_disk(root: Path) -> tuple[int, int]:
    """Return the number of visible files below `root` and the sum of their sizes in bytes.

    Examples
    --------
    >>> size_on_disk(Path(__file__))
    (0, 0)
    """
    names = relative_files(root)
    return len(names), sum((root / name).stat().st_size for name in names)


def _relative_name(root: Path, path: Path) -> str:
    if not path.is_relative_to(root):
        raise RelightlabError(f"expected files below {root}, got {path}")
    return path.relative_to(root).as_posix()
