"""Which pairs a subject sees, in which order and on which sides, decided before anyone comes.

The orders of a task come in couples: the two show the same pairs in the same order, with left and
right exchanged. The couples' rows are a Latin square of the pairs, so over all orders each pair
stands at each place once with its target on the left and once on the right.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from shading_model.seeds import generator_for
from studies.side_sequences import balanced_sides
from studies.study_records import Pair, Study, Task

TrialKind = Literal["qualification", "main", "closing"]
Side = Literal["left", "right"]
Cell = tuple[str, int]
"""A task and an order of it."""

KINDS: tuple[TrialKind, ...] = ("qualification", "main", "closing")


@dataclass(frozen=True)
class ScheduledTrial:
    """One trial as it will be shown.

    Parameters
    ----------
    kind : {'qualification', 'main', 'closing'}
    pair : str
        Name of the pair.
    left, right : str
        Paths of the stimuli, as in the study.
    target_side : {'left', 'right'}
        Where the pair's target is.
    condition : str
        The task's target condition; ``qualification`` or ``closing`` for the other kinds.
    """

    kind: TrialKind
    pair: str
    left: str
    right: str
    target_side: Side
    condition: str


@dataclass(frozen=True)
class Schedule:
    """What a subject of this task and order sees, from the first trial to the last.

    Parameters
    ----------
    task : str
    order : int
        0-based number among the task's schedules.
    entries : tuple of ScheduledTrial
    """

    task: str
    order: int
    entries: tuple[ScheduledTrial, ...]


def make_schedules(
    study: Study, generator: np.random.Generator | None = None
) -> tuple[Schedule, ...]:
    """Return every schedule of a study: for each task, two for each of its pairs.

    Qualification pairs stand anywhere among the main ones, closing pairs at the end. In every
    schedule and kind, targets are as often on the left as on the right (one more or less where
    the number is odd), and never more than twice on the same side in a row.

    Parameters
    ----------
    study : Study
    generator : numpy.random.Generator, optional
        By default one of the study's seed and the task's name, so that the same study has the
        same schedules everywhere, whatever tasks are beside it.

    Returns
    -------
    tuple of Schedule
        Tasks as in the study, orders ascending.

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> schedules = make_schedules(bare_study(pairs=10, tasks=2))
    >>> len(schedules), len(schedules[0].entries)
    (40, 16)
    >>> first, second = (one.entries[0] for one in schedules[:2])
    >>> first.pair == second.pair, first.left == second.right
    (True, True)
    """
    return tuple(
        schedule
        for task in study.tasks
        for schedule in _task_schedules(
            study, task, generator or generator_for("schedules", study.seed, task.name)
        )
    )


def least_filled(
    study: Study, completed: Mapping[Cell, int], started: Mapping[Cell, int] | None = None
) -> Cell:
    """Return the task, and the order of it, that the next subject should do.

    It is the task with the fewest completed sessions, and in it the order with the fewest. Equals
    are told apart by how many are at it now, then by their place in the study, so that many who
    come at once are spread evenly and the two orders of a couple are filled one after the other.

    Parameters
    ----------
    study : Study
    completed : mapping of (str, int) to int
        Completed sessions of a task and order; none where it is not named.
    started : mapping of (str, int) to int, optional
        Sessions that are under way; those given up should be left out.

    Returns
    -------
    tuple of str and int

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> study = bare_study(pairs=2, tasks=2)
    >>> least_filled(study, {("task-1", 0): 1, ("task-2", 0): 1, ("task-2", 1): 1})
    ('task-1', 1)
    >>> least_filled(study, {}, started={("task-1", 0): 1})
    ('task-2', 0)
    """
    under_way = started or {}

    def filled(cells: list[Cell]) -> tuple[int, int]:
        return (
            sum(completed.get(cell, 0) for cell in cells),
            sum(under_way.get(cell, 0) for cell in cells),
        )

    task = min((cells_of(task) for task in study.tasks), key=filled)
    return min(task, key=lambda cell: filled([cell]))


def cells_of(task: Task) -> list[Cell]:
    """Return every order of a task, beside the task's name.

    Parameters
    ----------
    task : Task

    Returns
    -------
    list of tuple of str and int

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> cells_of(bare_study(pairs=1).tasks[0])
    [('task-1', 0), ('task-1', 1)]
    """
    return [(task.name, order) for order in range(2 * len(task.pairs))]


def _task_schedules(study: Study, task: Task, generator: np.random.Generator) -> list[Schedule]:
    shown = study.settings.pairs_per_subject or len(task.pairs)
    rows = latin_square(len(task.pairs), generator)[:, :shown]
    schedules: list[Schedule] = []
    for row in rows:
        trials = _mixed(study, [task.pairs[index] for index in row], generator)
        sides = balanced_sides([KINDS.index(kind) for kind, _ in trials], generator)
        for left in (sides, ~sides):
            entries = tuple(
                _trial(kind, pair, bool(is_left), task)
                for (kind, pair), is_left in zip(trials, left, strict=True)
            )
            schedules.append(Schedule(task.name, len(schedules), entries))
    return schedules


def _mixed(
    study: Study, main: list[Pair], generator: np.random.Generator
) -> list[tuple[TrialKind, Pair]]:
    """Return a subject's trials: qualification pairs among the main ones, closing pairs last."""
    waiting = iter(main)
    qualification = iter(generator.permutation(len(study.qualification)))
    is_main = generator.permutation([True] * len(main) + [False] * len(study.qualification))
    trials: list[tuple[TrialKind, Pair]] = [
        ("main", next(waiting))
        if one
        else ("qualification", study.qualification[next(qualification)])
        for one in is_main
    ]
    last = generator.permutation(len(study.closing))
    return trials + [("closing", study.closing[index]) for index in last]


def _trial(kind: TrialKind, pair: Pair, is_left: bool, task: Task) -> ScheduledTrial:
    left, right = (pair.target, pair.other) if is_left else (pair.other, pair.target)
    condition = task.target if kind == "main" else kind
    return ScheduledTrial(kind, pair.name, left, right, "left" if is_left else "right", condition)


def latin_square(count: int, generator: np.random.Generator) -> npt.NDArray[np.int64]:
    """Return permutations of 0..count-1 in which each number stands at each place once.

    Rows are those of Williams (1949): where the count is even, each number also follows each
    other number once, so that what a picture does to the next one averages out.

    Parameters
    ----------
    count : int
    generator : numpy.random.Generator

    Returns
    -------
    ndarray of int, shape (count, count)

    Examples
    --------
    >>> latin_square(4, np.random.default_rng(0)).sum(axis=0)
    array([6, 6, 6, 6])
    """
    steps = np.arange(count)
    zigzag = np.where(steps % 2 == 0, steps // 2, count - (steps + 1) // 2)
    square = (zigzag[None, :] + generator.permutation(count)[:, None]) % count
    return generator.permutation(count)[square]
