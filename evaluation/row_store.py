"""An append-only file of result rows that a crash, a full disk or a second run cannot corrupt.

Each line is ``CHECKSUM SPACE JSON NEWLINE``, the checksum being the first sixteen hexadecimal
digits of the SHA-256 of the JSON text. Rows are appended under an exclusive lock and flushed to
disk before `RowStore.append` returns, so a row that was reported is there. A line that was cut or
damaged fails its checksum: it is reported by `RowStore.read` and its cell is measured again; the
lines around it stay good, because an append first closes a line that was cut.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from io import FileIO
from pathlib import Path
from typing import Any, Protocol

from shading_model.errors import RelightlabError

Row = Mapping[str, Any]
CHECKSUM_DIGITS = 16
ROWS = "rows.jsonl"
"""Name of the file in a store's folder."""


@dataclass(frozen=True)
class DamagedLine:
    """A line whose checksum does not fit.

    Parameters
    ----------
    number : int
        One for the first line of the file.
    reason : str
    """

    number: int
    reason: str


class Rows(Protocol):
    """Where result rows are kept."""

    def append(self, rows: Iterable[Row]) -> None:
        """Keep rows."""
        ...

    def read(self) -> tuple[list[dict[str, Any]], list[DamagedLine]]:
        """Return all good rows in the order of writing, and the damaged lines."""
        ...


class MemoryRows:
    """Rows kept in memory, for a run that nobody will resume."""

    def __init__(self) -> None:
        self._lines: list[bytes] = []

    def append(self, rows: Iterable[Row]) -> None:
        """Keep rows, as a file would: what is no JSON is refused.

        Parameters
        ----------
        rows : iterable of mappings

        Raises
        ------
        RelightlabError
            As `encode_row`.
        """
        self._lines += [encode_row(row) for row in rows]

    def read(self) -> tuple[list[dict[str, Any]], list[DamagedLine]]:
        """Return all rows, and no damaged line.

        Returns
        -------
        list of dict, list of DamagedLine
        """
        return [decode_row(line) for line in self._lines], []


class RowStore:
    """Rows in one file, appended by any number of processes on one machine.

    Parameters
    ----------
    path : Path
        Created, with its folder, by the first append.

    Examples
    --------
    >>> import tempfile
    >>> store = RowStore(Path(tempfile.mkdtemp()) / "rows.jsonl")
    >>> store.append([{"object": "sun", "imse": 0.25}])
    >>> [dict(row) for row in store.read()[0]]
    [{'object': 'sun', 'imse': 0.25}]
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def append(self, rows: Iterable[Row]) -> None:
        """Write rows and flush them to disk; all rows of one call cost one flush.

        Parameters
        ----------
        rows : iterable of mappings
            Plain JSON values; NaN is refused.

        Raises
        ------
        RelightlabError
            If a value cannot be written as JSON, or the file cannot be written; rows whose
            writing failed are cut off again, so the file ends with a whole line.
        """
        content = b"".join(encode_row(row) for row in rows)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            # Unbuffered: what a failed write left over must not be flushed later.
            with self.path.open("ab+", buffering=0) as stream, _locked(stream):
                _write_whole(stream, content)
        except OSError as error:
            raise RelightlabError(
                f"cannot append to {self.path}: {error.strerror or error};"
                " the rows written before are safe, make room or choose another folder"
            ) from error

    def read(self) -> tuple[list[dict[str, Any]], list[DamagedLine]]:
        """Return all good rows in the order of writing, and the damaged lines.

        Returns
        -------
        list of dict, list of DamagedLine
        """
        rows: list[dict[str, Any]] = []
        damaged: list[DamagedLine] = []
        for number, line in self._lines():
            try:
                rows.append(decode_row(line))
            except ValueError as error:
                damaged.append(DamagedLine(number, str(error)))
        return rows, damaged

    def _lines(self) -> Iterator[tuple[int, bytes]]:
        if not self.path.exists():
            return
        try:
            with self.path.open("rb") as stream:
                yield from enumerate(stream, start=1)
        except OSError as error:
            raise RelightlabError(f"cannot read {self.path}: {error.strerror or error}") from error


def encode_row(row: Row) -> bytes:
    r"""Return the line of a row.

    Parameters
    ----------
    row : mapping

    Raises
    ------
    RelightlabError
        If a value is NaN, infinite or no JSON value.

    Examples
    --------
    >>> encode_row({"imse": 0.5})
    b'cf27a45cfc913bf0 {"imse": 0.5}\n'
    """
    try:
        text = json.dumps(row, allow_nan=False, ensure_ascii=False).encode()
    except (TypeError, ValueError) as error:
        raise RelightlabError(f"a result row holds a value that is not JSON: {error}") from error
    return _checksum(text) + b" " + text + b"\n"


def decode_row(line: bytes) -> dict[str, Any]:
    """Return the row of a line.

    Parameters
    ----------
    line : bytes

    Raises
    ------
    ValueError
        If the line is cut or its checksum does not fit.

    Examples
    --------
    >>> decode_row(encode_row({"imse": 0.5}))
    {'imse': 0.5}
    """
    if not line.endswith(b"\n"):
        raise ValueError("the line is cut off")
    checksum, _, text = line[:-1].partition(b" ")
    if checksum != _checksum(text):
        raise ValueError("the checksum does not fit the line")
    row: dict[str, Any] = json.loads(text)
    return row


def _checksum(text: bytes) -> bytes:
    return hashlib.sha256(text).hexdigest()[:CHECKSUM_DIGITS].encode()


@contextmanager
def _locked(stream: FileIO) -> Iterator[None]:
    fcntl.flock(stream, fcntl.LOCK_EX)
    try:
        yield
    finally:
        fcntl.flock(stream, fcntl.LOCK_UN)


def _write_whole(stream: FileIO, content: bytes) -> None:
    """Append `content` after a whole line, or leave the file as long as it was."""
    end = stream.seek(0, os.SEEK_END)
    if end and not _ends_with_newline(stream, end):
        content = b"\n" + content
    try:
        written = 0
        while written < len(content):
            written += stream.write(content[written:]) or 0
        os.fsync(stream.fileno())
    except OSError:
        os.ftruncate(stream.fileno(), end)
        raise


def _ends_with_newline(stream: FileIO, end: int) -> bool:
    stream.seek(end - 1)
    return stream.read(1) == b"\n"
