"""Files that are either whole or absent under their final name."""

from __future__ import annotations

import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from datasets.atomic import atomic_path
from shading_model.errors import RelightlabError
from tests.repository import ROOT


def visible(folder: Path) -> list[str]:
    """Names in a folder, hidden ones included."""
    return sorted(path.name for path in folder.iterdir())


def write_and_fail(target: Path, error: Exception) -> None:
    """Begin to write a file, then raise."""
    with atomic_path(target) as path:
        path.write_text("half")
        raise error


def test_a_block_that_ends_well_leaves_the_one_file(tmp_path: Path) -> None:
    """Under its final name, whole, with nothing beside it; folders are made."""
    target = tmp_path / "new" / "folder" / "model.npz"
    with atomic_path(target) as path:
        assert path.parent == target.parent
        assert path.suffix == ".npz"
        path.write_bytes(b"whole")
        assert not target.exists()
    assert target.read_bytes() == b"whole"
    assert visible(target.parent) == ["model.npz"]


def test_a_block_that_raises_leaves_nothing(tmp_path: Path) -> None:
    """The error comes through, and neither a half-written nor a temporary file stays."""
    with pytest.raises(KeyError):
        write_and_fail(tmp_path / "a.txt", KeyError())
    assert visible(tmp_path) == []


def test_a_block_that_raises_leaves_the_old_file(tmp_path: Path) -> None:
    """What was there before is there afterwards."""
    target = tmp_path / "a.txt"
    target.write_text("old")
    with pytest.raises(ValueError, match="no"):
        write_and_fail(target, ValueError("no"))
    assert target.read_text() == "old"
    assert visible(tmp_path) == ["a.txt"]


def test_an_old_file_is_replaced(tmp_path: Path) -> None:
    """The new content is all there is."""
    target = tmp_path / "a.txt"
    target.write_text("something longer")
    with atomic_path(target) as path:
        path.write_text("new")
    assert target.read_text() == "new"


KILLED = """
import os, signal, sys
from pathlib import Path
from datasets.atomic import atomic_path
with atomic_path(Path(sys.argv[1])) as path:
    path.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.parametrize("before", [None, "old"])
def test_a_killed_process_leaves_no_half_file(tmp_path: Path, before: str | None) -> None:
    """SIGKILL in the middle of writing: the final name is absent, or holds what it held."""
    target = tmp_path / "a.txt"
    if before:
        target.write_text(before)
    done = subprocess.run([sys.executable, "-c", KILLED, str(target)], cwd=ROOT, check=False)
    assert done.returncode == -signal.SIGKILL
    assert (target.read_text() if target.exists() else None) == before
    leftovers = [name for name in visible(tmp_path) if name != "a.txt"]
    assert all(name.startswith(".a-") for name in leftovers)
    assert len(leftovers) == 1


def test_a_file_has_the_permissions_of_any_other(tmp_path: Path) -> None:
    """As the user's umask has it, not the private ones of a temporary file."""
    old = os.umask(0o027)
    try:
        with atomic_path(tmp_path / "a.txt") as path:
            path.write_text("whole")
        assert os.umask(0o027) == 0o027
    finally:
        os.umask(old)
    assert stat.S_IMODE((tmp_path / "a.txt").stat().st_mode) == 0o640


def test_a_folder_that_cannot_be_made_is_one_sentence(tmp_path: Path) -> None:
    """A file stands where the folder should be."""
    (tmp_path / "taken").write_text("")
    target = tmp_path / "taken" / "a.txt"
    with (
        pytest.raises(RelightlabError, match=r"^cannot write .*a\.txt: .*; choose another output$"),
        atomic_path(target),
    ):
        pytest.fail("the block must not run")


@pytest.mark.skipif(os.geteuid() == 0, reason="the administrator may write anywhere")
def test_a_folder_without_permission_is_one_sentence(tmp_path: Path) -> None:
    """A read-only folder is told by name and reason."""
    tmp_path.chmod(0o500)
    with (
        pytest.raises(RelightlabError, match="Permission denied; choose another output"),
        atomic_path(tmp_path / "a.txt"),
    ):
        pytest.fail("the block must not run")


def test_a_target_that_is_a_folder_is_one_sentence(tmp_path: Path) -> None:
    """The file is not moved over a folder, and no temporary file stays."""
    (tmp_path / "a.txt").mkdir()
    with (
        pytest.raises(RelightlabError, match=r"cannot write .*choose another output"),
        atomic_path(tmp_path / "a.txt") as path,
    ):
        path.write_text("whole")
    assert visible(tmp_path) == ["a.txt"]


def test_a_full_disk_is_one_sentence(tmp_path: Path) -> None:
    """An operating-system error from the block itself is told as one of the output."""
    with pytest.raises(RelightlabError, match=r"a\.txt: No space left on device"):
        write_and_fail(tmp_path / "a.txt", OSError(28, "No space left on device"))
    assert visible(tmp_path) == []


def test_trouble_with_another_file_keeps_its_name(tmp_path: Path) -> None:
    """A file that the block could not read is told by its own name, and nothing is written."""
    with (
        pytest.raises(FileNotFoundError, match="template"),
        atomic_path(tmp_path / "page.html"),
    ):
        (tmp_path / "template").read_text()
    assert list(tmp_path.iterdir()) == []
