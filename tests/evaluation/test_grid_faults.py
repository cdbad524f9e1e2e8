"""Faults of the machine: kill -9, Ctrl-C, two runs at once, a deleted blob, a full disk."""

from __future__ import annotations

import errno
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from datasets.model_parameters import shipped_parameters
from datasets.synthetic import Synthetic
from evaluation.blob_store import BLOBS, blob_fault, blob_files
from evaluation.experiment import CellKey, Experiment
from evaluation.grid_run import RunOptions, run_grid
from evaluation.grid_status import GridStatus, grid_status, grid_summary
from evaluation.kept_models import KeptModels
from evaluation.row_store import ROWS, MemoryRows, RowStore
from evaluation.table1 import run_table1
from evaluation.table1_record import Table1
from shading_model.errors import RelightlabError
from tests.evaluation.conftest import LIGHTS
from tests.evaluation.small_grids import Fault, small_experiment

SMALL_KILLS, TABLE_KILLS = 42, 8
MANY, FEW = 200, 40
"""Objects of the small experiment, three lights each."""
SMALL = """
import sys
from pathlib import Path
from evaluation.grid_run import RunOptions, run_grid
from evaluation.row_store import RowStore
from tests.evaluation.small_grids import Fault, small_experiment
names = tuple(f"object {number}" for number in range(int(sys.argv[4])))
axes = {"object": names, "light": ("00", "01", "02")}
experiment = small_experiment(Fault(seconds=float(sys.argv[2])), axes=axes)
print("started", flush=True)
run_grid(experiment, RowStore(Path(sys.argv[1])), RunOptions(workers=int(sys.argv[3])))
"""
TABLE = """
import sys
from pathlib import Path
from datasets.model_parameters import shipped_parameters
from datasets.synthetic import Synthetic
from evaluation.grid_run import RunOptions
from evaluation.kept_models import KeptModels
from evaluation.row_store import RowStore
from evaluation.table1 import run_table1
from tests.evaluation.conftest import LIGHTS
folder = Path(sys.argv[2])
dataset, parameters = Synthetic(Path(sys.argv[1])), shipped_parameters()
print("started", flush=True)
run_table1(dataset, LIGHTS, parameters, store=RowStore(folder / "rows.jsonl"), quick=True,
           kept=KeptModels(folder / "blobs"), options=RunOptions(workers=int(sys.argv[3])))
"""


def started(code: str, *arguments: object) -> subprocess.Popen[bytes]:
    """Start a run in a process group of its own, and return once it has begun to work."""
    command = [sys.executable, "-c", code, *map(str, arguments)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, start_new_session=True)
    assert process.stdout is not None
    assert process.stdout.readline() == b"started\n"
    return process


def end(process: subprocess.Popen[bytes], how: int = signal.SIGKILL) -> int:
    """Send a signal to a run and its workers, and return its exit code."""
    with process:
        os.killpg(process.pid, how)
        return process.wait(timeout=60)


def same_tables(first: Table1, second: Table1) -> bool:
    """Return whether two tables agree to the last bit, and both are whole."""
    kinds = (Table1.rows, Table1.baselines, Table1.object_rows, Table1.intrinsic_rows)
    return not second.missing and all(kind(first) == kind(second) for kind in kinds)


def values_of(status: GridStatus) -> dict[CellKey, dict[str, float]]:
    """Return what was measured in each cell."""
    return {key: row["values"] for key, row in status.rows.items()}


def small(count: int) -> Experiment:
    """The experiment of `SMALL`."""
    axes = {"object": tuple(f"object {n}" for n in range(count)), "light": ("00", "01", "02")}
    return small_experiment(axes=axes)


