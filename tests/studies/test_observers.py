"""Tests of simulated observers and their probabilities."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.special import expit, logit

from shading_model.errors import RelightlabError
from studies.bare_study import bare_study
from studies.observers import (
    Observer,
    ObserverModel,
    ShownTrial,
    choice_probabilities,
    item_effect,
)
from studies.study_records import Question, Study, TrialSettings

PLAIN = ObserverModel(rate=0.6, subject_sd=0, item_sd=0, lapse=0)
SIDES = ("left", "right", "left", "right")


def shown(count: int = 4, kind: str = "main") -> list[ShownTrial]:
    """Main trials of pairs of their own, with sides in turn."""
    sides = np.resize(SIDES, count)
    return [ShownTrial(kind, f"pair-{n}", str(sides[n]), n + 1) for n in range(count)]


def observer(model: ObserverModel = PLAIN, number: int = 0, study: Study | None = None) -> Observer:
    """One observer of a study without pictures."""
    return Observer(study or bare_study(), model, seed=0, number=number)


def log_odds(**effects: Any) -> list[float]:
    """What an effect adds to the log odds of four trials."""
    chance = choice_probabilities(observer(replace(PLAIN, **effects)), "task-1", shown())
    return [round(float(one), 9) for one in logit(chance) - logit(0.6)]


@pytest.mark.parametrize(
    ("effects", "added"),
    [
        ({}, [0, 0, 0, 0]),
        ({"side": 0.4}, [0.2, -0.2, 0.2, -0.2]),
        ({"learning": 0.1}, [-0.15, -0.05, 0.05, 0.15]),
        ({"expertise": 0.7, "expert_share": 1}, [0.7, 0.7, 0.7, 0.7]),
        ({"expertise": 0.7, "expert_share": 0}, [0, 0, 0, 0]),
    ],
)
def test_effects_add_to_the_log_odds(effects: dict[str, float], added: list[float]) -> None:
    """Side, learning and expertise add what the model says, and nothing else."""
    assert log_odds(**effects) == added


def test_a_lapse_is_a_coin() -> None:
    """A share of lapses draws the chance to one half by that share."""
    lapsing = choice_probabilities(observer(replace(PLAIN, lapse=0.3)), "task-1", shown())
    np.testing.assert_allclose(lapsing, 0.7 * 0.6 + 0.3 * 0.5)


def test_subject_and_item_effects_are_crossed() -> None:
    """An item is as hard for everybody, an observer as sharp everywhere; both have their spread."""
    model = replace(PLAIN, subject_sd=0.8, item_sd=0.5)
    many = [observer(model, number) for number in range(400)]
    odds = np.array([logit(choice_probabilities(one, "task-1", shown(10))) for one in many])
    items = [item_effect(many[0], "task-1", f"pair-{n}") for n in range(10)]
    subjects = np.array([one.effect for one in many])
    np.testing.assert_allclose(odds, logit(0.6) + subjects[:, None] + items)
    # Standard errors of a deviation of n normal draws: sd / sqrt(2 n).
    assert abs(subjects.std() - 0.8) < 3 * 0.8 / np.sqrt(800)
    drawn = [item_effect(many[0], "task-1", f"other-{n}") for n in range(400)]
    assert abs(np.std(drawn) - 0.5) < 3 * 0.5 / np.sqrt(800)


def test_qualification_and_closing_have_rates_of_their_own() -> None:
    """Neither a subject's nor an item's effect, nor learning, is in them."""
    model = ObserverModel(subject_sd=5, item_sd=5, learning=2, lapse=0, closing=0.8)
    for kind, rate in (("qualification", 0.99), ("closing", 0.8)):
        chance = choice_probabilities(observer(model), "task-1", shown(3, kind))
        np.testing.assert_allclose(chance, rate)


def test_tasks_have_their_own_rates() -> None:
    """A task that is named has its rate, others the common one."""
    model = replace(PLAIN, rates={"task-2": 0.9})
    chances = [choice_probabilities(observer(model), f"task-{n}", shown(1))[0] for n in (1, 2)]
    np.testing.assert_allclose(chances, [0.6, 0.9])


def test_answers_are_drawn_with_these_chances() -> None:
    """Over 3000 observers the share of targets is the chance, within four standard errors."""
    model = replace(PLAIN, side=0.6)
    trials = shown(2)
    taken = np.zeros(2)
    for number in range(3000):
        response = observer(model, number).answers("task-1", trials).response
        taken += [one == trial.target_side for one, trial in zip(response, trials, strict=True)]
    expected = expit(logit(0.6) + np.array([0.3, -0.3]))
    errors = np.sqrt(expected * (1 - expected) / 3000)
    assert (np.abs(taken / 3000 - expected) < 4 * errors).all()


def test_a_trial_is_answered_the_same_in_any_company() -> None:
    """A pair's answer does not depend on the order of the others, nor on who else takes part."""
    trials = shown(4)
    first = observer().answers("task-1", trials).response
    assert observer().answers("task-1", trials[::-1]).response[::-1] == first
    assert len({observer(number=n).answers("task-1", shown(10)).response for n in range(5)}) > 1


