"""The whole analysis: what it contains, its marks, its speed, and two published sets."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from studies.analysis.intervals import cluster_interval, two_way_interval, wilson_interval
from studies.analysis.rates import RATE_COLUMNS
from studies.analysis.study_analysis import analyze, analyze_study
from studies.bare_study import bare_study
from studies.published_sets import read_dynavect, read_gengap
from studies.study_records import AnalysisPlan
from studies.tables import StudyData
from tests.studies.analysis.made_answers import FAMILIES, OTHERS, made_answers

ALLOWED_SECONDS = 5.0
TWO_TASKS = {"ours-real": "ours", "barron-malik-real": "barron-malik"}


def test_rates_are_those_of_their_trials() -> None:
    """Every rate can be had from the trials by hand, with its three intervals."""
    data = made_answers(20, np.random.default_rng(0), tasks=TWO_TASKS)
    result = analyze(data, families=FAMILIES, others=OTHERS)
    row = next(row for row in result.rates if row["level"] == "2nd half")
    assert tuple(row) == RATE_COLUMNS
    trials = data.trials
    own = trials[(trials["task"] == row["task"]) & (trials["position"] > 5)]
    outcome, subject = own["chose_target"], own["subject"].to_numpy()
    assert (row["trials"], row["subjects"]) == (len(own), own["subject"].nunique())
    assert row["rate"] == pytest.approx(outcome.mean())
    for name, interval in {
        "wilson": wilson_interval(outcome.sum(), len(own)),
        "cluster": cluster_interval(outcome, subject),
        "twoway": two_way_interval(outcome, subject, own["pair"].to_numpy()),
    }.items():
        assert (row[f"{name}_low"], row[f"{name}_high"]) == pytest.approx(interval)


def test_levels_add_up() -> None:
    """The trials of a group's levels sum to those of everybody, weighted rates too."""
    result = analyze(made_answers(40, np.random.default_rng(1), tasks=TWO_TASKS))
    rates = pd.DataFrame(result.rates)
    rates["chosen"] = rates["rate"] * rates["trials"]
    sums = rates.groupby(["task", "condition", "group"])[["trials", "chosen"]].sum()
    for (_, _, _), own in sums.groupby(["task", "condition", "task"], sort=False):
        np.testing.assert_allclose(own["trials"], own["trials"].iloc[0])
        np.testing.assert_allclose(own["chosen"], own["chosen"].iloc[0])


def test_the_mark_of_made_up_answers_is_carried() -> None:
    """One simulated subject marks the result."""
    data = made_answers(10, np.random.default_rng(0), tasks={"one": "ours"})
    live = analyze(StudyData(data.subjects.assign(mode="live"), data.trials))
    assert (live.simulated, live.marks) == (False, [])
    mode = ["simulated"] + ["live"] * 9
    mixed = StudyData(data.subjects.assign(mode=mode), data.trials)
    marked = analyze(mixed)
    assert (marked.simulated, marked.marks) == (True, ["simulated"])


def test_the_same_answers_give_the_same_result() -> None:
    """Rows in another order change no number beyond rounding, and all of it is JSON."""
    data = made_answers(24, np.random.default_rng(5), tasks=TWO_TASKS)
    turned = StudyData(data.subjects.iloc[::-1], data.trials.sample(frac=1, random_state=0))
    first, second = (analyze(each, families=FAMILIES, others=OTHERS) for each in (data, turned))
    json.dumps(first.as_dict(), allow_nan=False)
    for name in ("rates", "models", "tests"):
        one, other = (pd.DataFrame(getattr(result, name)) for result in (first, second))
        pd.testing.assert_frame_equal(one, other, rtol=1e-4, atol=1e-6)
    assert json.dumps(first.as_dict()) == json.dumps(
        analyze(data, families=FAMILIES, others=OTHERS).as_dict()
    )


