"""The bootstrap by subjects: against a plain loop, against the sandwich, its speed."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

from shading_model.errors import RelightlabError
from studies.analysis.cluster_bootstrap import bootstrap_rates
from studies.analysis.intervals import cluster_variance

ALLOWED_SECONDS = 2.0


def answers(subjects: int = 200) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return outcomes, subjects and eleven sets of trials."""
    rng = np.random.default_rng(5)
    subject = np.repeat(np.arange(subjects), 10)
    outcome = rng.random(10 * subjects) < rng.uniform(0.2, 0.9, subjects)[subject]
    sets = [np.ones(len(subject), dtype=bool)]
    sets += [rng.random(subjects)[subject] < 0.5 for _ in range(10)]
    return outcome.astype(float), subject, np.column_stack(sets)


def test_draws_are_rates_of_drawn_subjects() -> None:
    """Every draw is the rate of some subjects taken with replacement: all of one are 0 or 1."""
    outcome, subject = np.array([1.0, 1, 0, 0]), np.array([0, 0, 1, 1])
    found = bootstrap_rates(outcome, subject, np.ones((4, 1)), np.random.default_rng(0), 4000)
    values, counts = np.unique(found.drawn, return_counts=True)
    assert values.tolist() == [0.0, 0.5, 1.0]
    np.testing.assert_allclose(counts / 4000, [0.25, 0.5, 0.25], atol=0.03)


def test_spread_is_that_of_the_sandwich() -> None:
    """The deviation of the draws is near the cluster-robust standard error."""
    outcome, subject, sets = answers()
    found = bootstrap_rates(outcome, subject, sets, np.random.default_rng(1), 4000)
    for column in range(3):
        own = sets[:, column]
        expected = math.sqrt(cluster_variance(outcome[own], subject[own]))
        assert found.drawn[:, column].std() == pytest.approx(expected, rel=0.06)
    np.testing.assert_allclose(found.rate[0], outcome.mean())


def test_same_generator_same_bounds() -> None:
    """The same seed gives the same draws, also over several chunks."""
    outcome, subject, sets = answers(30)
    first, second = (
        bootstrap_rates(outcome, subject, sets, np.random.default_rng(2), 4500) for _ in range(2)
    )
    np.testing.assert_array_equal(first.drawn, second.drawn)


def test_an_empty_set_has_no_bounds() -> None:
    """A set without trials has NaN, without a warning, and does not disturb others."""
    outcome, subject, sets = answers(20)
    sets[:, 1] = False
    found = bootstrap_rates(outcome, subject, sets, np.random.default_rng(3), 100)
    assert np.isnan([found.rate[1], found.low[1], found.high[1]]).all()
    assert found.low[0] < found.rate[0] < found.high[0]


def test_shapes_are_checked() -> None:
    """Members of another number of trials are refused."""
    with pytest.raises(RelightlabError, match=r"shape \(3, sets\)"):
        bootstrap_rates([1, 0, 1], [1, 2, 3], np.ones((2, 1)), np.random.default_rng(0))


def test_fast_enough() -> None:
    """10,000 draws of 200 subjects with 10 trials and 11 sets take less than two seconds."""
    outcome, subject, sets = answers()
    before = time.process_time()
    bootstrap_rates(outcome, subject, sets, np.random.default_rng(4))
    assert time.process_time() - before < ALLOWED_SECONDS
