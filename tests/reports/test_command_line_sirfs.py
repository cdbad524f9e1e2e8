"""Tests of the commands of the rival method SIRFS."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from evaluation.sirfs import absolute_color, prior_training, smoothness_search, training_data
from evaluation.sirfs.prior_files import load_priors
from evaluation.sirfs.priors import priors_identity
from reports.command_line import run
from tests.evaluation.sirfs.small_priors import small_priors, write_training_set


@pytest.fixture
def data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a data root that holds a small set, with a coarse grid of colours."""
    monkeypatch.setattr(absolute_color, "_STAGES", ((12, 10),))
    monkeypatch.setattr(training_data, "SAMPLES", 500)
    write_training_set(tmp_path / "data" / "mit-berkeley")
    return tmp_path / "data"


def test_trained_and_told(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The file holds what was learned; sizes, light and time are printed and in the JSON."""
    out, target = tmp_path / "priors.npz", tmp_path / "priors.json"
    arguments = ["--data", str(data), "--out", str(out), "--json", str(target)]
    assert run(["sirfs", "train", *arguments]) == 0
    shown = capsys.readouterr().out
    document = json.loads(target.read_text(encoding="utf-8"))
    assert document["sha256"] == priors_identity(load_priors(out))
    assert document["seconds"] >= 0
    light = document["lights"]["natural gray"]
    mean = " ".join(f"{value:.3f}" for value in light["mean"])
    assert f"natural gray light: of {light['count']} lights, mean {mean}" in shown
    assert "gray absolute: 256 knots" in shown
    assert f"written: {out} (" in shown


def test_searched(
    data: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The search prints a cost for every smoothness, and writes no priors."""
    monkeypatch.setattr(smoothness_search, "CANDIDATES", (2.0**-9, 2.0**-12))
    out, target = tmp_path / "priors.npz", tmp_path / "search.json"
    arguments = ["--data", str(data), "--out", str(out), "--json", str(target)]
    assert run(["sirfs", "train", "--search", *arguments]) == 0
    rows = json.loads(target.read_text(encoding="utf-8"))["rows"]
    assert [row["smoothness"] for row in rows] == [2.0**-9, 2.0**-12]
    assert f"smoothness 0.000244: held-out cost {rows[1]['held_out_cost']:.4f}" in (
        capsys.readouterr().out
    )
    assert not out.exists()


def test_without_the_set_nothing_is_learned(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One sentence says where it was looked for, and nothing is written."""
    out = tmp_path / "priors.npz"
    assert run(["sirfs", "train", "--data", str(tmp_path), "--out", str(out)]) == 2
    assert "mit-berkeley was not found in" in capsys.readouterr().err
    assert not out.exists()


def test_another_suffix_is_refused_first(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before any learning."""
    out = str(tmp_path / "priors.mat")
    assert run(["sirfs", "train", "--data", str(data), "--out", out]) == 2
    assert "expected --out to end in .npz" in capsys.readouterr().err


def test_by_default_the_file_of_every_fit_is_written(
    data: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The one that `shipped_priors` reads."""
    from evaluation.sirfs import prior_files

    monkeypatch.setattr(prior_files, "FILE", tmp_path / "shipped.npz")
    monkeypatch.setattr(prior_training, "train_priors", lambda *_: small_priors())
    assert run(["sirfs", "train", "--data", str(data)]) == 0
    assert f"written: {tmp_path / 'shipped.npz'}" in capsys.readouterr().out
    assert priors_identity(load_priors(tmp_path / "shipped.npz"))
