"""The times of a fit: parts of one evaluation, and the bound of memory."""

from __future__ import annotations

from pathlib import Path

import pytest

from datasets.own_folder import OwnFolder
from evaluation import sirfs_benchmark
from evaluation.sirfs.fit import FitOptions
from evaluation.sirfs_benchmark import fit_times, report_fit
from tests.datasets.own_set import write_object


def test_parts_make_up_an_evaluation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every part takes some time, the bound is below the whole, and all of it is printed."""
    write_object(tmp_path / "ball")
    dataset = OwnFolder(tmp_path)
    monkeypatch.setattr(sirfs_benchmark, "FitOptions", lambda **_: FitOptions(evaluations=(20,)))
    monkeypatch.setattr(sirfs_benchmark, "SETTING", dataset.settings[0])
    times = fit_times(dataset, "ball")
    assert times.evaluations <= 20
    assert times.parts["all"] > times.bound > 0
    assert times.parts["curvature"] > 0
    assert sum(times.parts.values()) < 4 * times.parts["all"]
    lines = report_fit(times)
    assert "SIRFS on ball in colour" in lines[0]
    assert len(lines) == 2 + len(times.parts) - 1


def test_a_fit_over_its_limit_is_marked() -> None:
    """A fit that takes longer than it may says so."""
    times = sirfs_benchmark.FitTimes("raccoon", 9, 4, 16.0, 100, {"all": 0.1}, 0.01)
    assert "SLOWER" in report_fit(times)[0]
