"""Verification of a downloaded set."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from datasets.verification import VerificationReport, verify_mit_berkeley

RECORDED = {name: hashlib.sha256(name.encode()).hexdigest() for name in ("a/1", "a/2", "b")}


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Make a whole set of three files."""
    folder = tmp_path / "mit-berkeley"
    (folder / "a").mkdir(parents=True)
    for name in RECORDED:
        (folder / name).write_text(name)
    return tmp_path


def test_whole_set(root: Path) -> None:
    """A whole set is complete and has nothing else to tell."""
    report = verify_mit_berkeley(root, sha256=RECORDED)
    assert report == VerificationReport(root / "mit-berkeley", 3, (), (), ())
    assert report.complete
    assert report.sentence() == f"{root / 'mit-berkeley'}: 3 of 3 files are whole"


def test_every_kind_of_fault(root: Path) -> None:
    """Missing, damaged and extra files are told apart and named."""
    folder = root / "mit-berkeley"
    (folder / "a/1").write_text("a/7")
    (folder / "a/2").unlink()
    (folder / "notes.txt").touch()
    report = verify_mit_berkeley(root, sha256=RECORDED)
    assert report == VerificationReport(folder, 1, ("a/2",), ("a/1",), ("notes.txt",))
    assert not report.complete
    assert report.sentence().endswith(
        "1 of 3 files are whole, 1 missing (a/2), 1 damaged (a/1), 1 not of the set (notes.txt)"
    )


@pytest.mark.parametrize("fault", ["damaged", "missing"])
def test_one_fault_is_incomplete(root: Path, fault: str) -> None:
    """One truncated file, or one missing, is enough for the set not to be complete."""
    path = root / "mit-berkeley" / "b"
    if fault == "damaged":
        path.write_text("")
    else:
        path.unlink()
    report = verify_mit_berkeley(root, sha256=RECORDED)
    assert not report.complete
    assert getattr(report, fault) == ("b",)


def test_folder_in_place_of_a_file(root: Path) -> None:
    """A folder with a file's name is a missing file."""
    (root / "mit-berkeley" / "b").unlink()
    (root / "mit-berkeley" / "b").mkdir()
    assert verify_mit_berkeley(root, sha256=RECORDED).missing == ("b",)


def test_extra_and_unfinished_files_do_no_harm(root: Path) -> None:
    """Extra files leave a set complete, and unfinished downloads are not even told."""
    (root / "mit-berkeley" / "notes.txt").touch()
    (root / "mit-berkeley" / ".unfinished").mkdir()
    (root / "mit-berkeley" / ".unfinished" / "part").touch()
    report = verify_mit_berkeley(root, sha256=RECORDED)
    assert report.complete
    assert report.extra == ("notes.txt",)


def test_no_set_at_all(tmp_path: Path) -> None:
    """Where there is no folder every file is missing, and the sentence names the first five."""
    report = verify_mit_berkeley(tmp_path)
    assert (report.whole, len(report.missing)) == (0, 521)
    assert report.sentence().count(".") == report.folder.as_posix().count(".") + 5 + 3


@pytest.mark.real_data
def test_published_set(mit_berkeley_root: Path) -> None:
    """The published set has all 521 recorded files with the recorded content."""
    report = verify_mit_berkeley(mit_berkeley_root.parent)
    assert report.whole == 521, report.sentence()
    assert report.complete
