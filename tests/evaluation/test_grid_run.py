"""Tests of running a grid: what is measured, what is not measured again, what a fault becomes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from evaluation.grid_run import RunOptions, run_grid
from evaluation.grid_status import grid_status, grid_summary
from evaluation.row_store import MemoryRows, RowStore
from shading_model.errors import RelightlabError
from tests.evaluation.small_grids import Fault, rows_of, small_experiment


def test_the_second_run_measures_nothing(tmp_path: Path) -> None:
    """What a store holds is not measured again, in this process or another."""
    store = RowStore(tmp_path / "rows.jsonl")
    first = run_grid(small_experiment(), store)
    before = store.path.read_bytes()
    second = run_grid(small_experiment(), store)
    assert store.path.read_bytes() == before
    assert second.rows == first.rows
    assert (first.complete, first.sentence()) == (True, "12 done, 0 to run")


def test_only_and_force() -> None:
    """Chosen cells alone are measured; force measures them again and the newest row counts."""
    store = MemoryRows()
    only = {"object": ["cup"]}
    status = run_grid(small_experiment(), store, RunOptions(only=only))
    assert status.sentence() == "3 done, 9 to run"
    run_grid(small_experiment(), store, RunOptions(only=only, force=True))
    assert len(store.read()[0]) == 6
    assert run_grid(small_experiment(), store).complete


def test_progress_counts_every_cell() -> None:
    """Progress starts from the cells that are done and ends with all."""
    store = MemoryRows()
    run_grid(small_experiment(), store, RunOptions(only={"object": ["cup"]}))
    seen: list[int] = []
    run_grid(small_experiment(), store, progress=lambda done, *_: seen.append(done))
    assert seen == [6, 9, 12]


@pytest.mark.parametrize(
    ("kind", "words", "failed"),
    [
        ("raises", "ZeroDivisionError: no light at all", 3),
        ("gives NaN", "not a finite number: sum, half", 3),
        ("hangs", "TimeoutError: the task took longer than 0.2 s", 3),
    ],
)
def test_a_fault_is_a_row(kind: str, words: str, failed: int) -> None:
    """A cell that raises, hangs or gives NaN has failed with the reason; the others are done."""
    store = MemoryRows()
    status = run_grid(small_experiment(Fault(kind)), store, RunOptions(seconds_per_task=0.2))
    assert {row["cell"]["object"] for row in status.failed} == {"bear"}
    assert len(status.failed) == failed
    assert status.sentence() == "9 done, 3 to run; 3 of them failed before"
    assert words in status.failed[0]["reason"]
    summary = grid_summary(small_experiment(Fault(kind)), store)
    assert summary.sentence() == status.sentence()
    assert summary.reasons == {words: 3}
    assert run_grid(small_experiment(), store).complete


def test_a_cell_that_cannot_be_is_skipped() -> None:
    """A skipped cell has its reason, counts as done with, and is not tried again."""
    store = MemoryRows()
    status = run_grid(small_experiment(Fault("cannot be")), store)
    assert status.complete
    reasons = {row["reason"] for row in status.rows.values() if row["status"] == "skipped"}
    assert reasons == {"there is no such light"}
    run_grid(small_experiment(), store)
    assert len(store.read()[0]) == 12


def test_a_measuring_function_that_forgets_a_cell() -> None:
    """A cell that was not yielded has failed."""
    experiment = small_experiment(measure=_nothing)
    status = run_grid(experiment, MemoryRows())
    assert len(status.failed) == 12
    assert "gave no result" in status.failed[0]["reason"]


def _nothing(_context: object, _cells: object) -> Any:
    return iter(())


@pytest.mark.parametrize("read", [grid_status, grid_summary, run_grid])
def test_another_protocol_version_is_refused(read: Any) -> None:
    """Rows of another version of the protocol do not mix with this one's."""
    store = MemoryRows()
    store.append(rows_of(small_experiment(version=2)))
    with pytest.raises(RelightlabError, match="protocol small 2, this is version 1: keep it and"):
        read(small_experiment(), store)


def test_rows_of_other_inputs_are_stale() -> None:
    """Rows that other data gave are left out and counted, those of other experiments are not."""
    store = MemoryRows()
    store.append(rows_of(small_experiment(inputs={"data": "cd"})))
    store.append(rows_of(small_experiment(name="other")))
    status = grid_status(small_experiment(), store)
    summary = grid_summary(small_experiment(), store)
    assert (status.stale, summary.stale, len(status.missing), summary.to_run) == (12, 12, 12, 12)
    assert "12 rows of other data, parameters or code are left out" in summary.sentence()


def test_damaged_rows_are_measured_again(tmp_path: Path) -> None:
    """A damaged line is reported by its number, and its cell alone is measured again."""
    store = RowStore(tmp_path / "rows.jsonl")
    whole = run_grid(small_experiment(), store)
    lines = store.path.read_bytes().splitlines(keepends=True)
    lines[2] = lines[2].replace(b"done", b"doen")
    store.path.write_bytes(b"".join(lines))
    summary = grid_summary(small_experiment(), store)
    assert summary.sentence() == "11 done, 1 to run; 1 damaged lines (line 3) are measured again"
    again = run_grid(small_experiment(), store)
    values = [{key: row["values"] for key, row in s.rows.items()} for s in (whole, again)]
    assert values[0] == values[1]
    assert len(store.read()[0]) == 12
