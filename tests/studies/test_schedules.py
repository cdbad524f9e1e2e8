"""Schedules balance for any number of pairs, and sessions fill them evenly."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from studies.bare_study import bare_study
from studies.schedules import (
    Schedule,
    cells_of,
    latin_square,
    least_filled,
    make_schedules,
)
from studies.side_sequences import longest_run
from studies.study_records import Study


@st.composite
def studies(draw: st.DrawFn) -> Study:
    """Draw a study of any size."""
    pairs = draw(st.integers(1, 13))
    return bare_study(
        pairs,
        tasks=draw(st.integers(1, 2)),
        qualification=draw(st.integers(0, 5)),
        closing=draw(st.booleans()),
        pairs_per_subject=draw(st.none() | st.integers(1, pairs)),
    )


@settings(deadline=None)
@given(studies(), st.integers(0, 2**32))
def test_schedules_of_any_study_balance(study: Study, seed: int) -> None:
    """Each pair is as often left as right, at every place, and no side comes thrice in a row."""
    schedules = make_schedules(study, np.random.default_rng(seed))
    shown = study.settings.pairs_per_subject or len(study.tasks[0].pairs)
    for task in study.tasks:
        own = [one for one in schedules if one.task == task.name]
        assert [one.order for one in own] == list(range(2 * len(task.pairs)))
        assert_sides_balance(own)
        assert_places_balance(own, len(task.pairs), shown)
    for schedule in schedules:
        assert_one_schedule(study, schedule, shown)


def assert_sides_balance(schedules: list[Schedule]) -> None:
    """Assert that each pair's target is as often on the left as on the right."""
    sides = Counter(
        (entry.kind, entry.pair, entry.target_side) for one in schedules for entry in one.entries
    )
    for kind, pair, _ in list(sides):
        assert sides[kind, pair, "left"] == sides[kind, pair, "right"]


def assert_places_balance(schedules: list[Schedule], pairs: int, shown: int) -> None:
    """Assert that each pair stands at each place of the main trials once on either side."""
    places = Counter(
        (entry.pair, place, entry.target_side)
        for one in schedules
        for place, entry in enumerate(e for e in one.entries if e.kind == "main")
    )
    assert len(places) == pairs * shown * 2
    assert set(places.values()) == {1}


def assert_one_schedule(study: Study, schedule: Schedule, shown: int) -> None:
    """Assert that a subject sees what they should, with sides that cannot be guessed."""
    task = study.task(schedule.task)
    entries = schedule.entries
    assert longest_run([entry.target_side for entry in entries]) <= 2
    kinds = Counter(entry.kind for entry in entries)
    assert kinds["main"] == shown
    assert kinds["qualification"] == len(study.qualification)
    assert kinds["closing"] == len(study.closing)
    assert [entry.kind for entry in entries[len(entries) - len(study.closing) :]] == (
        ["closing"] * len(study.closing)
    )
    assert len({(entry.kind, entry.pair) for entry in entries}) == len(entries)
    for kind, count in kinds.items():
        left = sum(entry.target_side == "left" for entry in entries if entry.kind == kind)
        assert abs(2 * left - count) <= 1
    pairs = {("main", one.name): one for one in task.pairs}
    pairs |= {("qualification", one.name): one for one in study.qualification}
    pairs |= {("closing", one.name): one for one in study.closing}
    for entry in entries:
        pair = pairs[entry.kind, entry.pair]
        first, last = (pair.target, pair.other)[:: 1 if entry.target_side == "left" else -1]
        assert (entry.left, entry.right) == (first, last)
        assert entry.condition == (task.target if entry.kind == "main" else entry.kind)


@settings(deadline=None)
@given(st.integers(1, 40), st.integers(0, 2**32))
def test_latin_squares_of_any_size(count: int, seed: int) -> None:
    """Every row and every column holds each number once."""
    square = latin_square(count, np.random.default_rng(seed))
    expected = np.arange(count)
    assert (np.sort(square, axis=0) == expected[:, None]).all()
    assert (np.sort(square, axis=1) == expected).all()


@pytest.mark.parametrize("count", [2, 4, 10])
def test_each_pair_follows_each_other_once(count: int) -> None:
    """With an even number of pairs, what comes before a pair is balanced, too."""
    square = latin_square(count, np.random.default_rng(3))
    steps = Counter((a, b) for row in square for a, b in pairwise(row.tolist()))
    assert set(steps.values()) == {1}
    assert len(steps) == count * (count - 1)


def test_the_same_study_has_the_same_schedules() -> None:
    """Schedules come from the seed and the task's name, whatever tasks stand beside it."""
    one, two = make_schedules(bare_study(tasks=1)), make_schedules(bare_study(tasks=2))
    assert make_schedules(bare_study(tasks=1)) == one
    assert two[: len(one)] == one


@settings(deadline=None)
@given(studies(), st.integers(0, 200), st.integers(0, 2**32))
def test_sessions_fill_tasks_and_orders_evenly(study: Study, count: int, seed: int) -> None:
    """Among completed sessions, tasks differ by one at most and so do the orders of a task.

    Sessions that are given up do not count, however many they are.
    """
    generator = np.random.default_rng(seed)
    completed: Counter[tuple[str, int]] = Counter()
    for _ in range(count):
        cell = least_filled(study, completed)
        assert completed[cell] == min(completed[other] for other in cells_of(study.task(cell[0])))
        if generator.random() < 0.7:
            completed[cell] += 1
    by_task = [[completed[cell] for cell in cells_of(task)] for task in study.tasks]
    assert max(map(sum, by_task)) - min(map(sum, by_task)) <= 1
    assert all(max(own) - min(own) <= 1 for own in by_task)


@settings(deadline=None)
@given(studies(), st.integers(1, 150))
def test_who_come_at_once_are_spread(study: Study, count: int) -> None:
    """Before anyone has finished, those under way keep tasks and orders even."""
    started: Counter[tuple[str, int]] = Counter()
    for _ in range(count):
        started[least_filled(study, {}, started)] += 1
    by_task = [[started[cell] for cell in cells_of(task)] for task in study.tasks]
    assert max(map(sum, by_task)) - min(map(sum, by_task)) <= 1
    assert all(max(own) - min(own) <= 1 for own in by_task)


def test_couples_are_filled_one_after_the_other() -> None:
    """After any even number of sessions of a task, sides are exactly balanced."""
    study = bare_study(pairs=5)
    completed: Counter[tuple[str, int]] = Counter()
    for _ in range(6):
        completed[least_filled(study, completed)] += 1
    assert sorted(order for _, order in completed) == [0, 1, 2, 3, 4, 5]


def test_completed_sessions_come_before_those_under_way() -> None:
    """A task that fewer have finished is next, though many have started it."""
    study = bare_study(pairs=1, tasks=2)
    started = {("task-1", 0): 9, ("task-1", 1): 9}
    assert least_filled(study, {("task-2", 0): 1}, started)[0] == "task-1"
