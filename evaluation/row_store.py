"""An append-only file of result rows that a crash, a full disk or a second run cannot corrupt.

Lines are those of `evaluation.row_lines`. Rows are appended under an exclusive lock and flushed to
disk before `RowStore.append` returns, so a row that was reported is there. A line that was cut or
damaged fails its checksum: it is reported by `RowStore.read` and its cell is measured again; the
lines around it stay good, because an append first closes a line that was cut. No clock plays a
part: of two rows of a cell the one further down counts.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from io import FileIO
from pathlib import Path
from typing import Any, Protocol

from evaluation.row_lines import DamagedLine, Row, decode_rows, encode_rows
from shading_model.errors import RelightlabError

ROWS = "rows.jsonl"
"""Name of the file in a store's folder."""


class Rows(Protocol):
    """Where result rows are kept."""

    def append(self, rows: Iterable[Row]) -> None:
        """Keep rows."""
        ...

    def stream(self) -> Iterator[dict[str, Any] | DamagedLine]:
        """Yield the rows in the order of writing, one at a time, and the damaged lines."""
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
            As `evaluation.row_lines.encode_row`.
        """
        self._lines += list(encode_rows(rows))

    def stream(self) -> Iterator[dict[str, Any] | DamagedLine]:
        """Yield all rows in the order of writing."""
        return decode_rows(self._lines)

    def read(self) -> tuple[list[dict[str, Any]], list[DamagedLine]]:
        """Return all rows, and no damaged line.

        Returns
        -------
        list of dict, list of DamagedLine
        """
        return apart(self.stream())


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
        content = b"".join(encode_rows(rows))
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

    def stream(self) -> Iterator[dict[str, Any] | DamagedLine]:
        """Yield the rows in the order of writing, one at a time, and the damaged lines.

        Yields
        ------
        dict or DamagedLine
            Memory does not grow with the number of rows.

        Raises
        ------
        RelightlabError
            If the file cannot be read; one that does not exist holds no rows.
        """
        return decode_rows(self._lines())

    def read(self) -> tuple[list[dict[str, Any]], list[DamagedLine]]:
        """Return all good rows in the order of writing, and the damaged lines.

        Returns
        -------
        list of dict, list of DamagedLine
        """
        return apart(self.stream())

    def _lines(self) -> Iterator[bytes]:
        try:
            with self.path.open("rb") as stream:
                yield from stream
        except FileNotFoundError:
            return
        except OSError as error:
            raise RelightlabError(f"cannot read {self.path}: {error.strerror or error}") from error


def apart(
    found: Iterable[dict[str, Any] | DamagedLine],
) -> tuple[list[dict[str, Any]], list[DamagedLine]]:
    """Return rows and damaged lines as two lists.

    Parameters
    ----------
    found : iterable of dict or DamagedLine

    Examples
    --------
    >>> apart([{"imse": 0.5}, DamagedLine(2, "the line is cut off")])
    ([{'imse': 0.5}], [DamagedLine(number=2, reason='the line is cut off')])
    """
    rows: list[dict[str, Any]] = []
    damaged: list[DamagedLine] = []
    for one in found:
        if isinstance(one, DamagedLine):
            damaged.append(one)
        else:
            rows.append(one)
    return rows, damaged


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
    except BaseException:  # a full disk, Ctrl-C or a time limit
        os.ftruncate(stream.fileno(), end)
        raise


def _ends_with_newline(stream: FileIO, end: int) -> bool:
    stream.seek(end - 1)
    return stream.read(1) == b"\n"