def test_every_task_has_its_models() -> None:
    """Mixed model and GEE with side and learning, and the comparison of two tasks."""
    result = analyze(made_answers(100, np.random.default_rng(6)), families=FAMILIES, others=OTHERS)
    models = pd.DataFrame(result.models)
    names = set(models["model"])
    assert {"mixed: ours-real", "mixed_plain: ours-real", "gee: ours-real"} <= names
    strengths = "bradley_terry: barron-malik, karsch, ours, real"
    assert {"mixed: barron-malik and ours", strengths} <= names
    assert {"ours", "real"} <= set(models[models["model"] == strengths]["term"])
    own = models[models["model"] == "mixed: barron-malik and ours"].set_index("term")
    assert {"(Intercept)", "conditionours", "side", "learning", "sd:subject", "sd:item"} <= set(
        own.index
    )
    assert own.loc["nobs", "estimate"] == 400


def test_what_cannot_be_fitted_is_noted() -> None:
    """Answers without exception leave notes, not a failure."""
    data = made_answers(6, np.random.default_rng(0), tasks={"one": "ours"})
    target = data.trials["target_side"]
    alike = StudyData(data.subjects, data.trials.assign(response=target, chose_target=1.0))
    result = analyze(alike)
    assert any("mixed: one was not fitted" in note for note in result.notes)
    assert result.rates[0]["cluster_low"] < 0.7
    assert {row["result"] for row in result.tests if row["kind"] == "chance"} == {
        "cannot be tested"
    }


def test_one_answer_is_analysed() -> None:
    """A single subject with a single pair gets a rate and no more."""
    data = made_answers(1, np.random.default_rng(0), pairs=1)
    result = analyze(data)
    assert result.rates[0]["cluster_low"] is None
    assert result.tests == []


def test_a_study_brings_its_plan() -> None:
    """Families, rivals, groups and margin are taken from the study file."""
    study = bare_study(pairs=10, tasks=2)
    tasks = {task.name: task.target for task in study.tasks}
    data = made_answers(30, np.random.default_rng(0), tasks=tasks)
    study = replace(study, analysis=AnalysisPlan(groups=("gender",)))
    result = analyze_study(data, study)
    assert {row["group"] for row in result.rates} == {"all", "gender", "side"}


def test_ten_thousand_trials_are_fast() -> None:
    """All intervals and models of 10,000 trials take less than five seconds."""
    data = made_answers(1000, np.random.default_rng(8))
    before = time.process_time()
    analyze(data, families=FAMILIES, others=OTHERS)
    assert time.process_time() - before < ALLOWED_SECONDS


@pytest.mark.real_data
def test_dynavect(data_root: Path) -> None:
    """The published rates of dynavect: 60.3 and 58.9 %, and its mixed model."""
    path = data_root / "dynavect-2afc" / "dynavect_trials.csv"
    if not path.is_file():
        pytest.skip(f"{data_root} holds no dynavect-2afc/")
    result = analyze(read_dynavect(path))
    rates = {row["condition"]: row for row in result.rates if row["group"] == "all"}
    assert rates["styleclip_g"]["rate"] == pytest.approx(0.6034, abs=5e-5)
    assert rates["styleclip_o"]["rate"] == pytest.approx(0.5888, abs=5e-5)
    assert [rates[name]["trials"] for name in sorted(rates)] == [1576, 1571]
    models = {(row["model"], row["term"]): row["estimate"] for row in result.models}
    plain = "mixed_plain: dynavect-2afc"
    assert models[plain, "(Intercept)"] == pytest.approx(0.45497, abs=1e-3)
    assert models[plain, "logLik"] == pytest.approx(-1994.235, abs=0.01)
    assert not result.simulated


@pytest.mark.real_data
def test_gengap(data_root: Path) -> None:
    """The paper of gengap keeps 112 of 120 subjects, who were right in 87.0 % of trials."""
    path = data_root / "gengap-realfake" / "gengap_trials.csv"
    if not path.is_file():
        pytest.skip(f"{data_root} holds no gengap-realfake/")
    result = analyze(read_gengap(path))
    everybody = [row for row in result.rates if row["group"] == "all"]
    right = sum(row["rate"] * row["trials"] for row in everybody)
    assert right / sum(row["trials"] for row in everybody) == pytest.approx(0.870, abs=5e-4)
    assert [step["subjects"] for step in result.exclusions] == [0, 8]