def test_ties_come_only_where_they_are_allowed() -> None:
    """A model of ties has none in a study that allows none."""
    free = replace(bare_study(), settings=TrialSettings(allow_tie=True))
    model = replace(PLAIN, tie=1)
    assert set(observer(model, study=free).answers("task-1", shown()).response) == {"tie"}
    assert "tie" not in observer(model).answers("task-1", shown()).response


def test_reactions_come_after_the_least_view() -> None:
    """Nobody answers before the pictures may be judged, and times differ."""
    times = observer().answers("task-1", shown(50)).reaction_ms
    assert times.min() > bare_study().settings.minimum_view_ms
    assert len(set(times)) > 40


def test_some_leave_before_the_end() -> None:
    """Those who stop do so before the last trial; without dropout nobody does."""
    leaver = observer(replace(PLAIN, dropout=1)).answers("task-1", shown(10))
    assert 0 <= leaver.stops_after < 10
    assert observer().answers("task-1", shown(10)).stops_after == 10


def test_questions_are_answered_as_they_allow() -> None:
    """Options are the question's, numbers within bounds, expertise as the observer declares it."""
    questions = (
        Question("gender", "?", "choice", ("a", "b")),
        Question("age", "?", "number", minimum=40, maximum=42),
        Question("expertise", "?", "choice", ("No", "Yes")),
        Question("comment", "?", "text"),
        Question("why", "?", "text", required=True),
    )
    study = replace(bare_study(), questionnaire=questions)
    expert = observer(replace(PLAIN, expert_share=1), study=study).questionnaire()
    assert expert.keys() == {"gender", "age", "expertise", "why"}
    assert expert["gender"] in {"a", "b"}
    assert 40 <= float(expert["age"]) <= 42
    assert expert["expertise"] == "Yes"
    layman = observer(replace(PLAIN, expert_share=0), study=study).questionnaire()
    assert layman["expertise"] == "No"


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"rate": 1.0}, "expected rate to be between 0 and 1, got 1"),
        ({"rates": {"real": 0.0}}, "expected the rate of real to be between 0 and 1, got 0"),
        ({"closing": float("nan")}, "expected closing to be between 0 and 1, got nan"),
        ({"lapse": -0.1}, "expected lapse from 0 to 1, got -0.1"),
        ({"subject_sd": -1}, "expected subject_sd from 0 up, got -1"),
    ],
)
def test_impossible_models_are_told(wrong: dict[str, Any], sentence: str) -> None:
    """A rate, share or deviation that cannot be is one sentence."""
    with pytest.raises(RelightlabError, match=sentence):
        ObserverModel(**wrong)
