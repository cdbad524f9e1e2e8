"""Dispatching to a real Dask scheduler with two worker processes, all of the test's own."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path

import pytest

from datasets.model_parameters import shipped_parameters
from datasets.synthetic import Synthetic, synthesize
from evaluation import dispatch as dispatch_module
from evaluation.dispatch import dispatch
from evaluation.experiment import Experiment
from evaluation.grid_run import RunOptions, run_grid
from evaluation.row_store import MemoryRows
from evaluation.table1 import run_table1
from evaluation.table1_record import Table1
from reports.command_line import run
from shading_model.errors import RelightlabError
from tests.evaluation.conftest import LIGHTS
from tests.evaluation.dispatch_tasks import MarkingWork, broken, hanging_cell, threads_here
from tests.repository import ROOT

pytestmark = pytest.mark.slow

SQUARES = {number: number * number for number in range(12)}


@contextmanager
def process(*words: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run a Python module in a session of its own, and end all of it."""
    started = subprocess.Popen(
        [sys.executable, "-m", *words],
        cwd=ROOT,
        env={**os.environ, "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "3s"},
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield started
    finally:
        with suppress(ProcessLookupError):
            os.killpg(started.pid, signal.SIGKILL)
        started.wait()


def free_port() -> int:
    """A port of the loopback that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
    return port


@contextmanager
def scheduler() -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """A scheduler, by its address."""
    port = str(free_port())
    words = ("--host", "127.0.0.1", "--port", port, "--no-dashboard", "--no-show")
    with process("distributed.cli.dask_scheduler", *words) as started:
        yield f"tcp://127.0.0.1:{port}", started


def worker(address: str, *words: str) -> AbstractContextManager[subprocess.Popen[bytes]]:
    """A worker with its nanny, which starts it again when it is killed."""
    common = ("--no-dashboard", "--memory-limit", "0", "--nthreads", "1")
    return process("distributed.cli.dask_worker", address, *common, *words)


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    """The address of a scheduler with two workers of one thread each."""
    with scheduler() as (address, _), worker(address), worker(address):
        yield address


def workers_of(address: str) -> dict[str, int]:
    """The process numbers of the workers of a cluster, by address."""
    import distributed

    with distributed.Client(address, set_as_default=False) as client:
        client.wait_for_workers(1, timeout=30)
        numbers: dict[str, int] = client.run(os.getpid)
        return numbers


def test_table1_through_dask_is_the_serial_one(
    cluster: str, tiny_set: Synthetic, tiny_table: Table1
) -> None:
    """Row for row, to the last bit, and every cell is there."""
    through = run_table1(
        tiny_set, LIGHTS, shipped_parameters(), quick=True, options=RunOptions(scheduler=cluster)
    )
    assert through.missing == ()
    assert through.rows() == tiny_table.rows()
    assert through.object_rows() == tiny_table.object_rows()
    assert through.intrinsic_rows() == tiny_table.intrinsic_rows()


def test_results_come_as_they_finish(cluster: str, tmp_path: Path) -> None:
    """The first is here while others have not begun, and two workers have had a part."""
    work = MarkingWork(tmp_path, seconds=0.3)
    results = dispatch(work, range(12), scheduler=cluster)
    first = next(results)
    assert len(list(tmp_path.iterdir())) < 12
    assert dict([first, *results]) == SQUARES
    assert len(work.processes()) == 2


def test_tasks_have_one_thread_in_processes_of_their_own(cluster: str) -> None:
    """Whatever the environment of the worker was."""
    ((_, (threads, environment)),) = dispatch(threads_here, [0], scheduler=cluster)
    assert threads
    assert set(threads) == {1}
    assert set(environment.values()) == {"1"}


def test_a_worker_killed_in_the_middle_costs_time_not_cells(cluster: str, tmp_path: Path) -> None:
    """Its tasks are done by the other, or by itself when its nanny has started it again."""
    work = MarkingWork(tmp_path, seconds=0.3)
    victim = next(iter(workers_of(cluster).values()))
    results = dispatch(work, range(12), scheduler=cluster)
    first = next(results)
    os.kill(victim, signal.SIGKILL)
    assert dict([first, *results]) == SQUARES


def test_a_task_killed_for_memory_spares_its_worker(cluster: str, tmp_path: Path) -> None:
    """Killed once it is repeated; killed again it alone has no result; no worker was lost."""
    before = workers_of(cluster)
    for times, result in ((1, 9), (99, None)):
        work = MarkingWork(tmp_path / str(times), killing=3, times=times)
        work.folder.mkdir()
        assert dict(dispatch(work, range(12), scheduler=cluster)) == {**SQUARES, 3: result}
        assert work.attempts(3) == 2
    assert workers_of(cluster) == before


def test_a_task_that_takes_its_worker_along_is_given_up(cluster: str, tmp_path: Path) -> None:
    """After Dask has lost several workers over it, twice; all the others are done."""
    work = MarkingWork(tmp_path, killing=3, times=99, parent_too=True)
    assert dict(dispatch(work, range(12), scheduler=cluster)) == {**SQUARES, 3: None}


def test_a_task_that_hangs_is_stopped(cluster: str) -> None:
    """The time limit holds on a Dask worker too, whose own threads nothing can stop."""
    experiment = Experiment(
        name="hanging",
        version=1,
        axes={"number": ("0", "1", "2")},
        together=(),
        measure=hanging_cell,
        context="1",
        inputs={},
        seed="",
    )
    started = time.monotonic()
    options = RunOptions(scheduler=cluster, seconds_per_task=2)
    status = run_grid(experiment, MemoryRows(), options)
    assert time.monotonic() - started < 30
    assert status.missing == (("1",),)
    assert "the task took longer than 2 s" in status.failed[0]["reason"]


def test_a_worker_that_cannot_do_the_work_stops_the_run(
    cluster: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Other code on the cluster, or work that raises: one sentence instead of failed cells."""
    with pytest.raises(RelightlabError, match=r"stopped \(ZeroDivisionError: work returns its"):
        list(dispatch(broken, [1], scheduler=cluster))
    monkeypatch.setattr(dispatch_module, "code_hash", lambda: "another version")
    with pytest.raises(RelightlabError, match="of another version than the one that asks"):
        list(dispatch(abs, [1], scheduler=cluster))


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:{port}", "nonsense://x", "tcp://:x"])
def test_an_unreachable_scheduler_is_one_sentence(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Within the time a user waits for it."""
    monkeypatch.setattr(dispatch_module, "CONNECTION_SECONDS", 2)
    given = address.format(port=free_port())
    started = time.monotonic()
    with pytest.raises(RelightlabError, match="no Dask scheduler answers at"):
        list(dispatch(abs, [1], scheduler=given))
    assert time.monotonic() - started < 5


def test_a_scheduler_that_dies_stops_the_run(tmp_path: Path) -> None:
    """In one sentence that says that nothing measured was lost."""
    import dask

    quick = {"distributed.comm.timeouts.connect": "2s"}
    with dask.config.set(quick), scheduler() as (address, started), worker(address):
        results = dispatch(MarkingWork(tmp_path, seconds=0.3), range(12), scheduler=address)
        next(results)
        os.killpg(started.pid, signal.SIGKILL)
        with pytest.raises(RelightlabError, match="what was measured is kept"):
            list(results)


def test_the_command_runs_on_a_cluster(
    cluster: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """``evaluate rerendering --scheduler`` writes the rows of a run on this machine."""
    synthesize(tmp_path / "set", size=40, samples=1, objects=["apple", "pear"], workers=1)
    command = ["evaluate", "rerendering", "--data", str(tmp_path / "set"), "--workers", "1"]
    command.append("--quick")
    written = []
    for name, options in (("here", ()), ("cluster", ("--scheduler", cluster))):
        target = tmp_path / f"{name}.json"
        assert run([*command, "--json", str(target), *options]) == 0
        written.append(json.loads(target.read_text()))
    assert written[0]["rows"] == written[1]["rows"]
    assert written[0]["objects"] == written[1]["objects"]
    assert written[1]["missing"] == []
    assert "Table 1" in capsys.readouterr().out
