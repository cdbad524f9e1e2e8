"""Where a result came from."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest

from evaluation import provenance
from evaluation.provenance import UNKNOWN, VERSIONED, Provenance, code_commit, provenance_of
from tests.repository import ROOT


def git(folder: Path, *words: str) -> str:
    """Run git in a folder, as nobody in particular."""
    who = ["-c", "user.name=nobody", "-c", "user.email=nobody@example.org"]
    command = ["git", "-C", str(folder), *who, *words]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A git checkout of one commit that holds the module whose commit is asked for."""
    module = tmp_path / "evaluation" / "provenance.py"
    module.parent.mkdir()
    module.write_text("")
    git(tmp_path, "init", "--quiet")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "--quiet", "-m", "first")
    monkeypatch.setattr(provenance, "__file__", str(module))
    return tmp_path


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="not a git checkout")
def test_the_commit_of_this_checkout_is_known() -> None:
    """It is the one git names, marked where files differ from it."""
    assert code_commit().removesuffix("+changes") == git(ROOT, "rev-parse", "HEAD")


def test_a_clean_checkout_is_its_commit(checkout: Path) -> None:
    """Forty hexadecimal digits; new files beside it do not count."""
    (checkout / "note.txt").write_text("new")
    assert code_commit() == git(checkout, "rev-parse", "HEAD")
    assert re.fullmatch("[0-9a-f]{40}", code_commit())


def test_changed_files_are_marked(checkout: Path) -> None:
    """Committed files that differ make the commit alone insufficient."""
    (checkout / "evaluation" / "provenance.py").write_text("changed")
    assert code_commit() == git(checkout, "rev-parse", "HEAD") + "+changes"


def test_outside_git_the_commit_is_unknown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As for an installed package."""
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    monkeypatch.setattr(provenance, "__file__", str(tmp_path / "provenance.py"))
    assert code_commit() == UNKNOWN


def test_the_commit_of_a_checkout_around_the_environment_is_not_ours(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A package installed in an environment inside somebody's checkout has no commit."""
    installed = checkout / ".venv" / "evaluation" / "provenance.py"
    installed.parent.mkdir(parents=True)
    installed.write_text("")
    monkeypatch.setattr(provenance, "__file__", str(installed))
    assert code_commit() == UNKNOWN


def test_without_git_the_commit_is_unknown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine that has no git runs all the same."""
    monkeypatch.setenv("PATH", str(tmp_path))
    assert code_commit() == UNKNOWN


def measured() -> Provenance:
    """The provenance of some run."""
    return provenance_of(
        protocol="table-1 version 1",
        dataset="synthetic",
        data_hash="0" * 64,
        seeds={"lights": "table 1 lights"},
        seconds=12.345678,
        workers=2,
        cells_done=400,
        cells_missing=0,
    )


def test_the_record_is_json_and_names_every_version() -> None:
    """It can be written and read back, with the versions that numbers depend on."""
    document = measured().document()
    assert json.loads(json.dumps(document, allow_nan=False)) == document
    assert set(document["versions"]) == set(VERSIONED)
    assert all(re.match(r"\d+\.\d+", number) for number in document["versions"].values())
    assert document["seconds"] == 12.3
    assert (document["cells_done"], document["cells_missing"]) == (400, 0)
