"""Intervals of a rate: closed forms, R's sandwich package, properties, bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.stats import norm, sem, ttest_1samp
from scipy.stats import t as student

from shading_model.errors import RelightlabError
from studies.analysis.intervals import (
    cluster_interval,
    cluster_variance,
    paper_mean,
    two_way_interval,
    two_way_variance,
    wilson_interval,
)
from tests.studies.analysis.oracle_files import r_answers, r_fits

GRIDS = hnp.arrays(
    np.int8, st.tuples(st.integers(2, 9), st.integers(2, 7)), elements=st.integers(0, 1)
)


def flat(grid: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return outcomes, subjects and items of a table of subjects by items."""
    subjects, items = grid.shape
    return (
        grid.ravel().astype(float),
        np.repeat(np.arange(subjects), items),
        np.tile(np.arange(items), subjects),
    )


@given(st.integers(0, 60), st.integers(1, 60))
def test_wilson_solves_its_equation(successes: int, more: int) -> None:
    """At Wilson's bounds the observed share is exactly z standard errors of the bound away."""
    trials, z = successes + more, norm.isf(0.025)
    for bound in wilson_interval(successes, trials):
        distance = abs(successes / trials - bound)
        assert distance == pytest.approx(z * math.sqrt(bound * (1 - bound) / trials), abs=1e-9)


def test_wilson_of_nothing_is_not_a_number() -> None:
    """Without trials there are no bounds."""
    assert np.isnan(wilson_interval(0, 0)).all()


@given(GRIDS)
def test_balanced_clusters_are_a_t_test_of_subjects(grid: np.ndarray) -> None:
    """Where all subjects have as many trials, the interval is Student's for their own rates."""
    outcome, subject, _ = flat(grid)
    rates = grid.mean(axis=1)
    if rates.std() == 0:
        return
    low, high = ttest_1samp(rates, 0.5).confidence_interval(0.95)
    assert cluster_interval(outcome, subject) == pytest.approx((max(0, low), min(1, high)))
    assert paper_mean(outcome, subject) == pytest.approx((rates.mean(), sem(rates)))


def test_variances_are_those_of_r() -> None:
    """One-way and two-way variances of unbalanced answers agree with R's vcovCL."""
    table, oracle = r_answers(), r_fits()["variance"]
    outcome, subject, item = (table[name].to_numpy() for name in ("y", "subject", "item"))
    assert cluster_variance(outcome, subject) == pytest.approx(oracle["subject"], rel=1e-9)
    assert cluster_variance(outcome, item) == pytest.approx(oracle["item"], rel=1e-9)
    assert two_way_variance(outcome, subject, item) == pytest.approx(oracle["both"], rel=1e-9)


def test_two_way_interval_has_the_freedom_of_the_fewer() -> None:
    """With 24 subjects and 10 items, the quantile is that of 9 degrees of freedom."""
    table = r_answers()
    reach = student.isf(0.05, 9) * math.sqrt(r_fits()["variance"]["both"])
    low, high = two_way_interval(table["y"], table["subject"], table["item"], alpha=0.1)
    assert (high - low) / 2 == pytest.approx(reach)


@given(GRIDS, st.randoms(use_true_random=False))
def test_intervals_do_not_depend_on_order_or_names(grid: np.ndarray, random: object) -> None:
    """Rows in another order and labels of another kind give the same intervals."""
    outcome, subject, item = flat(grid)
    order = np.random.default_rng(random.getrandbits(32)).permutation(len(outcome))  # type: ignore[attr-defined]
    names = np.array([f"name {number * 7 % 11}" for number in range(9)])
    first = two_way_interval(outcome, subject, item)
    second = two_way_interval(outcome[order], names[subject][order], names[item][order])
    assert second == pytest.approx(first, nan_ok=True)


@given(GRIDS)
def test_intervals_mirror(grid: np.ndarray) -> None:
    """The interval of the other choice is the mirror image."""
    outcome, subject, item = flat(grid)
    for interval in (cluster_interval, two_way_interval):
        labels = (subject,) if interval is cluster_interval else (subject, item)
        low, high = interval(outcome, *labels)
        mirrored = interval(1 - outcome, *labels)
        assert mirrored == pytest.approx((1 - high, 1 - low), abs=1e-12)
        assert 0 <= low <= outcome.mean() + 1e-12
        assert outcome.mean() - 1e-12 <= high <= 1


@given(GRIDS)
def test_two_ways_are_not_narrower_than_one(grid: np.ndarray) -> None:
    """The two-way variance is at least that by subjects and that by items."""
    outcome, subject, item = flat(grid)
    both = two_way_variance(outcome, subject, item)
    assert both >= max(cluster_variance(outcome, subject), cluster_variance(outcome, item)) - 1e-12


def test_unanimous_subjects_are_not_certain() -> None:
    """Where all choose the same the interval is Wilson's with a trial for each subject."""
    low, high = cluster_interval(np.ones(50), np.repeat(np.arange(5), 10))
    assert (low, high) == pytest.approx(wilson_interval(5, 5))
    assert low < 0.6


def test_one_subject_has_no_interval() -> None:
    """The spread of subjects cannot be had from one."""
    assert np.isnan(cluster_interval([1, 0], ["a", "a"])).all()
    assert np.isnan(two_way_interval([1, 0], ["a", "b"], ["x", "x"])).all()
    assert paper_mean([1, 0], ["a", "a"]).mean == 0.5


@pytest.mark.parametrize(
    ("outcome", "subject", "sentence"),
    [
        ([1, 2], ["a", "b"], "from 0 to 1"),
        ([1, math.nan], ["a", "b"], "without NaN"),
        ([1, 0], ["a"], "a label for each of 2 outcomes, got 1"),
        ([1, 0], ["a", None], "a missing one"),
    ],
)
def test_bad_answers_are_refused(outcome: list[float], subject: list[str], sentence: str) -> None:
    """What is no answer, or nobody's, is said in a sentence."""
    with pytest.raises(RelightlabError, match=sentence):
        cluster_interval(outcome, np.array(subject, dtype=object))
