"""How evenly schedules show their pairs: on which side, and in which half."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple, fields

import numpy as np
import pandas as pd

from studies.schedules import Cell, Schedule, ScheduledTrial
from studies.side_sequences import longest_run
from studies.study_records import Study

ITEM = ("task", "kind", "pair")
COUNTS = ("shown", "left", "right", "first_half", "second_half")


def schedule_table(schedules: Sequence[Schedule]) -> pd.DataFrame:
    """Return every trial of every schedule as a row.

    Parameters
    ----------
    schedules : sequence of Schedule

    Returns
    -------
    DataFrame
        Columns ``task, order, trial, kind, position, pair, left, right, target_side, condition``;
        `trial` is the 0-based place in the schedule, `position` the 1-based one in its kind.

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> from studies.schedules import make_schedules
    >>> schedule_table(make_schedules(bare_study(pairs=2, qualification=0))).shape
    (16, 10)
    """
    rows = [
        (one.task, one.order, trial, *astuple(entry))
        for one in schedules
        for trial, entry in enumerate(one.entries)
    ]
    entry_columns = [field.name for field in fields(ScheduledTrial)]
    table = pd.DataFrame(rows, columns=["task", "order", "trial", *entry_columns])
    position = table.groupby(["task", "order", "kind"]).cumcount() + 1
    table.insert(4, "position", position)
    return table


def balance_table(
    study: Study, schedules: Sequence[Schedule], sessions: Mapping[Cell, int] | None = None
) -> pd.DataFrame:
    """Return for each pair how often it is shown, on which side and in which half.

    Parameters
    ----------
    study : Study
    schedules : sequence of Schedule
        Those of the study.
    sessions : mapping of (str, int) to int, optional
        How often each task and order has been done; by default once each.

    Returns
    -------
    DataFrame
        A row for each task, kind and pair, in the order of the study: `shown` times in all,
        target on the `left` and the `right`, and among the first and second half of the trials
        of its kind (the middle one of an odd number counts to the second).

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> from studies.schedules import make_schedules
    >>> study = bare_study(pairs=4, qualification=0, closing=False)
    >>> balance_table(study, make_schedules(study)).loc[0, "shown":].to_list()
    [8, 4, 4, 4, 4]
    >>> balance_table(study, make_schedules(study), {("task-1", 0): 3})["shown"].to_list()
    [3, 3, 3, 3]
    """
    table = schedule_table(schedules)
    cells = zip(table["task"], table["order"], strict=True)
    times = np.array([1 if sessions is None else sessions.get(cell, 0) for cell in cells])
    is_left = table["target_side"] == "left"
    trials = table.groupby(["task", "order", "kind"])["pair"].transform("size")
    is_early = 2 * table["position"] <= trials
    table["shown"] = times
    table["left"], table["right"] = times * is_left, times * ~is_left
    table["first_half"], table["second_half"] = times * is_early, times * ~is_early
    counts = table.groupby(["task", "kind", "pair"])[list(COUNTS)].sum()
    return counts.reindex(pd.MultiIndex.from_tuples(_items(study), names=ITEM)).reset_index()


def _items(study: Study) -> list[tuple[str, str, str]]:
    """Return the task, kind and name of every pair, in the order of the study."""
    return [
        (task.name, kind, pair.name)
        for task in study.tasks
        for kind, pairs in (
            ("qualification", study.qualification),
            ("main", task.pairs),
            ("closing", study.closing),
        )
        for pair in pairs
    ]


def balance_summary(study: Study, schedules: Sequence[Schedule]) -> pd.DataFrame:
    """Return for each task what its schedules have in common.

    Parameters
    ----------
    study : Study
    schedules : sequence of Schedule
        Those of the study.

    Returns
    -------
    DataFrame
        Columns ``task, orders, trials, most_in_a_row, largest_difference``: the number of
        schedules, trials in each, the longest run of targets on one side, and the largest
        difference between left and right over all pairs.

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> from studies.schedules import make_schedules
    >>> study = bare_study()
    >>> print(balance_summary(study, make_schedules(study)).to_csv(index=False))
    task,orders,trials,most_in_a_row,largest_difference
    task-1,20,16,2,0
    """
    balance = balance_table(study, schedules)
    differences = (balance["left"] - balance["right"]).abs().groupby(balance["task"]).max()
    rows = []
    for task in study.tasks:
        entries = [one.entries for one in schedules if one.task == task.name]
        run = max(longest_run([trial.target_side for trial in one]) for one in entries)
        rows.append((task.name, len(entries), len(entries[0]), run, int(differences[task.name])))
    columns = ["task", "orders", "trials", "most_in_a_row", "largest_difference"]
    return pd.DataFrame(rows, columns=columns)
