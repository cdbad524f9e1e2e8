"""Tests of the four tidy tables of a study."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings

from shading_model.errors import RelightlabError
from studies.tables import TABLES, StudyData, closing_results, combined, score
from tests.studies.study_answers import answers, any_answers, assert_same, subject_row, trial_row


def test_columns_are_complete_ordered_and_typed() -> None:
    """Columns left out come back missing, all in the written order and of their written types."""
    data = answers()
    for name, columns in TABLES.items():
        table = data.table(name)
        assert list(table) == [column.name for column in columns]
        assert [str(kind) for kind in table.dtypes] == [column.dtype for column in columns]


@settings(max_examples=12)
@given(any_answers())
def test_parts_combine_to_the_whole(data: StudyData) -> None:
    """The answers of each subject, combined, are the answers of all, subject by subject."""
    parts = [data.of_subjects([name]) for name in data.subjects["subject"]]
    assert_same(combined(parts), data if parts else combined([]))


def test_frames_given_are_not_changed() -> None:
    """The frames that answers are made of stay as they were."""
    subjects = pd.DataFrame([subject_row(age=31)])
    before = subjects.copy()
    StudyData(subjects, pd.DataFrame())
    pd.testing.assert_frame_equal(subjects, before)


@pytest.mark.parametrize(
    ("mode", "marks"),
    [("live", ()), ("imported", ()), ("pilot", ("pilot",)), ("simulated", ("simulated",))],
)
def test_marks_follow_the_mode(mode: str, marks: tuple[str, ...]) -> None:
    """Simulated and pilot answers are marked, others are not."""
    assert answers(mode=mode).marks == marks
    assert answers(mode=mode).simulated is (mode == "simulated")


def test_one_simulated_subject_marks_all() -> None:
    """A single made-up subject among others marks the whole."""
    made_up = StudyData(pd.DataFrame([subject_row("s2", mode="simulated")]), pd.DataFrame())
    assert combined([answers(), made_up]).marks == ("simulated",)
    assert combined([answers(), made_up.of_subjects([])]).marks == ()


def test_an_empty_text_is_missing() -> None:
    """An empty gender is no gender, and an empty name of a subject is a fault."""
    assert answers(gender="").subjects["gender"].isna().all()
    with pytest.raises(RelightlabError, match=r"'subject' of the subjects holds nothing in row 0"):
        StudyData(pd.DataFrame([subject_row("")]), pd.DataFrame())


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"mode": "lve"}, "holds 'lve' in row 0: expected live, pilot, simulated or imported"),
        ({"task": None}, "the column 'task' of the subjects holds nothing in row 0: expected text"),
        ({"subject": 1.5}, "holds 1.5 in row 0: expected text"),
        ({"age": "old"}, "holds 'old' in row 0: expected numbers"),
        ({"age": float("inf")}, "holds inf in row 0: expected numbers"),
        ({"age": 10**400}, "expected numbers"),
        ({"order": 0.5}, "holds 0.5 in row 0: expected whole numbers"),
        ({"order": True}, "holds True in row 0: expected whole numbers"),
        ({"expertise": "maybe"}, "holds 'maybe' in row 0: expected true or false"),
        ({"expertise": 2}, "holds 2 in row 0: expected true or false"),
        ({"started": "yesterday"}, "holds 'yesterday' in row 0: expected times in ISO 8601"),
        ({"gender": "a\0b"}, r"holds 'a\x00b' in row 0: expected text"),
        ({"gender": "\ud800"}, r"holds '\ud800' in row 0: expected text"),
        ({"agee": 3}, "Unknown column of the subjects 'agee'. Did you mean 'age'?"),
    ],
)
def test_wrong_subjects_are_told(wrong: dict[str, Any], sentence: str) -> None:
    """Each wrong value of a subject is one sentence: where, what, and what was expected."""
    with pytest.raises(RelightlabError) as told:
        StudyData(pd.DataFrame([subject_row() | wrong], dtype=object), pd.DataFrame())
    assert sentence in str(told.value)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        ([trial_row(), trial_row()], "the trials hold subject 's1', trial 0 twice"),
        ([trial_row("s9")], "the trials name the subject 's9', who is not among the subjects"),
        ([trial_row(chose_target=0.0)], "the trials hold chose_target 0 in row 0"),
        ([trial_row(response="tie")], "0.5 for a tie"),
        ([trial_row(response=None, chose_target=0.25)], "the trials hold chose_target 0.25"),
        ([{"subject": "s1", "trial": 0}], "the trials lack the columns task, kind"),
    ],
)
def test_wrong_trials_are_told(rows: list[dict[str, Any]], sentence: str) -> None:
    """Trials that come twice, of nobody or against their sides are told in one sentence."""
    with pytest.raises(RelightlabError) as told:
        StudyData(pd.DataFrame([subject_row()]), pd.DataFrame(rows))
    assert sentence in str(told.value)


def test_a_column_given_twice_is_told() -> None:
    """Two columns of one name are a fault, not a choice."""
    frame = pd.DataFrame([[1, 2]], columns=["age", "age"])
    with pytest.raises(RelightlabError, match="have the column 'age' twice: keep one"):
        StudyData(frame, pd.DataFrame())


def test_parts_must_not_share_a_subject() -> None:
    """A subject in two parts is a fault."""
    with pytest.raises(RelightlabError, match="the subjects hold subject 's1' twice"):
        combined([answers(), answers()])


def test_score_is_one_for_the_target() -> None:
    """Target 1, other 0, tie 0.5, and nothing where a side is not known."""
    sides = ["left", "right", None]
    pairs = [(response, side) for response in [*sides, "tie"] for side in sides]
    got = score(*(pd.Series(column) for column in zip(*pairs, strict=True)))
    nan = np.nan
    np.testing.assert_array_equal(got, [1, 0, nan, 0, 1, nan, nan, nan, nan, 0.5, 0.5, 0.5])


def test_closing_results_are_of_closing_pairs_alone() -> None:
    """A subject passes by the plausible picture; a pair of another name says nothing."""
    closing = {"kind": "closing", "condition": "closing"}
    rows = [
        trial_row("a", 0, pair="spheres", **closing),
        trial_row("a", 1, pair="perspective", response="right", chose_target=0.0, **closing),
        trial_row("b", 0, pair="spheres"),
        trial_row("b", 1, pair="other", **closing),
    ]
    got = closing_results(pd.DataFrame(rows))
    assert got.to_dict("records") == [
        {"subject": "a", "passed_spheres": True, "passed_perspective": False}
    ]
