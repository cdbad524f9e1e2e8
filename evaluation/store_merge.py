"""Merging stores: the union of their good rows and blobs, as if one run had written them all."""

from __future__ import annotations

import hashlib
import json
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from evaluation.blob_store import BLOBS, blob_fault, blob_files, copy_blob
from evaluation.grid_status import FAILED
from evaluation.row_lines import DamagedLine, Row
from evaluation.row_store import ROWS, RowStore
from evaluation.store_archive import opened_archive, verify_archive
from shading_model.errors import RelightlabError

BATCH = 10_000
"""Rows appended at once."""


@dataclass(frozen=True)
class MergeSummary:
    """What a merge brought.

    Parameters
    ----------
    rows, blobs : int
        Added to the target.
    damaged_lines, damaged_blobs : int
        Of the sources, left out.
    """

    rows: int
    blobs: int
    damaged_lines: int
    damaged_blobs: int

    def document(self) -> dict[str, int]:
        """Return the summary as plain JSON values."""
        return asdict(self)

    def sentence(self) -> str:
        """Return what the merge brought, in one line."""
        left = f"{self.damaged_lines} damaged lines and {self.damaged_blobs} damaged blobs left out"
        damaged = self.damaged_lines or self.damaged_blobs
        return f"{self.rows} rows and {self.blobs} blobs added{f'; {left}' if damaged else ''}"


def merge_stores(target: Path, sources: Sequence[Path]) -> MergeSummary:
    """Add to a store what it lacks of others; merging again adds nothing.

    A cell that is done in the target stays as it is, and no failure of a source undoes it.

    Parameters
    ----------
    target : Path
        Folder of a store; created if needed.
    sources : sequence of Path
        Folders of stores, or archives of them, which are verified first.

    Returns
    -------
    MergeSummary

    Raises
    ------
    RelightlabError
        If a source is no store, an archive is damaged, two stores hold an experiment in different
        versions of its protocol, or the target cannot be written. Then nothing was merged, save
        where the disk filled up on the way.
    """
    with _opened(sources) as folders:
        _check_versions([target, *folders])
        known = _KnownRows(RowStore(target / ROWS))
        rows = blobs = damaged_lines = damaged_blobs = 0
        for folder in folders:
            found, damaged = _merge_rows(folder, known, RowStore(target / ROWS))
            rows, damaged_lines = rows + found, damaged_lines + damaged
            for path in blob_files(folder / BLOBS):
                if blob_fault(path) is not None:
                    damaged_blobs += 1
                else:
                    blobs += copy_blob(path, target / BLOBS)
    return MergeSummary(rows, blobs, damaged_lines, damaged_blobs)


class _KnownRows:
    """Which cells are done and which rows are there, in hashes of sixteen bytes."""

    def __init__(self, store: RowStore) -> None:
        self._closed: set[bytes] = set()
        self._failed: set[bytes] = set()
        for row in store.stream():
            if not isinstance(row, DamagedLine):
                self.is_new(row)

    def is_new(self, row: Row) -> bool:
        """Return whether a row says more than those before it, and remember it."""
        cell = _hash([row.get(field) for field in ("experiment", "inputs", "cell")])
        if cell in self._closed:
            return False
        if row.get("status") != FAILED:
            self._closed.add(cell)
            return True
        whole = _hash(row)
        new = whole not in self._failed
        self._failed.add(whole)
        return new


def _merge_rows(folder: Path, known: _KnownRows, target: RowStore) -> tuple[int, int]:
    damaged = added = 0

    def new_rows() -> Iterator[dict[str, Any]]:
        nonlocal damaged
        for row in RowStore(folder / ROWS).stream():
            if isinstance(row, DamagedLine):
                damaged += 1
            elif known.is_new(row):
                yield row

    for batch in _batches(new_rows()):
        target.append(batch)
        added += len(batch)
    return added, damaged


def _batches(rows: Iterator[dict[str, Any]]) -> Iterator[list[dict[str, Any]]]:
    while batch := list(islice(rows, BATCH)):
        yield batch


def _check_versions(folders: Iterable[Path]) -> None:
    first: dict[str, tuple[Any, Path]] = {}
    for folder in folders:
        for row in RowStore(folder / ROWS).stream():
            if isinstance(row, DamagedLine):
                continue
            name, version = row.get("experiment", ""), row.get("version")
            expected, where = first.setdefault(name, (version, folder))
            if version != expected:
                raise RelightlabError(
                    f"{where} holds results of protocol {name} {expected} and {folder} of version"
                    f" {version}, which do not mix: keep them in stores of their own"
                )


@contextmanager
def _opened(sources: Sequence[Path]) -> Iterator[list[Path]]:
    """Yield the folders of stores and of unpacked archives."""
    with tempfile.TemporaryDirectory(prefix="relightlab-merge-") as temporary:
        folders = []
        for number, source in enumerate(sources):
            folder = source
            if source.is_file():
                verify_archive(source)
                folder = Path(temporary) / str(number)
                with opened_archive(source) as archive:
                    archive.extractall(folder)
            if not (folder / ROWS).is_file():
                raise RelightlabError(f"{source} is no store: it has no {ROWS}")
            folders.append(folder)
        yield folders


def _hash(value: object) -> bytes:
    text = json.dumps(value, sort_keys=True, ensure_ascii=False)
    return hashlib.blake2b(text.encode(), digest_size=16).digest()
