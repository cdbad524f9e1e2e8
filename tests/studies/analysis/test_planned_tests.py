"""Planned tests: which are made, how they are corrected and worded."""

from __future__ import annotations

import numpy as np
import pandas as pd

from studies.analysis.arms import with_arms
from studies.analysis.equivalence import holm
from studies.analysis.planned_tests import TEST_COLUMNS, planned_tests
from studies.analysis.subpopulations import main_trials, subpopulations
from studies.study_records import AnalysisPlan
from studies.tables import StudyData
from tests.studies.analysis.made_answers import FAMILIES, OTHERS, made_answers

PLAN = AnalysisPlan()


def planned_of(data: StudyData) -> pd.DataFrame:
    """Return the planned tests of some answers."""
    trials = with_arms(main_trials(data), FAMILIES, OTHERS)
    groups = subpopulations(data, ("expertise", "tests", "gender", "age"))
    return pd.DataFrame(planned_tests(trials, groups, PLAN))


def test_every_kind_is_there_and_corrected_within_its_family() -> None:
    """Holm's correction is over the tests of one kind in one family."""
    rows = planned_of(made_answers(200, np.random.default_rng(3)))
    assert set(rows.columns) == set(TEST_COLUMNS)
    kinds = {"chance", "equivalence", "difference", "interaction", "group", "side", "learning"}
    assert set(rows["kind"]) == kinds
    for _, own in rows.groupby(["family", "kind"]):
        assert holm(own["p"].to_list()) == own["p_holm"].to_list()
    assert (rows[rows["kind"] == "difference"]["family"] == "against-real").all()


def test_words_follow_the_corrected_value() -> None:
    """A strong preference is called one; nothing is called equivalent without its test."""
    rows = planned_of(made_answers(300, np.random.default_rng(1), log_odds=0.8))
    chance = rows[rows["kind"] == "chance"]
    assert (chance["result"] == "differs from chance").all()
    equivalence = rows[rows["kind"] == "equivalence"]
    assert (equivalence["result"] == "equivalence not shown").all()


def test_a_side_bias_is_found() -> None:
    """Subjects who lean to the left choose the target more often there."""
    data = made_answers(200, np.random.default_rng(1), tasks={"one": "ours"}, left=1.5)
    side = planned_of(data).query("kind == 'side'").iloc[0]
    assert side["estimate"] > 0.2
    assert side["result"] == "a side is preferred"


def test_levels_of_few_subjects_are_not_tested() -> None:
    """A gender that four subjects declared has no part in the test of genders."""
    data = made_answers(60, np.random.default_rng(4), tasks={"one": "ours"})
    gender = np.where(np.arange(60) < 4, "other", "female")
    few = StudyData(data.subjects.assign(gender=gender), data.trials)
    assert "gender" not in set(planned_of(few)["group"])


def test_one_subject_is_not_tested() -> None:
    """A family with one subject has no tests."""
    assert planned_of(made_answers(1, np.random.default_rng(0))).empty