@pytest.mark.slow
def test_killed_again_and_again_the_grid_ends_whole(tmp_path: Path) -> None:
    """Killed at random moments, each run keeps what it found; the last ends as if undisturbed."""
    draw = random.Random(0)
    store = RowStore(tmp_path / ROWS)
    done = [0]
    for number in range(SMALL_KILLS):
        process = started(SMALL, store.path, 0.02, 1 + number % 10 // 9, MANY)
        time.sleep(draw.uniform(0.0, 0.1))
        assert end(process) == -signal.SIGKILL
        done.append(grid_summary(small(MANY), store).done)
    assert done == sorted(done)
    assert 0 < done[-1] < 3 * MANY
    disturbed = run_grid(small(MANY), store)
    assert disturbed.complete
    assert values_of(disturbed) == values_of(run_grid(small(MANY), MemoryRows()))


@pytest.mark.slow
def test_table1_killed_again_and_again(
    tiny_set: Synthetic, tiny_table: Table1, tmp_path: Path
) -> None:
    """Table 1 with its models kept, killed at random moments, is the undisturbed one in the end."""
    draw = random.Random(1)
    store = RowStore(tmp_path / ROWS)
    codes = []
    for number in range(TABLE_KILLS):
        process = started(TABLE, tiny_set.root, tmp_path, 1 + number % 2)
        time.sleep(draw.uniform(0.05, 0.5))
        codes.append(end(process))
    assert set(codes) <= {-signal.SIGKILL, 0}
    assert codes.count(-signal.SIGKILL) >= TABLE_KILLS // 2
    kept = KeptModels(tmp_path / BLOBS)
    table = run_table1(tiny_set, LIGHTS, shipped_parameters(), store=store, kept=kept, quick=True)
    assert same_tables(tiny_table, table)


@pytest.mark.parametrize("workers", [1, 2])
def test_ctrl_c_keeps_what_was_measured(tmp_path: Path, workers: int) -> None:
    """Ctrl-C ends a run at once; its rows are whole and the next run says how many are left."""
    store = RowStore(tmp_path / ROWS)
    process = started(SMALL, store.path, 0.1, workers, FEW)
    deadline = time.monotonic() + 30
    while len(store.read()[0]) < 6 and time.monotonic() < deadline:
        time.sleep(0.02)
    with process:
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=20) != 0
    status = grid_status(small(FEW), store)
    assert status.damaged == ()
    assert 0 < len(status.rows) < 120
    assert f"{len(status.rows)} done, {120 - len(status.rows)} to run" == status.sentence()


def test_two_runs_on_one_store_at_once(tmp_path: Path) -> None:
    """Two runs at once may measure a cell twice, but lose and mix nothing."""
    store = RowStore(tmp_path / ROWS)
    both = [started(SMALL, store.path, 0.01, 1, FEW) for _ in range(2)]
    assert [process.communicate(timeout=60)[0] for process in both] == [b"", b""]
    assert [process.returncode for process in both] == [0, 0]
    status = run_grid(small(FEW), store)
    assert (status.complete, status.damaged) == (True, ())
    assert values_of(status) == values_of(run_grid(small(FEW), MemoryRows()))


def test_an_output_that_cannot_be_written(tmp_path: Path) -> None:
    """A store below a file stops the run in one sentence."""
    (tmp_path / "file").touch()
    with pytest.raises(RelightlabError, match=r"cannot read .*: Not a directory"):
        run_grid(small_experiment(), RowStore(tmp_path / "file" / ROWS))


def test_a_disk_that_fills_up_in_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The run stops in one sentence, what was measured is safe, and the next run goes on."""
    flushes = iter(range(100))

    def flush(_descriptor: int) -> None:
        if next(flushes) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    store = RowStore(tmp_path / ROWS)
    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", flush)
        with pytest.raises(RelightlabError, match="No space left on device; the rows written bef"):
            run_grid(small_experiment(), store)
    status = grid_status(small_experiment(), store)
    assert (status.sentence(), status.damaged) == ("6 done, 6 to run", ())
    assert run_grid(small_experiment(), store).complete


def test_a_deleted_and_a_damaged_model(
    tiny_set: Synthetic, tiny_table: Table1, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Kept models change no bit; one that was deleted or damaged is told and built again."""
    kept = KeptModels(tmp_path / BLOBS)
    parameters = shipped_parameters()
    assert same_tables(tiny_table, run_table1(tiny_set, LIGHTS, parameters, kept=kept, quick=True))
    models = list(blob_files(kept.folder))
    assert len(models) == 2 * len(tiny_set.objects) * len(tiny_set.settings)
    models[0].unlink()
    os.truncate(models[1], 1000)
    assert same_tables(tiny_table, run_table1(tiny_set, LIGHTS, parameters, kept=kept, quick=True))
    told = " ".join(record.getMessage() for record in caplog.records)
    assert "its content was deleted; it is made again" in told
    assert "does not fit its SHA-256; it is made again" in told
    assert [blob_fault(model) for model in models] == [None] * len(models)


def test_a_hanging_task_in_a_worker_process(tmp_path: Path) -> None:
    """A task that hangs in a worker is stopped there too, and the others are done."""
    store = RowStore(tmp_path / ROWS)
    experiment = small_experiment(Fault("hangs"))
    status = run_grid(experiment, store, RunOptions(workers=2, seconds_per_task=0.5))
    assert {row["cell"]["object"] for row in status.failed} == {"bear"}
    assert "took longer than 0.5 s" in status.failed[0]["reason"]
    assert len(status.missing) == 3
