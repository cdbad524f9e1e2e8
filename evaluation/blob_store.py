"""A folder of heavy results, each under the hash of all that it depends on.

A blob with the key ``abcdef...`` is the file ``ab/cdef...SUFFIX``, and beside it lies
``ab/cdef...SUFFIX.sha256`` in the format of ``sha256sum``. Both are written to temporary files
and moved, the content first, under a lock of their folder; so a blob is good exactly if the side
file is there and fits. What is not good is reported by a log warning and made again.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import logging
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from datasets.atomic import atomic_path
from shading_model.errors import RelightlabError

Value = TypeVar("Value")
BLOBS = "blobs"
"""Name of the folder in a store's folder."""
SIDE = ".sha256"
_CHUNK = 1 << 20
_log = logging.getLogger(__name__)


def blob_key(inputs: Mapping[str, str], parameters: Mapping[str, str], code: str) -> str:
    """Return the key of what these inputs, parameters and version of the code give.

    Parameters
    ----------
    inputs, parameters : mapping of str
        By name; content hashes where there is much.
    code : str
        Version of the code that matters, as `evaluation.code_version.code_hash`.

    Returns
    -------
    str
        64 hexadecimal digits.

    Examples
    --------
    >>> blob_key({"photograph": "ab"}, {}, "1") == blob_key({"photograph": "ab"}, {}, "2")
    False
    """
    document = json.dumps([dict(inputs), dict(parameters), code], sort_keys=True)
    return hashlib.sha256(document.encode()).hexdigest()


@dataclass(frozen=True)
class BlobStore:
    """Blobs in a folder that any number of processes on one machine may share.

    Parameters
    ----------
    folder : Path
        Created by the first blob.
    suffix : str
        Of the files' names.

    Examples
    --------
    >>> import tempfile
    >>> store = BlobStore(Path(tempfile.mkdtemp()), ".txt")
    >>> def made() -> str:
    ...     print("made")
    ...     return "costly"
    >>> key = blob_key({"photograph": "ab"}, {}, "1")
    >>> for _ in range(2):
    ...     print(store.get_or_make(key, made, Path.read_text, Path.write_text))
    made
    costly
    costly
    """

    folder: Path
    suffix: str = ""

    def path(self, key: str) -> Path:
        """Return where the blob of a key lies, or would."""
        return self.folder / key[:2] / f"{key[2:]}{self.suffix}"

    def get_or_make(
        self,
        key: str,
        make: Callable[[], Value],
        read: Callable[[Path], Value],
        write: Callable[[Path, Value], object],
    ) -> Value:
        """Return the value of a key: read where its blob is good, made and kept otherwise.

        Parameters
        ----------
        key : str
            See `blob_key`.
        make, read, write : callables
            ``read(path)`` returns what ``write(path, value)`` was given, bit by bit.

        Raises
        ------
        RelightlabError
            If the folder cannot be written; faults of `make` and `write` pass through, and leave
            no blob.
        """
        path = self.path(key)
        fault = blob_fault(path)
        if fault is None:
            try:
                return read(path)
            except (RelightlabError, OSError, ValueError) as error:
                fault = str(error)
        if fault:
            _log.warning("%s: %s; it is made again", path.name, fault)
        value = make()
        _keep(path, value, write)
        return value


def copy_blob(source: Path, folder: Path) -> bool:
    """Copy a good blob into another blob folder; return whether it was not there yet.

    Parameters
    ----------
    source : Path
        The content file.
    folder : Path
        Where `BlobStore` would look for it.

    Returns
    -------
    bool

    Raises
    ------
    RelightlabError
        If the folder cannot be written.
    """
    target = folder / source.parent.name / source.name
    if blob_fault(target) is None:
        return False
    _keep(target, source, lambda path, content: shutil.copyfile(content, path))
    return True


def blob_fault(path: Path) -> str | None:
    """Return what is wrong with a blob: None if it is good, empty if there is none.

    Parameters
    ----------
    path : Path

    Examples
    --------
    >>> blob_fault(Path("no such blob"))
    ''
    """
    side = path.with_name(path.name + SIDE)
    try:
        with _locked(path.parent, fcntl.LOCK_SH):
            if not path.exists():
                return "its content was deleted" if side.exists() else ""
            if not side.exists():
                return "its SHA-256 was not written"
            fits = side.read_bytes() == _side_line(path, file_hash(path))
    except FileNotFoundError:
        return ""
    except OSError as error:
        return error.strerror or str(error)
    return None if fits else "its content does not fit its SHA-256"


def blob_files(folder: Path) -> Iterator[Path]:
    """Yield the content files of a blob folder in the order of their keys.

    Parameters
    ----------
    folder : Path
        One that does not exist holds none.

    Examples
    --------
    >>> list(blob_files(Path("no such folder")))
    []
    """
    for path in sorted(folder.glob("[0-9a-f][0-9a-f]/*")):
        if not path.name.startswith(".") and path.suffix != SIDE:
            yield path


def file_hash(path: Path) -> str:
    """Return the SHA-256 of a file's content.

    Parameters
    ----------
    path : Path

    Examples
    --------
    >>> len(file_hash(Path(__file__)))
    64
    """
    digest = hashlib.sha256()
    with path.open("rb") as stream:
        while chunk := stream.read(_CHUNK):
            digest.update(chunk)
    return digest.hexdigest()


def _keep(path: Path, value: Value, write: Callable[[Path, Value], object]) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RelightlabError(
            f"cannot write {path}: {error.strerror or error}; choose another output"
        ) from error
    with _locked(path.parent):
        with atomic_path(path) as temporary:
            write(temporary, value)
            digest = file_hash(temporary)
        _write_side(path, digest)


def _write_side(path: Path, digest: str) -> None:
    with atomic_path(path.with_name(path.name + SIDE)) as temporary:
        temporary.write_bytes(_side_line(path, digest))


def _side_line(path: Path, digest: str) -> bytes:
    return f"{digest}  {path.name}\n".encode()


@contextmanager
def _locked(folder: Path, kind: int = fcntl.LOCK_EX) -> Iterator[None]:
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, kind)
        yield
    finally:
        os.close(handle)
