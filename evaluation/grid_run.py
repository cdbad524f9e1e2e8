"""Running the cells of an experiment that a store does not hold yet.

A finished task's rows are on disk before the next result is looked at; a failed cell is a row with
its traceback and is tried again by the next run. Rows count for an experiment only if their input
hash is its own, so a change of data, parameters, protocol or code never mixes old numbers with new.
"""

from __future__ import annotations

import math
import signal
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any

from evaluation.dispatch import dispatch
from evaluation.experiment import Cell, Experiment
from evaluation.grid_status import DONE, FAILED, SKIPPED, GridStatus, grid_status
from evaluation.provenance import code_commit, environment
from evaluation.row_store import Rows

Progress = Callable[[int, int, str], None]
"""Called with cells done, cells in all, and what was done last."""


class SkippedError(Exception):
    """Raised by a measuring function for a cell that cannot exist, with the reason."""


@dataclass(frozen=True)
class RunOptions:
    """How a grid is run; none of it changes a number.

    Parameters
    ----------
    workers : int
        Processes on this machine.
    scheduler : str, optional
        Address of a Dask scheduler; then `workers` plays no part.
    only : mapping of sequences of str, optional
        Measure only cells with these values on these axes.
    force : bool
        Measure the chosen cells again, though they are done; the newest row counts.
    seconds_per_task : float, optional
        A task that takes longer is stopped and its cells have failed.
    """

    workers: int = 1
    scheduler: str | None = None
    only: Mapping[str, Sequence[str]] | None = None
    force: bool = False
    seconds_per_task: float | None = None


DEFAULT_OPTIONS = RunOptions()


def run_grid(
    experiment: Experiment,
    store: Rows,
    options: RunOptions = DEFAULT_OPTIONS,
    progress: Progress | None = None,
) -> GridStatus:
    """Measure the cells that are missing, and return what the store then holds.

    Parameters
    ----------
    experiment : Experiment
    store : Rows
    options : RunOptions
    progress : callable, optional

    Returns
    -------
    GridStatus

    Raises
    ------
    RelightlabError
        For an unknown axis or value, rows of another protocol version, a store that cannot be
        written, or a scheduler that cannot be reached.
    """
    status = grid_status(experiment, store)
    missing = None if options.force else set(status.missing)
    chosen = [
        cell
        for cell in experiment.cells(options.only)
        if missing is None or experiment.key(cell) in missing
    ]
    work = partial(measure_task, experiment, seconds=options.seconds_per_task)
    origin = row_origin(experiment)
    done, total = experiment.size - len(chosen), experiment.size
    results_as_they_finish = dispatch(
        work,
        experiment.tasks(chosen),
        workers=options.workers,
        scheduler=options.scheduler,
    )
    for cells, rows in results_as_they_finish:
        results = rows if rows is not None else _died(cells)
        store.append({**origin, **row} for row in results)
        done += len(results)
        if progress:
            progress(done, total, " ".join(experiment.key(cells[0])[:2]))
    return grid_status(experiment, store)


def measure_task(
    experiment: Experiment, cells: Sequence[Cell], *, seconds: float | None = None
) -> list[dict[str, Any]]:
    """Measure the cells of one task; whatever goes wrong becomes a row of the cells it concerns.

    Parameters
    ----------
    experiment : Experiment
    cells : sequence of mappings
    seconds : float, optional
        Time limit of the task.

    Returns
    -------
    list of dict
        ``cell, values, seconds, status, reason``, one for each cell.
    """
    rows: list[dict[str, Any]] = []
    open_cells = {experiment.key(cell): cell for cell in cells}
    started = time.perf_counter()
    status, reason = FAILED, "the measuring function gave no result for this cell"
    try:
        with _time_limit(seconds):
            for cell, values in experiment.measure(experiment.context, cells):
                open_cells.pop(experiment.key(cell))
                now = time.perf_counter()
                rows.append(_row(cell, values, now - started))
                started = now
    except SkippedError as skipped:
        status, reason = SKIPPED, str(skipped)
    except Exception:  # noqa: BLE001  a fault of any kind is a result: recorded, never cached
        reason = traceback.format_exc()
    each = (time.perf_counter() - started) / max(len(open_cells), 1)
    rows += [_unfinished(cell, status, reason, each) for cell in open_cells.values()]
    return rows


def row_origin(experiment: Experiment) -> dict[str, Any]:
    """Return what all rows of a run share: where their numbers come from.

    Parameters
    ----------
    experiment : Experiment

    Returns
    -------
    dict
        ``experiment, version, inputs, data, seed, commit, environment``.
    """
    return {
        "experiment": experiment.name,
        "version": experiment.version,
        "inputs": experiment.input_hash(),
        "data": experiment.inputs.get("data", ""),
        "seed": experiment.seed,
        "commit": code_commit(),
        "environment": environment(),
    }


def _row(cell: Cell, values: Mapping[str, float], seconds: float) -> dict[str, Any]:
    wrong = [name for name, value in values.items() if not math.isfinite(value)]
    if wrong:
        reason = f"not a finite number: {', '.join(wrong)}"
        return _unfinished(cell, FAILED, reason, seconds)
    numbers = {name: float(value) for name, value in values.items()}
    return {
        "cell": dict(cell),
        "values": numbers,
        "seconds": round(seconds, 6),
        "status": DONE,
        "reason": "",
    }


def _unfinished(cell: Cell, status: str, reason: str, seconds: float) -> dict[str, Any]:
    return {
        "cell": dict(cell),
        "values": {},
        "seconds": round(seconds, 6),
        "status": status,
        "reason": reason,
    }


def _died(cells: Sequence[Cell]) -> list[dict[str, Any]]:
    reason = "the worker process died: killed, or out of memory"
    return [_unfinished(cell, FAILED, reason, 0.0) for cell in cells]


@contextmanager
def _time_limit(seconds: float | None) -> Iterator[None]:
    """Raise TimeoutError in this thread after `seconds`; only the main thread can be stopped."""
    if seconds is None or threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(_signal: int, _frame: object) -> None:
        raise TimeoutError(f"the task took longer than {seconds:g} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
