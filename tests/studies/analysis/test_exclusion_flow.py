"""Who is left out, in which order, and what remains."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from shading_model.errors import RelightlabError
from studies.analysis.exclusion_flow import exclusion_flow
from studies.study_records import Exclusions
from studies.tables import StudyData
from tests.studies.analysis.made_answers import made_answers

NONE = Exclusions(qualification_all_correct=False, complete_only=False)


def changed(
    data: StudyData, subject: str | None = None, trials: dict[str, Any] | None = None, **own: Any
) -> StudyData:
    """Return the data with values of one subject, or of the subject's trials, set."""
    subjects, rows = data.subjects.copy(), data.trials.copy()
    for name, value in own.items():
        subjects.loc[subjects["subject"] == subject, name] = value
    for name, value in (trials or {}).items():
        rows.loc[rows["subject"] == subject, name] = value
    return StudyData(subjects, rows)


@pytest.fixture
def data() -> StudyData:
    """Ten subjects with ten trials each."""
    return made_answers(10, np.random.default_rng(2))


def with_check(data: StudyData, subject: str, chose_target: float) -> StudyData:
    """Return the data with a qualification pair of one subject."""
    check = {"subject": subject, "task": "t", "kind": "qualification", "trial": 99}
    check |= {"pair": "cartoon", "condition": "real", "chose_target": chose_target}
    return StudyData(data.subjects, pd.concat([data.trials, pd.DataFrame([check])]))


def test_nobody_is_left_out_without_rules(data: StudyData) -> None:
    """Without rules everything stays and no step is told."""
    flow = exclusion_flow(data, NONE)
    assert flow.steps == flow.excluded == ()
    assert flow.started == {"subjects": 10, "trials": 100}
    assert len(flow.kept.trials) == 100


def test_one_wrong_cartoon_is_enough(data: StudyData) -> None:
    """Who chose a cartoon once is left out, with all trials; who did not stays."""
    flow = exclusion_flow(with_check(with_check(data, "s0001", 1.0), "s0002", 0.0))
    assert [dict(row) for row in flow.excluded] == [
        {"subject": "s0002", "reason": "chose a cartoon as real"}
    ]
    assert flow.steps[-1] == {
        "reason": "chose a cartoon as real",
        "subjects": 1,
        "trials": 10,
        "remaining_subjects": 9,
        "remaining_trials": 90,
    }
    assert "s0002" not in set(flow.kept.subjects["subject"])


def test_a_subject_is_left_out_once(data: StudyData) -> None:
    """Who breaks several rules is counted at the first."""
    broken = changed(with_check(data, "s0002", 0.0), "s0002", status="started")
    flow = exclusion_flow(broken)
    assert [step["subjects"] for step in flow.steps] == [1, 0]
    assert [row["reason"] for row in flow.excluded] == ["did not finish"]


@pytest.mark.parametrize(
    ("rules", "values", "reason"),
    [
        ({"minimum_median_ms": 300.0}, {"reaction_ms": 250.0}, "median reaction time below 300 ms"),
        ({"maximum_same_side": 0.9}, {"response": "left"}, "more than 90 % of answers on one side"),
        ({"maximum_blur_events": 20}, {"blur_events": 3}, "left the window more than 20 times"),
    ],
)
def test_every_rule(
    data: StudyData, rules: dict[str, Any], values: dict[str, Any], reason: str
) -> None:
    """Too fast, always one side, away too often: each rule finds the one who breaks it."""
    if "response" in values:
        values = {**values, "target_side": "left", "chose_target": 1.0}
    flow = exclusion_flow(changed(data, "s0004", values), replace(NONE, **rules))
    assert [dict(row) for row in flow.excluded] == [{"subject": "s0004", "reason": reason}]


def test_what_is_not_known_breaks_no_rule(data: StudyData) -> None:
    """Answers without times, sides or counts stay."""
    rules = replace(NONE, minimum_median_ms=1e9, maximum_blur_events=0, maximum_same_side=0.1)
    unknown = data.trials.drop(columns=["reaction_ms", "blur_events", "response", "target_side"])
    assert exclusion_flow(StudyData(data.subjects, unknown), rules).excluded == ()


def test_pilots_do_not_count_beside_others(data: StudyData) -> None:
    """A pilot session among live ones is left out; a pilot alone is analysed."""
    flow = exclusion_flow(changed(data, "s0003", mode="pilot"), NONE)
    assert flow.excluded[0]["reason"] == "pilot session"
    pilots = StudyData(data.subjects.assign(mode="pilot"), data.trials)
    assert exclusion_flow(pilots, NONE).excluded == ()


def test_nobody_left_is_said(data: StudyData) -> None:
    """If the rules leave nobody the sentence says how many there were."""
    started = StudyData(data.subjects.assign(status="started"), data.trials)
    with pytest.raises(RelightlabError, match="no answers are left of 100 by 10 subjects"):
        exclusion_flow(started)
