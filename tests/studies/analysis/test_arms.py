"""Which rates are compared with which."""

from __future__ import annotations

import numpy as np

from studies.analysis.arms import comparisons, with_arms
from studies.analysis.subpopulations import main_trials
from tests.studies.analysis.made_answers import FAMILIES, OTHERS, made_answers


def test_only_what_is_held_against_the_same_is_compared() -> None:
    """Two methods against real pictures are compared; ours against two rivals are not."""
    trials = main_trials(made_answers(20, np.random.default_rng(0)))
    found = dict(comparisons(with_arms(trials, FAMILIES, OTHERS)))
    assert list(found) == ["barron-malik and ours"]
    assert set(found["barron-malik and ours"]["task"]) == {"ours-real", "barron-malik-real"}


def test_conditions_of_one_task_are_compared() -> None:
    """Without families the conditions mixed within a task are."""
    trials = main_trials(made_answers(4, np.random.default_rng(0), tasks={"edit": "a"}))
    trials = trials.assign(condition=np.where(np.arange(len(trials)) % 2, "a", "b"))
    assert [name for name, _ in comparisons(with_arms(trials, {}, {}))] == ["a and b"]


def test_equal_conditions_are_told_apart_by_their_task() -> None:
    """Two tasks of one comparison with the same condition keep two arms."""
    tasks = {"near": "ours", "far": "ours"}
    trials = main_trials(made_answers(4, np.random.default_rng(0), tasks=tasks))
    arms = with_arms(trials, dict.fromkeys(tasks, "f"), dict.fromkeys(tasks, "real"))["arm"]
    assert set(arms) == {"near ours", "far ours"}
