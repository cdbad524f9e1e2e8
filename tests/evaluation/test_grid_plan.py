"""Tests of plans: cells, hours and bytes of a run that is not run."""

from __future__ import annotations

from pathlib import Path

import pytest

from evaluation.blob_store import BLOBS, BlobStore
from evaluation.grid_plan import grid_plan, in_words
from evaluation.row_store import ROWS, RowStore
from shading_model.errors import RelightlabError
from tests.evaluation.small_grids import rows_of, small_experiment


def test_a_plan_without_measured_cells(tmp_path: Path) -> None:
    """Cells and tasks are known before anything was measured, the cost is not; nothing is made."""
    for folder in (None, tmp_path / "none"):
        plan = grid_plan(small_experiment(), folder)
        assert (plan.cells, plan.done, plan.to_run, plan.tasks) == (12, 0, 12, 4)
        assert (plan.cpu_hours, plan.row_bytes, plan.blob_bytes) == (None, None, None)
        assert "measure a few with --only" in plan.lines()[-1]
    assert list(tmp_path.iterdir()) == []


def test_the_cost_is_that_of_measured_cells(tmp_path: Path) -> None:
    """Six measured cells of half a second each foretell the other six, and their bytes."""
    store = RowStore(tmp_path / ROWS)
    store.append(rows_of(small_experiment())[:6])
    blobs = BlobStore(tmp_path / BLOBS)
    blobs.get_or_make("ab" * 32, lambda: "x" * 500, Path.read_text, Path.write_text)
    plan = grid_plan(small_experiment(), tmp_path)
    assert (plan.done, plan.to_run, plan.tasks, plan.measured) == (6, 6, 2, 6)
    assert plan.seconds_per_cell == 0.5
    assert plan.cpu_hours == pytest.approx(6 * 0.5 / 3600, abs=1e-6)
    assert (plan.row_bytes, plan.blob_bytes) == (store.path.stat().st_size, 500)
    assert plan.lines()[0] == "small 1: 12 cells, 6 done, 6 to run in 2 tasks"
    everything = grid_plan(small_experiment(), tmp_path, force=True)
    assert (everything.to_run, everything.tasks, everything.blob_bytes) == (12, 4, 1000)


def test_a_part_of_a_grid(tmp_path: Path) -> None:
    """A plan for some cells counts those alone, and refuses what the grid does not have."""
    plan = grid_plan(small_experiment(), tmp_path, {"object": ["cup"]})
    assert (plan.to_run, plan.tasks) == (3, 1)
    with pytest.raises(RelightlabError, match="Did you mean 'cup'"):
        grid_plan(small_experiment(), tmp_path, {"object": ["cap"]})


def test_rows_of_older_code_still_foretell(tmp_path: Path) -> None:
    """Rows that other inputs gave are not done, but they were as much work."""
    RowStore(tmp_path / ROWS).append(rows_of(small_experiment(inputs={"data": "cd"})))
    plan = grid_plan(small_experiment(), tmp_path)
    assert (plan.done, plan.to_run, plan.measured, plan.seconds_per_cell) == (0, 12, 12, 0.5)


def test_values_that_cost_differently(tmp_path: Path) -> None:
    """Each value of the cost axis is foretold by itself; one that was never measured is named."""
    experiment = small_experiment(cost_axis="object")
    rows = [
        {**row, "seconds": 10.0 if row["cell"]["object"] == "bear" else 1.0}
        for row in rows_of(experiment)
        if row["cell"]["object"] in {"apple", "bear"} and row["cell"]["light"] == "00"
    ]
    RowStore(tmp_path / ROWS).append(rows)
    plan = grid_plan(experiment, tmp_path)
    assert (plan.done, plan.to_run, plan.measured) == (2, 10, 2)
    assert plan.cpu_hours == pytest.approx((2 * 1 + 2 * 10) / 3600, abs=1e-6)
    assert plan.unknown == ("cup", "drum")
    assert plan.lines()[-1] == "  and the cost of drum, of which none was measured yet"
    assert plan.document()["unknown"] == ["cup", "drum"]
    cheap = grid_plan(experiment, tmp_path, {"object": ["apple"]})
    assert cheap.cpu_hours == pytest.approx(2 / 3600, abs=1e-6)
    assert cheap.unknown == ()


@pytest.mark.parametrize(
    ("count", "words"), [(0, "0 B"), (999, "999 B"), (1500, "1.5 kB"), (2.5e12, "2.5 TB")]
)
def test_bytes_in_words(count: float, words: str) -> None:
    """Bytes are told with three digits and a unit."""
    assert in_words(count) == words
