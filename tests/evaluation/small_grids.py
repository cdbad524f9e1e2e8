"""Experiments of a few cells that cost nothing, and go wrong as they are told."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from evaluation.experiment import Cell, Experiment, Values
from evaluation.grid_run import SkippedError, row_origin

OBJECTS = ("apple", "bear", "cup", "drum")
LIGHTS = ("00", "01", "02")


@dataclass(frozen=True)
class Fault:
    """What goes wrong with one object, and how long every task takes."""

    kind: str = ""
    object: str = "bear"
    seconds: float = 0.0


def measure(fault: Fault, cells: Sequence[Cell]) -> Iterator[tuple[Cell, Values]]:
    """Yield numbers that only the cell decides, unless it is to fail."""
    time.sleep(fault.seconds)
    for cell in cells:
        number = float(sum(cell["object"].encode()) + int(cell["light"]))
        if fault.kind and cell["object"] == fault.object:
            number = _go_wrong(fault.kind, number)
        yield cell, {"sum": number, "half": number / 2}


def _go_wrong(kind: str, number: float) -> float:
    if kind == "raises":
        raise ZeroDivisionError("no light at all")
    if kind == "cannot be":
        raise SkippedError("there is no such light")
    if kind == "hangs":
        time.sleep(30)
    return float("nan") if kind == "gives NaN" else number


def small_experiment(fault: Fault | None = None, **changes: Any) -> Experiment:
    """Four objects under three lights, one task for each object."""
    values: dict[str, Any] = {
        "name": "small",
        "version": 1,
        "axes": {"object": OBJECTS, "light": LIGHTS},
        "together": ("light",),
        "measure": measure,
        "context": fault or Fault(),
        "inputs": {"data": "ab"},
        "seed": "",
    }
    return Experiment(**(values | changes))


def rows_of(experiment: Experiment, status: str = "done", **changes: Any) -> list[dict[str, Any]]:
    """One row for each cell, as a run would write it."""
    origin = row_origin(experiment)
    return [
        {
            **origin,
            "cell": cell,
            "values": {"sum": 1.0},
            "seconds": 0.5,
            "status": status,
            "reason": "",
            **changes,
        }
        for cell in experiment.cells()
    ]
