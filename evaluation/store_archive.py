"""A store as one ZIP file that another machine can verify.

The archive holds ``rows.jsonl`` and ``blobs/`` as they lie in the store's folder and, last,
``manifest.json``: its format and version, the number of good rows, and for every other member its
size and SHA-256. Members are in the order of their names and dated 1980, so the same store gives
the same bytes.
"""

from __future__ import annotations

import hashlib
import json
import struct
import zipfile
import zlib
from collections import Counter, deque
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from datasets.atomic import atomic_path
from evaluation.blob_store import BLOBS, SIDE, blob_fault, blob_files
from evaluation.row_lines import DamagedLine, decode_rows
from evaluation.row_store import ROWS
from shading_model.errors import RelightlabError

FORMAT, FORMAT_VERSION = "relightlab grid archive", 1
MANIFEST = "manifest.json"
_DAMAGE = (
    *(zipfile.BadZipFile, zlib.error, struct.error, ValueError, KeyError, TypeError),
    *(AttributeError, EOFError, NotImplementedError, RuntimeError, OSError),
)


@dataclass(frozen=True)
class ArchiveSummary:
    """What an archive holds.

    Parameters
    ----------
    members : dict of dict
        By name: ``bytes`` and ``sha256``.
    protocols : dict of int
        Good rows by protocol, ``table-1 1``.
    damaged : int
        Lines of the rows that cannot be read.
    left_out : tuple of str
        Blobs that were damaged and so not archived, with reasons.
    """

    members: dict[str, dict[str, Any]]
    protocols: dict[str, int]
    damaged: int
    left_out: tuple[str, ...] = ()

    @property
    def blobs(self) -> int:
        """Number of blobs."""
        return sum(not name.endswith(SIDE) for name in self.members) - 1

    def sentence(self) -> str:
        """Return what is in the archive, in one line."""
        rows = ", ".join(f"{count} rows of {name}" for name, count in self.protocols.items())
        words = [f"{rows or 'no rows'}, {self.blobs} blobs"]
        if self.damaged:
            words.append(f"{self.damaged} damaged lines")
        if self.left_out:
            words.append(f"{len(self.left_out)} damaged blobs left out")
        return "; ".join(words)

    def document(self) -> dict[str, Any]:
        """Return the summary as plain JSON values: the manifest."""
        return {
            "format": FORMAT,
            "version": FORMAT_VERSION,
            "rows": self.protocols,
            "damaged_lines": self.damaged,
            "members": self.members,
        }


def archive_store(folder: Path, out: Path) -> ArchiveSummary:
    """Write a store's rows and good blobs into one file with their hashes.

    Parameters
    ----------
    folder : Path
        Of the store.
    out : Path
        Ends in ``.zip``; replaced if it exists.

    Returns
    -------
    ArchiveSummary

    Raises
    ------
    RelightlabError
        If the folder holds no rows, the name has another suffix, or a file cannot be read or
        written.
    """
    if out.suffix != ".zip":
        raise RelightlabError(f"expected an archive's name to end in .zip, got {out}")
    rows = folder / ROWS
    if not rows.is_file():
        raise RelightlabError(f"{folder} is no store: it has no {ROWS}")
    blobs = list(blob_files(folder / BLOBS))
    faults = {path: fault for path in blobs if (fault := blob_fault(path)) is not None}
    good = [path for path in blobs if path not in faults]
    files = [rows, *good, *(path.with_name(path.name + SIDE) for path in good)]
    named = sorted((path.relative_to(folder).as_posix(), path) for path in files)
    tally = _Tally()
    with atomic_path(out) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name, path in named:
            with path.open("rb") as source, archive.open(_entry(name), "w", force_zip64=True) as to:
                tally.take(name, _copied(source, to))
        left_out = tuple(f"{path.name}: {fault}" for path, fault in faults.items())
        summary = tally.summary(left_out)
        content = json.dumps(summary.document(), indent=1, sort_keys=True) + "\n"
        archive.writestr(_entry(MANIFEST), content)
    return summary


