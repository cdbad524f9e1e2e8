"""Tests of the commands that list, verify and make sets of pictures."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from reports.command_line import run
from shading_model.errors import RelightlabError


def test_list_prints_and_writes_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every known set is listed, here or not; the JSON has the same rows."""
    (tmp_path / "hdri").mkdir()
    (tmp_path / "hdri" / "a.exr").write_bytes(b"123")
    assert run(["data", "list", "--data", str(tmp_path), "--json", str(tmp_path / "l.json")]) == 0
    shown = capsys.readouterr().out
    rows = {row["name"]: row for row in json.loads((tmp_path / "l.json").read_text())["rows"]}
    assert all(name in shown for name in rows)
    assert (rows["hdri"]["present"], rows["hdri"]["bytes"]) == (True, 3)
    assert rows["mit-berkeley"]["present"] is False
    assert "not here" in shown


def test_verify_counts_what_is_missing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """An incomplete set fails with exit code 2, and the JSON names every missing file."""
    folder = tmp_path / "mit-berkeley"
    folder.mkdir()
    (folder / "natural_lights.mat").write_bytes(b"damaged")
    target = tmp_path / "report.json"
    assert run(["data", "verify", "--data", str(tmp_path), "--json", str(target)]) == 2
    report = json.loads(target.read_text())
    assert report["damaged"] == ["natural_lights.mat"]
    assert (report["whole"], len(report["missing"])) == (0, 520)
    assert "run 'relightlab data fetch mit-berkeley'" in capsys.readouterr().err


@pytest.mark.real_data
def test_the_measured_set_verifies(data_root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Every file of the measured set has its recorded content."""
    assert run(["data", "verify", "--data", str(data_root)]) == 0
    assert "521" in capsys.readouterr().out


def test_synthesize_makes_a_set(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The set is made, progress goes to standard error, and making it again gives its bytes."""
    made = ["data", "synthesize", "--size", "32", "--samples", "1", "--objects", "apple"]
    made += ["--workers", "1"]
    assert run([*made, "--out", str(tmp_path / "a")]) == 0
    shown = capsys.readouterr()
    assert "1 objects, fingerprint" in shown.out
    assert shown.err == "making objects: 1 of 1 (apple)\n"
    assert run([*made, "--out", str(tmp_path / "b")]) == 0
    first, second = ((tmp_path / name / "apple.npz").read_bytes() for name in "ab")
    assert first == second


def test_fetch_shows_the_licence_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the licence accepted it is shown, and what the download says is passed on."""

    def unreachable(root: Path, *, accept_licence: bool, progress: object) -> None:
        assert (root, accept_licence, callable(progress)) == (tmp_path, True, True)
        raise RelightlabError("no connection")

    monkeypatch.setattr("datasets.fetching.fetch_mit_berkeley", unreachable)
    arguments = ["data", "fetch", "mit-berkeley", "--data", str(tmp_path), "--accept-licence"]
    assert run(arguments) == 2
    shown = capsys.readouterr()
    assert "Regents of the University of California" in shown.out
    assert shown.err == "relightlab: no connection\n"
