"""What a store holds of an experiment: which cells are done, failed, or still to run.

Rows count for an experiment only if their input hash is its own. `grid_status` keeps the rows, for
a table; `grid_summary` counts them with one byte for each cell, however many rows there are.
"""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import asdict, dataclass
from typing import Any

from evaluation.experiment import CellKey, Experiment
from evaluation.row_lines import DamagedLine
from evaluation.row_store import Rows
from evaluation.stored_cells import cell_place, last_line, own_rows

DONE, FAILED, SKIPPED = "done", "failed", "skipped"
STATES = {DONE: 1, SKIPPED: 2, FAILED: 3}
CLOSED = (STATES[DONE], STATES[SKIPPED])
"""States of cells that no run measures again unless it is told to."""
SHOWN_LINES, SHOWN_REASONS = 5, 20


@dataclass(frozen=True, eq=False)
class GridStatus:
    """What a store holds of an experiment.

    Parameters
    ----------
    rows : dict of rows
        The last good row of each cell measured with the experiment's own inputs, by cell key.
    missing : tuple of CellKey
        Cells with no row, or whose last row failed, in grid order.
    stale : int
        Rows of this experiment that other inputs (data, parameters, code) gave; left out.
    damaged : tuple of DamagedLine
        Lines that cannot be read; their cells count as missing.
    """

    rows: dict[CellKey, dict[str, Any]]
    missing: tuple[CellKey, ...]
    stale: int
    damaged: tuple[DamagedLine, ...]

    @property
    def failed(self) -> list[dict[str, Any]]:
        """Rows of failed cells."""
        return [row for row in self.rows.values() if row["status"] == FAILED]

    @property
    def complete(self) -> bool:
        """Whether every cell is done or skipped."""
        return not self.missing

    def sentence(self) -> str:
        """Return "N done, M to run" and what else a user has to know."""
        failed = len(self.failed)
        lines = [line.number for line in self.damaged]
        return _sentence(len(self.rows) - failed, len(self.missing), failed, self.stale, lines)


def grid_status(experiment: Experiment, store: Rows) -> GridStatus:
    """Return what a store holds of an experiment.

    Parameters
    ----------
    experiment : Experiment
    store : Rows

    Returns
    -------
    GridStatus

    Raises
    ------
    RelightlabError
        If the store holds rows of another version of the experiment's protocol.
    """
    latest: dict[CellKey, dict[str, Any]] = {}
    damaged: list[DamagedLine] = []
    stale = 0
    for row, own in own_rows(experiment, store):
        if isinstance(row, DamagedLine):
            damaged.append(row)
        elif own:
            latest[experiment.key(row["cell"])] = row
        else:
            stale += 1
    missing = tuple(
        key
        for key in map(experiment.key, experiment.cells())
        if key not in latest or latest[key]["status"] == FAILED
    )
    return GridStatus(latest, missing, stale, tuple(damaged))


@dataclass(frozen=True)
class GridSummary:
    """What a store holds of an experiment, in numbers.

    Parameters
    ----------
    protocol : str
    cells, done, skipped, failed, missing : int
        Cells in all; done; skipped; failed; not measured.
    stale : int
        Rows of this experiment that other inputs (data, parameters, code) gave; left out.
    damaged : tuple of int
        Numbers of the lines that cannot be read.
    reasons : dict of int
        Why cells failed, the last line of each reason, with its number of cells; the commonest.
    seconds : float
        Work of all measured rows, stale ones too.
    measured : int
        The rows that `seconds` counts.
    costs : dict of (float, int)
        Both by value of the experiment's cost axis; by the empty word where it has none.
    """

    protocol: str
    cells: int
    done: int
    skipped: int
    failed: int
    missing: int
    stale: int
    damaged: tuple[int, ...]
    reasons: dict[str, int]
    seconds: float
    measured: int
    costs: dict[str, tuple[float, int]]

    @property
    def to_run(self) -> int:
        """Cells that the next run measures."""
        return self.failed + self.missing

    def sentence(self) -> str:
        """Return "N done, M to run" and what else a user has to know."""
        counts = self.done + self.skipped, self.to_run, self.failed, self.stale
        return _sentence(*counts, list(self.damaged))

    def document(self) -> dict[str, Any]:
        """Return the summary as plain JSON values."""
        return {**asdict(self), "to_run": self.to_run, "damaged": list(self.damaged)}


def grid_summary(experiment: Experiment, store: Rows) -> GridSummary:
    """Count what a store holds of an experiment.

    Parameters
    ----------
    experiment : Experiment
    store : Rows

    Returns
    -------
    GridSummary

    Raises
    ------
    RelightlabError
        If the store holds rows of another version of the experiment's protocol.
    """
    return cell_states(experiment, store)[1]


def cell_states(experiment: Experiment, store: Rows) -> tuple[bytearray, GridSummary]:
    """Return the state of every cell, one byte each, and their counts; rows are not kept.

    Parameters
    ----------
    experiment : Experiment
    store : Rows

    Returns
    -------
    bytearray
        By `cell_place`: 0 for a cell without a row, else that of its last row in `STATES`.
    GridSummary

    Raises
    ------
    RelightlabError
        If the store holds rows of another version of the experiment's protocol.
    """
    states = bytearray(experiment.size)
    reasons: dict[int, str] = {}
    damaged: list[int] = []
    axis = experiment.cost_axis
    stale, costs = 0, dict.fromkeys(experiment.axes.get(axis, ("",)), (0.0, 0))
    place = cell_place(experiment)
    for row, own in own_rows(experiment, store):
        if isinstance(row, DamagedLine):
            damaged.append(row.number)
            continue
        value = row["cell"].get(axis, "")
        if row["status"] == DONE and value in costs:
            costs[value] = (costs[value][0] + row["seconds"], costs[value][1] + 1)
        if not own:
            stale += 1
            continue
        number = place(row["cell"])
        states[number] = STATES[row["status"]]
        if row["status"] == FAILED:
            reasons[number] = sys.intern(last_line(row["reason"]))
    left = Counter(why for cell, why in reasons.items() if states[cell] == STATES[FAILED])
    summary = GridSummary(
        protocol=experiment.protocol,
        cells=experiment.size,
        done=states.count(STATES[DONE]),
        skipped=states.count(STATES[SKIPPED]),
        failed=states.count(STATES[FAILED]),
        missing=states.count(0),
        stale=stale,
        damaged=tuple(damaged),
        reasons=dict(left.most_common(SHOWN_REASONS)),
        seconds=round(sum(seconds for seconds, _ in costs.values()), 3),
        measured=sum(rows for _, rows in costs.values()),
        costs={value: (round(seconds, 3), rows) for value, (seconds, rows) in costs.items()},
    )
    return states, summary


def _sentence(done: int, to_run: int, failed: int, stale: int, damaged: list[int]) -> str:
    words = [f"{done} done, {to_run} to run"]
    if failed:
        words.append(f"{failed} of them failed before")
    if stale:
        words.append(f"{stale} rows of other data, parameters or code are left out")
    if damaged:
        lines = ", ".join(map(str, damaged[:SHOWN_LINES]))
        words.append(f"{len(damaged)} damaged lines (line {lines}) are measured again")
    return "; ".join(words)
