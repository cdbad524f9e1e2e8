"""Simulated studies: the model's rates, the analysis's own errors, and the tests' levels."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy.special import expit, logit

from studies.analysis.cell_means import cell_means, contrast
from studies.analysis.intervals import cluster_variance, two_way_variance
from studies.power_simulation import (
    Scope,
    Sums,
    differs,
    draw_sums,
    estimate,
    intercept,
    is_equivalent,
    shown_pairs,
)

Bools = npt.NDArray[np.bool_]


def sums_of(chosen: Bools, seen: Bools) -> Sums:
    """Return the sums of one study of one size from its answers, (subjects, items)."""
    by_subject = (chosen & seen).sum(axis=1)
    return Sums(
        np.array([len(chosen)]),
        int(seen[0].sum()),
        np.array([[by_subject.sum()]], float),
        np.array([[(by_subject**2).sum()]], float),
        (chosen & seen).sum(axis=0)[None, None].astype(float),
        seen.sum(axis=0)[None].astype(float),
    )


def answers(subjects: int, items: int, shown: int, seed: int) -> tuple[Bools, Bools]:
    """Return answers with effects of subjects and items, and who saw what."""
    generator = np.random.default_rng(seed)
    odds = generator.normal(0, 1, (subjects, 1)) + generator.normal(0, 1, (1, items))
    chosen = generator.random((subjects, items)) < expit(odds)
    return chosen, shown_pairs(subjects, items, shown)


@pytest.mark.parametrize("rate", [0.1, 0.44, 0.5, 0.9])
@pytest.mark.parametrize("deviation", [0.0, 0.6, 2.0])
def test_the_expected_rate_is_the_given_one(rate: float, deviation: float) -> None:
    """Averaged over the effects by brute force, the model has the rate asked for."""
    levels = np.random.default_rng(0).standard_normal(200_000)
    levels -= levels.mean()
    mean = expit(intercept(rate, deviation) + deviation * levels / levels.std()).mean()
    assert mean == pytest.approx(rate, abs=2e-3)
    if deviation == 0:
        assert intercept(rate, deviation) == pytest.approx(logit(rate), abs=1e-9)


@pytest.mark.parametrize("shown", [10, 6])
def test_errors_of_a_rate_are_those_of_the_analysis(shown: int) -> None:
    """Both standard errors are the ones that the study's answers will be given."""
    chosen, seen = answers(24, 10, shown, seed=1)
    subject, item = np.nonzero(seen)
    outcome = chosen[seen].astype(float)
    arm = sums_of(chosen, seen)
    one = estimate([arm], "these scenes")
    both = estimate([arm], "scenes like these")
    assert one.value[0, 0] == pytest.approx(outcome.mean())
    assert one.error[0, 0] ** 2 == pytest.approx(cluster_variance(outcome, subject))
    assert both.error[0, 0] ** 2 == pytest.approx(two_way_variance(outcome, subject, item))
    assert (one.freedom.tolist(), both.freedom.tolist()) == ([23], [9])


def test_the_error_of_a_difference_is_that_of_the_analysis() -> None:
    """Two groups of different size are compared as the analysis compares them."""
    arms = [answers(count, 10, 10, seed) for count, seed in ((9, 2), (31, 3))]
    outcome = np.concatenate([chosen.ravel() for chosen, _ in arms]).astype(float)
    subject = np.repeat(np.arange(40), 10)
    expected = contrast(cell_means(outcome, subject >= 9, subject), [1, -1])
    found = estimate([sums_of(*arm) for arm in arms], "these scenes")
    assert found.value[0, 0] == pytest.approx(expected.difference)
    assert found.error[0, 0] == pytest.approx(expected.standard_error)
    assert found.freedom.tolist() == [expected.subjects - 1]


def test_sums_of_sizes_are_those_of_the_beginnings() -> None:
    """A smaller study is the beginning of a larger one, and every trial is in one item's sum."""
    effects = np.random.default_rng(4).standard_normal((50, 8)).astype(np.float32)
    sums = draw_sums(0.3, 0.7, effects, [4, 9, 30], 5, np.random.default_rng(5))
    assert (np.diff(sums.target, axis=1) >= 0).all()
    np.testing.assert_array_equal(sums.items.sum(axis=-1), sums.target)
    np.testing.assert_array_equal(sums.item_trials.sum(axis=-1), sums.trials)
    assert (sums.squares >= sums.target**2 / sums.subjects).all()
    assert (sums.items <= sums.item_trials).all()


def test_subject_effects_spread_subjects_as_much_as_they_should() -> None:
    """The variance of subjects' counts is the binomial one, plus that of their own rates."""
    effects = np.zeros((2000, 10), np.float32)
    sums = draw_sums(0.0, 1.0, effects, [50], 10, np.random.default_rng(6))
    spread = (sums.squares / 50 - (sums.target / 50) ** 2).mean() * 50 / 49
    own = expit(np.random.default_rng(7).standard_normal(400_000)).var()
    assert spread == pytest.approx(10 * 0.25 + 90 * own, rel=0.02)


@pytest.mark.parametrize("scope", ["these scenes", "scenes like these"])
def test_a_test_of_nothing_keeps_its_level(scope: Scope) -> None:
    """Where the rate is 50 %, about 5 % of studies say that it is not."""
    generator = np.random.default_rng(8)
    effects = 0.4 * generator.standard_normal((4000, 30)).astype(np.float32)
    if scope == "these scenes":
        effects -= effects.mean(axis=1, keepdims=True)
    sums = draw_sums(0.0, 0.5, effects, [40], 30, generator)
    found = estimate([sums], scope)
    assert 0.035 < differs(found, 0.5, 0.05).mean() < 0.07


def test_a_rate_on_the_margin_is_seldom_called_equivalent() -> None:
    """At the margin itself, at most about 5 % of studies call it equivalent to 50 %."""
    generator = np.random.default_rng(9)
    effects = np.zeros((4000, 10), np.float32)
    sums = draw_sums(intercept(0.55, 0.5), 0.5, effects, [300], 10, generator)
    found = estimate([sums], "these scenes")
    assert 0.035 < is_equivalent(found, 0.5, 0.05, 0.05).mean() < 0.065


def test_nothing_is_shown_without_variance() -> None:
    """Where all answer alike, no test can be made, and none succeeds."""
    arm = sums_of(np.ones((5, 4), bool), np.ones((5, 4), bool))
    found = estimate([arm], "scenes like these")
    assert not differs(found, 0.5, 0.05).any()
    assert not is_equivalent(found, 1.0, 0.05, 0.05).any()


def test_pairs_are_seen_equally_often() -> None:
    """Whoever sees only some of the pairs, together they see all as often."""
    seen = shown_pairs(21, 7, 3)
    assert set(seen.sum(axis=1).tolist()) == {3}
    assert set(seen.sum(axis=0).tolist()) == {9}
