"""The balance table: counted by hand, weighted by sessions, and even in the middle."""

from __future__ import annotations

import pandas as pd

from studies.balance import balance_summary, balance_table, schedule_table
from studies.bare_study import bare_study
from studies.schedules import Schedule, ScheduledTrial, make_schedules


def test_positions_count_within_a_kind() -> None:
    """A main trial's position does not count the qualification trials before it."""
    study = bare_study(pairs=3, tasks=2)
    table = schedule_table(make_schedules(study))
    for _, own in table.groupby(["task", "order"]):
        assert own["trial"].to_list() == list(range(3 + 4 + 2))
        for kind, count in (("qualification", 4), ("main", 3), ("closing", 2)):
            of_kind = own.loc[own["kind"] == kind, "position"]
            assert of_kind.to_list() == list(range(1, count + 1))


def test_a_table_of_two_trials_is_counted_by_hand() -> None:
    """Two trials, one on each side, one in each half."""
    study = bare_study(pairs=2, qualification=0, closing=False)
    entries = tuple(
        ScheduledTrial("main", pair, "a", "b", side, "ours")
        for pair, side in (("pair-2", "left"), ("pair-1", "right"))
    )
    table = balance_table(study, [Schedule("task-1", 0, entries)], {("task-1", 0): 5})
    assert table.to_numpy().tolist() == [
        ["task-1", "main", "pair-1", 5, 0, 5, 0, 5],
        ["task-1", "main", "pair-2", 5, 5, 0, 5, 0],
    ]


def test_the_table_of_a_study_is_even() -> None:
    """Over all schedules each pair is as often left as right, and main pairs in each half."""
    study = bare_study(pairs=10, tasks=2)
    table = balance_table(study, make_schedules(study))
    assert table["pair"].to_list()[:5] == ["pair-1", "pair-2", "pair-3", "pair-4", "pair-1"]
    assert (table["left"] == table["right"]).all()
    assert (table["shown"] == 20).all()
    main = table[table["kind"] == "main"]
    pd.testing.assert_series_equal(main["first_half"], main["second_half"], check_names=False)


def test_the_summary_finds_what_is_uneven() -> None:
    """A run of three and a pair on one side only are told."""
    study = bare_study(pairs=3, qualification=0, closing=False)
    entries = tuple(
        ScheduledTrial("main", f"pair-{number}", "a", "b", "left", "ours") for number in (1, 2, 3)
    )
    summary = balance_summary(study, [Schedule("task-1", 0, entries)])
    assert summary.iloc[0].to_list() == ["task-1", 1, 3, 3, 1]
