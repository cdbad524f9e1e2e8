"""Tests of simulated studies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.special import logit

from shading_model.errors import RelightlabError
from studies.bare_study import bare_study
from studies.observers import ObserverModel
from studies.response_store import ResponseStore
from studies.schedules import make_schedules
from studies.simulation import simulate, write_apart
from studies.study_records import Study
from studies.tables import StudyData
from tests.studies.study_answers import answers, assert_same

STUDY = bare_study(pairs=10, tasks=1)


@pytest.fixture(scope="module")
def recovered() -> StudyData:
    """600 observers alike but for a pull to the left, learning and expertise."""
    study = replace(STUDY, questionnaire=())
    model = ObserverModel(rate=0.6, subject_sd=0, item_sd=0, lapse=0, side=0.5, learning=0.08)
    return simulate(study, 600, model, seed=1)


def main_trials(data: StudyData) -> pd.DataFrame:
    """The main trials."""
    return data.trials[data.trials["kind"] == "main"]


def log_odds(taken: pd.Series) -> tuple[float, float]:
    """The log odds of a share, and their standard error by the delta method."""
    share, count = float(taken.mean()), len(taken)
    return float(logit(share)), float(1 / np.sqrt(count * share * (1 - share)))


def test_the_pull_of_a_side_is_recovered(recovered: StudyData) -> None:
    """Log odds with the target left less those with it right are the side effect."""
    taken = main_trials(recovered).groupby("target_side")["chose_target"]
    (left, left_error), (right, right_error) = (
        log_odds(taken.get_group(s)) for s in ("left", "right")
    )
    assert abs(left - right - 0.5) < 3 * np.hypot(left_error, right_error)


def test_the_rate_is_recovered(recovered: StudyData) -> None:
    """The mean of the two sides' log odds is that of the rate; learning cancels to first order."""
    taken = main_trials(recovered).groupby("target_side")["chose_target"]
    both = [log_odds(group) for _, group in taken]
    centre, error = np.mean([odds for odds, _ in both]), np.hypot(*(e for _, e in both)) / 2
    assert abs(centre - logit(0.6)) < 3 * error + 0.01


def test_learning_is_recovered(recovered: StudyData) -> None:
    """The slope of log odds over the ten positions is the learning effect."""
    taken = main_trials(recovered).groupby("position")["chose_target"]
    odds, errors = np.array([log_odds(group) for _, group in taken]).T
    place = np.arange(10) - 4.5
    slope, error = place @ odds / (place @ place), np.sqrt(place**2 @ errors**2) / (place @ place)
    assert abs(slope - 0.08) < 3 * error + 0.003


def test_every_position_and_pair_is_there_equally_often(recovered: StudyData) -> None:
    """Least-filled schedules: over whole rounds each pair is as often left as right."""
    counts = main_trials(recovered).groupby(["pair", "target_side"]).size()
    assert counts.nunique() == 1
    assert main_trials(recovered).groupby(["pair", "position"]).size().nunique() == 1


def test_simulated_answers_are_marked_and_complete(recovered: StudyData) -> None:
    """Every subject is simulated and has the whole schedule that its order says."""
    assert recovered.marks == ("simulated",)
    assert (recovered.subjects["status"] == "complete").all()
    book = {(one.task, one.order): one for one in make_schedules(STUDY)}
    subject = recovered.subjects.iloc[17]
    rows = recovered.trials[recovered.trials["subject"] == subject["subject"]]
    entries = book[subject["task"], subject["order"]].entries
    assert rows["pair"].tolist() == [entry.pair for entry in entries]
    assert rows["left"].tolist() == [entry.left for entry in entries]
    assert rows["trial"].tolist() == list(range(len(entries)))


def test_closing_pairs_tell_who_passed(recovered: StudyData) -> None:
    """The subjects' columns are what the closing trials say."""
    spheres = recovered.trials[recovered.trials["pair"] == "spheres"].set_index("subject")
    passed = recovered.subjects.set_index("subject")["passed_spheres"]
    assert (passed == (spheres["chose_target"] == 1).reindex(passed.index)).all()
    assert 0.7 < passed.mean() < 0.9


def test_more_subjects_change_no_earlier_one() -> None:
    """The first of many are the few; another seed gives others; the same seed gives the same."""
    few, many = simulate(STUDY, 3), simulate(STUDY, 5)
    assert_same(many.of_subjects(few.subjects["subject"]), few)
    assert_same(simulate(STUDY, 3), few)
    other = simulate(STUDY, 3, seed=1)
    assert not set(other.subjects["subject"]) & set(few.subjects["subject"])


def test_dropouts_are_started_only(study: Study) -> None:
    """Who stops has fewer trials, no questionnaire and no completion."""
    data = simulate(study, 8, ObserverModel(dropout=1))
    assert (data.subjects["status"] == "started").all()
    assert data.questionnaires.empty
    assert len(data.trials) < 8 * len(make_schedules(study)[0].entries)


def test_the_questionnaire_is_the_subjects(study: Study) -> None:
    """Age and expertise in the table of subjects are those of the questionnaires."""
    data = simulate(study, 6, ObserverModel(expert_share=0.5))
    told = data.questionnaires.pivot_table("answer", "subject", "question", aggfunc="first")
    subjects = data.subjects.set_index("subject").reindex(told.index)
    assert (subjects["age"] == told["age"].astype(float)).all()
    assert (subjects["expertise"] == (told["expertise"] == "yes")).all()
    assert subjects["expertise"].nunique() == 2


@pytest.mark.parametrize("subjects", [0, -1, 100_001])
def test_impossible_numbers_are_told(subjects: int) -> None:
    """None, fewer and too many subjects are one sentence."""
    with pytest.raises(RelightlabError, match=f"from 1 to 100000 subjects, got {subjects}"):
        simulate(STUDY, subjects)


def test_simulated_answers_never_get_among_others(sqlite_store: ResponseStore) -> None:
    """A store of people's answers takes no simulated ones, and the other way round."""
    simulated = simulate(STUDY, 2)
    assert write_apart(sqlite_store, simulated)["subjects"] == 2
    assert write_apart(sqlite_store, simulated)["subjects"] == 0
    with pytest.raises(RelightlabError, match="would hold simulated answers beside others"):
        write_apart(sqlite_store, answers())
    assert_same(sqlite_store.read(), simulated)
