"""What a run of a grid would cost, from what its measured cells have cost; nothing is run.

The estimate is the mean over all measured cells of the experiment in the store, also of those that
other inputs gave, times the cells to run; where an experiment says that the values of one of its
axes cost differently, for each value by itself. The first cell of a task carries the work that the
others share: whoever measures a few cells for an estimate should measure whole tasks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from evaluation.blob_store import BLOBS, blob_files
from evaluation.experiment import Cell, Experiment
from evaluation.grid_status import CLOSED, GridSummary, cell_states
from evaluation.row_store import ROWS, MemoryRows, RowStore
from evaluation.stored_cells import cell_place

_UNITS = ("B", "kB", "MB", "GB", "TB", "PB")


@dataclass(frozen=True)
class GridPlan:
    """What a run would do and cost.

    Parameters
    ----------
    protocol : str
    cells, done, to_run, tasks : int
        Cells of the grid, those done, those to run, and the tasks they are run by; a task is one
        unit of work for a worker.
    measured : int
        Cells that the estimates are made from.
    seconds_per_cell, cpu_hours : float or None
        Of one core; None where no cell was measured yet.
    row_bytes, blob_bytes : int or None
        That the run will add to the store.
    unknown : tuple of str
        Kinds of cells of which none was measured yet: their cost is not counted.
    """

    protocol: str
    cells: int
    done: int
    to_run: int
    tasks: int
    measured: int
    seconds_per_cell: float | None
    cpu_hours: float | None
    row_bytes: int | None
    blob_bytes: int | None
    unknown: tuple[str, ...] = ()

    def document(self) -> dict[str, Any]:
        """Return the plan as plain JSON values."""
        return {**asdict(self), "unknown": list(self.unknown)}

    def lines(self) -> list[str]:
        """Return the plan in words, one fact a line."""
        counts = f"{self.cells} cells, {self.done} done, {self.to_run} to run"
        head = [f"{self.protocol}: {counts} in {self.tasks} tasks"]
        if self.cpu_hours is None or self.seconds_per_cell is None:
            return [
                *head,
                "no cell was measured yet: measure a few with --only and --store, then plan again",
            ]
        return [
            *head,
            f"estimated from {self.measured} measured cells of {self.seconds_per_cell:.3g} s each:",
            f"  {self.cpu_hours:.3g} CPU-hours",
            f"  {in_words(self.row_bytes or 0)} of rows, {in_words(self.blob_bytes or 0)} of blobs",
            *(f"  and the cost of {kind}, of which none was measured yet" for kind in self.unknown),
        ]


def grid_plan(
    experiment: Experiment,
    folder: Path | None = None,
    only: Mapping[str, Sequence[str]] | None = None,
    *,
    force: bool = False,
) -> GridPlan:
    """Return what a run would do and cost, without running anything.

    Parameters
    ----------
    experiment : Experiment
    folder : Path, optional
        Of the store; without one, nothing is done yet and no estimate can be made.
    only, force : optional
        As in `evaluation.grid_run.RunOptions`.

    Returns
    -------
    GridPlan

    Raises
    ------
    RelightlabError
        For an unknown axis or value, or a store of another protocol version.
    """
    rows = MemoryRows() if folder is None else RowStore(folder / ROWS)
    states, summary = cell_states(experiment, rows)
    place = cell_place(experiment)
    closed = () if force else CLOSED
    chosen = [cell for cell in experiment.cells(only) if states[place(cell)] not in closed]
    each = summary.seconds / summary.measured if summary.measured else None
    share = len(chosen) / summary.measured if summary.measured else None
    seconds, unknown = _seconds(experiment, summary, chosen)
    # A cell that is measured again finds its blobs.
    heavy = len(chosen) / (summary.done or summary.measured or 1)
    return GridPlan(
        protocol=experiment.protocol,
        cells=summary.cells,
        done=summary.done + summary.skipped,
        to_run=len(chosen),
        tasks=len(experiment.tasks(chosen)),
        measured=summary.measured,
        seconds_per_cell=None if each is None else round(each, 6),
        cpu_hours=None if each is None else round(seconds / 3600, 6),
        row_bytes=None if share is None or folder is None else round(_row_bytes(folder) * share),
        blob_bytes=None if share is None or folder is None else round(_blob_bytes(folder) * heavy),
        unknown=unknown if summary.measured else (),
    )


def _seconds(
    experiment: Experiment, summary: GridSummary, chosen: Sequence[Cell]
) -> tuple[float, tuple[str, ...]]:
    """Return what cells are expected to take, and the kinds of them that nothing foretells."""
    kinds = Counter(cell.get(experiment.cost_axis, "") for cell in chosen)
    unknown = tuple(kind for kind in kinds if not summary.costs[kind][1])
    known = {kind: summary.costs[kind] for kind in kinds if kind not in unknown}
    return sum(kinds[kind] * seconds / rows for kind, (seconds, rows) in known.items()), unknown


def in_words(count: float) -> str:
    """Return a number of bytes with a unit.

    Parameters
    ----------
    count : float

    Examples
    --------
    >>> in_words(12_300_000)
    '12.3 MB'
    """
    for unit in _UNITS:
        if count < 1000 or unit == _UNITS[-1]:
            break
        count /= 1000
    return f"{count:.3g} {unit}"


def _row_bytes(folder: Path) -> int:
    path = folder / ROWS
    return path.stat().st_size if path.exists() else 0


def _blob_bytes(folder: Path) -> int:
    return sum(path.stat().st_size for path in blob_files(folder / BLOBS))
