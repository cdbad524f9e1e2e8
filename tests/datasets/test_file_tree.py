"""Fingerprints of files and folders."""

from __future__ import annotations

import hashlib
import shutil
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from datasets.file_tree import file_sha256, folder_fingerprint, relative_files, size_on_disk
from shading_model.errors import RelightlabError


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Make a folder with three visible files and two hidden ones."""
    root = tmp_path / "tree"
    contents = {"b.txt": "two", "a/c.txt": "three", "a.txt": "", ".hidden": "x", ".part/d": "y"}
    for name, text in contents.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


def test_fingerprint_closed_form(tree: Path) -> None:
    """The fingerprint is the SHA-256 over sorted lines of content hash and relative name."""
    contents = {"a.txt": b"", "a/c.txt": b"three", "b.txt": b"two"}
    lines = [f"{hashlib.sha256(held).hexdigest()} {name}\0" for name, held in contents.items()]
    assert folder_fingerprint(tree) == hashlib.sha256("".join(lines).encode()).hexdigest()


def test_fingerprint_of_a_copy(tree: Path, tmp_path: Path) -> None:
    """A copy elsewhere, with other times and in any order, has the same fingerprint."""
    copy = Path(shutil.copytree(tree, tmp_path / "copy", copy_function=shutil.copyfile))
    backwards = [copy / name for name in reversed(relative_files(copy))]
    assert folder_fingerprint(copy, backwards) == folder_fingerprint(tree)


@pytest.mark.parametrize("change", ["content", "name", "gone", "more"])
def test_fingerprint_tells_a_change(tree: Path, change: str) -> None:
    """Another content of the same length, another name, a file less or more change it."""
    before = folder_fingerprint(tree)
    if change == "content":
        (tree / "b.txt").write_text("owt")
    elif change == "name":
        (tree / "b.txt").rename(tree / "c.txt")
    elif change == "gone":
        (tree / "a.txt").unlink()
    else:
        (tree / "d.txt").touch()
    assert folder_fingerprint(tree) != before


def test_fingerprint_ignores_repeated_paths(tree: Path) -> None:
    """A file named twice counts once."""
    once = folder_fingerprint(tree, [tree / "b.txt"])
    assert folder_fingerprint(tree, [tree / "b.txt", tree / "b.txt"]) == once


def test_file_outside_the_folder(tree: Path) -> None:
    """A file that does not lie below the folder has no relative name, which is told."""
    with pytest.raises(RelightlabError, match="expected files below"):
        folder_fingerprint(tree / "a", [tree / "b.txt"])


def test_missing_file(tree: Path) -> None:
    """A file that is gone is told by its name."""
    with pytest.raises(RelightlabError, match=r"cannot read .*gone.txt: No such file"):
        folder_fingerprint(tree, [tree / "gone.txt"])


@given(st.binary(max_size=300))
def test_file_sha256(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    """The hash of a file is the hash of its bytes."""
    path = tmp_path_factory.mktemp("hash") / "file"
    path.write_bytes(content)
    assert file_sha256(path) == hashlib.sha256(content).hexdigest()


def test_size_on_disk(tree: Path) -> None:
    """Size and number count visible files only, and nothing where there is no folder."""
    assert size_on_disk(tree) == (3, 8)
    assert size_on_disk(tree / "nowhere") == (0, 0)
