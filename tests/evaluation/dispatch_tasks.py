"""Work for worker processes: what is sent there must lie in a module."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_info

from evaluation.experiment import Cell, Values
from evaluation.task_process import ONE_THREAD


@dataclass(frozen=True)
class MarkingWork:
    """Squares numbers; leaves a file with its process number for each attempt.

    Parameters
    ----------
    folder : Path
    killing : int
        The number that kills the process that squares it.
    times : int
        How often it does.
    seconds : float
        Each takes at least this long.
    hanging : int
        The number that takes a minute.
    parent_too : bool
        The process that started the killed one is killed first, as on a machine that goes down.
    """

    folder: Path
    killing: int = -1
    times: int = 0
    seconds: float = 0.0
    hanging: int = -1
    parent_too: bool = False

    def __call__(self, number: int) -> int:
        """Return the square, unless it is the one that kills."""
        (self.folder / f"{number}-{os.getpid()}-{time.monotonic_ns()}").touch()
        time.sleep(60 if number == self.hanging else self.seconds)
        if number == self.killing and self.attempts(number) <= self.times:
            if self.parent_too:
                os.kill(os.getppid(), signal.SIGKILL)
            os.kill(os.getpid(), signal.SIGKILL)
        return number * number

    def attempts(self, number: int) -> int:
        """Return how often a number was begun."""
        return len(list(self.folder.glob(f"{number}-*")))

    def processes(self) -> set[int]:
        """Return the numbers of the processes that worked."""
        return {int(path.name.split("-")[1]) for path in self.folder.iterdir()}


def hanging_cell(hanging: str, cells: Sequence[Cell]) -> Iterator[tuple[Cell, Values]]:
    """Measure the cells, but hang in one of them."""
    for cell in cells:
        time.sleep(60 if cell["number"] == hanging else 0)
        yield cell, {"value": 1.0}


def threads_here(_item: int) -> tuple[list[int], dict[str, str | None]]:
    """Return the threads of every numerical library of this process, and its environment."""
    np.linalg.inv(np.eye(2))
    return [pool["num_threads"] for pool in threadpool_info()], {
        name: os.environ.get(name) for name in ONE_THREAD
    }


def process_here(_item: int) -> int:
    """Return the number of the process."""
    return os.getpid()


def printed(item: int) -> int:
    """Print, as the code of a user might, and return the item."""
    print("words on standard output", flush=True)  # noqa: T201
    return item


def broken(_item: int) -> int:
    """Fail, as work must not."""
    raise ZeroDivisionError("work returns its faults")