def verify_archive(path: Path) -> ArchiveSummary:
    """Check every member of an archive against its SHA-256, and every row against its checksum.

    Parameters
    ----------
    path : Path

    Returns
    -------
    ArchiveSummary

    Raises
    ------
    RelightlabError
        If the file is missing or no archive, or a member is damaged, missing or too many.
    """
    with opened_archive(path) as archive:
        manifest = _manifest(path, archive)
        tally = _Tally()
        for name in sorted(set(archive.namelist()) - {MANIFEST}):
            with archive.open(name) as source:
                tally.take(name, source)
        summary = tally.summary(())
        _compare(path, manifest, summary)
    return summary


@contextmanager
def opened_archive(path: Path) -> Iterator[zipfile.ZipFile]:
    """Open a ZIP file; whatever is wrong with it, now or while it is read, becomes one sentence.

    Parameters
    ----------
    path : Path

    Yields
    ------
    ZipFile

    Raises
    ------
    RelightlabError
        If it is missing or damaged.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            yield archive
    except FileNotFoundError:
        raise RelightlabError(f"no such file: {path}") from None
    except _DAMAGE as error:
        raise RelightlabError(
            f"{path} is damaged or no archive made by 'grid archive' ({error}):"
            " archive the store again"
        ) from error


class _Tally:
    """Sizes and hashes of members as they pass, and the count of good rows."""

    def __init__(self) -> None:
        self.members: dict[str, dict[str, Any]] = {}
        self.protocols: Counter[str] = Counter()
        self.damaged = 0

    def take(self, name: str, lines: Iterable[bytes]) -> None:
        """Use up the lines of a member."""
        digest, size = hashlib.sha256(), 0

        def passing() -> Iterator[bytes]:
            nonlocal size
            for line in lines:
                digest.update(line)
                size += len(line)
                yield line

        if name == ROWS:
            for row in decode_rows(passing()):
                if isinstance(row, DamagedLine):
                    self.damaged += 1
                else:
                    self.protocols[f"{row.get('experiment')} {row.get('version')}"] += 1
        else:
            deque(passing(), maxlen=0)
        self.members[name] = {"bytes": size, "sha256": digest.hexdigest()}

    def summary(self, left_out: tuple[str, ...]) -> ArchiveSummary:
        """Return what was counted."""
        protocols = dict(sorted(self.protocols.items()))
        return ArchiveSummary(self.members, protocols, self.damaged, left_out)


def _copied(source: IO[bytes], target: IO[bytes]) -> Iterator[bytes]:
    for line in source:
        target.write(line)
        yield line


def _manifest(path: Path, archive: zipfile.ZipFile) -> dict[str, Any]:
    if MANIFEST not in archive.namelist():
        raise RelightlabError(f"{path} is no archive made by 'grid archive': it has no {MANIFEST}")
    manifest: dict[str, Any] = json.loads(archive.read(MANIFEST))
    if (manifest["format"], manifest["version"]) != (FORMAT, FORMAT_VERSION):
        raise RelightlabError(
            f"{path} is an archive of format {manifest['format']} {manifest['version']}, and this"
            f" relightlab reads {FORMAT} {FORMAT_VERSION}: use the relightlab that wrote it"
        )
    return manifest


def _compare(path: Path, manifest: dict[str, Any], summary: ArchiveSummary) -> None:
    for name in sorted(manifest["members"].keys() | summary.members.keys()):
        expected, found = manifest["members"].get(name), summary.members.get(name)
        if expected != found:
            fault = _fault(expected, found)
            raise RelightlabError(f"{path} is damaged: {name} {fault}; archive the store again")
    if summary.document() != manifest:
        raise RelightlabError(f"{path} is damaged: its manifest does not describe its rows")


def _fault(expected: object, found: object) -> str:
    if found is None:
        return "is missing"
    return "is not in the manifest" if expected is None else "does not fit its SHA-256"


def _entry(name: str) -> zipfile.ZipInfo:
    # ZipInfo's own date is 1 January 1980, and its system is fixed here: no clock, no machine.
    entry = zipfile.ZipInfo(name)
    entry.create_system = 3
    entry.external_attr = 0o644 << 16
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry
