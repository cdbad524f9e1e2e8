"""Whether the files of a downloaded set are all here and hold what was published."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from datasets.catalogue import mit_berkeley_files
from datasets.file_tree import file_sha256, relative_files

_NAMED = 5


@dataclass(frozen=True)
class VerificationReport:
    """What a folder holds of a set, compared with the recorded SHA-256 of each file.

    Parameters
    ----------
    folder : Path
        The set's folder.
    whole : int
        Files that are there with the recorded content.
    missing : tuple of str
        Recorded files that are not there.
    damaged : tuple of str
        Recorded files with another content.
    extra : tuple of str
        Visible files that are not recorded; they do no harm.
    """

    folder: Path
    whole: int
    missing: tuple[str, ...]
    damaged: tuple[str, ...]
    extra: tuple[str, ...]

    @property
    def complete(self) -> bool:
        """Whether every recorded file is whole."""
        return not self.missing and not self.damaged

    def sentence(self) -> str:
        """Return the report as one sentence that names the first files at fault.

        Examples
        --------
        >>> VerificationReport(Path("data"), 2, ("a.png",), (), ()).sentence()
        'data: 2 of 3 files are whole, 1 missing (a.png)'
        """
        total = self.whole + len(self.missing) + len(self.damaged)
        faults = {"missing": self.missing, "damaged": self.damaged, "not of the set": self.extra}
        parts = [
            f"{len(names)} {kind} ({_first(names)})" for kind, names in faults.items() if names
        ]
        return f"{self.folder}: " + ", ".join([f"{self.whole} of {total} files are whole", *parts])


def verify_mit_berkeley(
    root: Path, *, sha256: Mapping[str, str] | None = None
) -> VerificationReport:
    """Compare ``root/mit-berkeley`` with the recorded SHA-256 of every file.

    The content of every file is read (142 MB in about half a second). Hidden files, such as those
    of an unfinished download, are left out of account.

    Parameters
    ----------
    root : Path
        A data root; a folder that does not exist holds nothing.
    sha256 : mapping of str to str, optional
        Recorded SHA-256 by relative name; those of the published set by default.

    Raises
    ------
    RelightlabError
        If a file is there but cannot be read.

    Examples
    --------
    >>> report = verify_mit_berkeley(Path("no such folder"))
    >>> report.complete, report.whole, len(report.missing)
    (False, 0, 521)
    """
    recorded = mit_berkeley_files().sha256 if sha256 is None else sha256
    folder = root / "mit-berkeley"
    there = set(relative_files(folder))
    damaged = tuple(
        name
        for name in sorted(there & set(recorded))
        if file_sha256(folder / name) != recorded[name]
    )
    missing = tuple(sorted(set(recorded) - there))
    whole = len(recorded) - len(missing) - len(damaged)
    return VerificationReport(folder, whole, missing, damaged, tuple(sorted(there - set(recorded))))


def _first(names: tuple[str, ...]) -> str:
    more = ["..."] if len(names) > _NAMED else []
    return ", ".join([*names[:_NAMED], *more])
