"""Tests of the statistics of methods that were measured on the same objects."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from evaluation.paired_statistics import friedman_test, paired_means, pairwise_tests

seeds = st.integers(0, 2**32 - 1)


def errors_of(seed: int, objects: int = 12, methods: int = 3) -> np.ndarray:
    """Errors of methods that differ less than objects do."""
    generator = np.random.default_rng(seed)
    scale = generator.lognormal(sigma=1.0, size=(objects, 1))
    return scale * generator.lognormal(sigma=0.2, size=(objects, methods))


def test_a_bootstrap_interval_is_that_of_the_normal_law_for_many_objects() -> None:
    """Over 400 objects it is the mean plus and minus 1.96 standard errors, to a twentieth."""
    values = np.random.default_rng(1).normal(5.0, 2.0, size=(400, 2))
    found = paired_means(values, 0, np.random.default_rng(2))
    error = values.std(axis=0) / 20
    assert np.allclose(found.mean, values.mean(axis=0))
    assert np.allclose(found.high - found.mean, 1.96 * error, rtol=0.05)
    assert np.allclose(found.mean - found.low, 1.96 * error, rtol=0.05)


def test_the_interval_of_a_difference_is_paired() -> None:
    """A method that is better by the same amount everywhere is so without any doubt."""
    values = errors_of(3, methods=1) + np.array([0.0, 0.01])
    found = paired_means(values, 0, np.random.default_rng(0))
    assert np.allclose([found.difference_low[1], found.difference_high[1]], 0.01)
    assert found.high[0] - found.low[0] > 0.1
    assert found.difference[0] == found.difference_low[0] == found.difference_high[0] == 0


@given(seeds)
def test_intervals_hold_their_mean(seed: int) -> None:
    """The mean lies inside its interval, and so does the difference in its own."""
    found = paired_means(errors_of(seed), 1, np.random.default_rng(seed), draws=500)
    assert (found.low <= found.mean).all()
    assert (found.mean <= found.high).all()
    assert (found.difference_low <= found.difference + 1e-12).all()
    assert (found.difference <= found.difference_high + 1e-12).all()


def test_ninety_five_in_a_hundred_intervals_cover_the_truth() -> None:
    """Over 400 samples of 30 objects the intervals cover the true mean 90 to 98 times in 100."""
    generator = np.random.default_rng(11)
    covered = []
    for _ in range(400):
        found = paired_means(generator.normal(1.0, 1.0, (30, 1)), 0, generator, draws=400)
        covered.append(found.low[0] <= 1.0 <= found.high[0])
    assert 0.90 <= np.mean(covered) <= 0.98


def test_objects_that_are_not_whole_are_left_out() -> None:
    """An object without one of the errors changes nothing."""
    values = errors_of(5)
    more = np.vstack([values, [np.nan, 1.0, 1.0]])
    first, second = (paired_means(v, 0, np.random.default_rng(4)) for v in (values, more))
    assert np.array_equal(first.low, second.low)
    assert friedman_test(values) == friedman_test(more)
    assert pairwise_tests(values, "abc") == pairwise_tests(more, "abc")


def test_one_object_has_a_mean_but_no_interval() -> None:
    """A single object says nothing about others, and none says nothing at all."""
    one = paired_means(np.array([[1.0, 3.0]]), 0, np.random.default_rng(0))
    assert one.mean.tolist() == [1.0, 3.0]
    assert one.difference.tolist() == [0.0, 2.0]
    assert np.isnan(one.low).all()
    assert np.isnan(one.difference_high).all()
    none = paired_means(np.full((2, 2), np.nan), 0, np.random.default_rng(0))
    assert np.isnan(none.mean).all()


def test_friedman_agrees_with_its_formula() -> None:
    """Without ties the statistic is 12 / (n k (k + 1)) sum R_j^2 - 3 n (k + 1)."""
    values = errors_of(7, objects=9, methods=4)
    ranks = values.argsort(axis=1).argsort(axis=1) + 1
    count, methods = values.shape
    sums = ranks.sum(axis=0)
    expected = 12 / (count * methods * (methods + 1)) * (sums**2).sum() - 3 * count * (methods + 1)
    found = friedman_test(values)
    assert found is not None
    assert np.isclose(found["statistic"], expected)
    assert (found["objects"], found["methods"]) == (9, 4)


@pytest.mark.parametrize("shape", [(2, 4), (9, 2)])
def test_friedman_says_nothing_about_too_little(shape: tuple[int, int]) -> None:
    """Two objects, or two methods, are not tested."""
    assert friedman_test(errors_of(1, *shape)) is None


def test_wilcoxon_of_few_objects_is_exact() -> None:
    """Six objects that all agree give 2 / 2^6, as R's wilcox.test(exact = TRUE) does."""
    values = np.arange(1.0, 7.0)[:, None] * [1.0, 1.1]
    row = pairwise_tests(values, ["better", "worse"])[0]
    assert row["p"] == pytest.approx(0.03125)
    assert (row["wins"], row["losses"]) == (6, 0)
    assert row["median_difference"] == pytest.approx(-0.35)


@given(seeds)
def test_holm_corrects_step_by_step(seed: int) -> None:
    """The smallest p is multiplied by the number of pairs, and no corrected p is below its own."""
    rows = pairwise_tests(errors_of(seed, methods=4), "abcd")
    assert len(rows) == 6
    smallest = min(rows, key=lambda row: row["p"])
    assert smallest["p_holm"] == pytest.approx(min(1.0, 6 * smallest["p"]))
    assert all(row["p"] <= row["p_holm"] <= 1.0 for row in rows)


def test_equal_methods_do_not_differ() -> None:
    """Methods with the same errors tie everywhere, with p one."""
    row = pairwise_tests(np.ones((5, 2)), ["one", "other"])[0]
    assert (row["wins"], row["losses"], row["p"], row["p_holm"]) == (0, 0, 1.0, 1.0)


def test_a_method_that_failed_everywhere_leaves_the_others() -> None:
    """Its column of NaN is NaN in all that is found, and changes nothing of the other methods."""
    values = errors_of(5)
    failed = np.column_stack([values, np.full(len(values), np.nan)])
    found = paired_means(failed, 0, np.random.default_rng(0))
    expected = paired_means(values, 0, np.random.default_rng(0))
    for name in ("mean", "low", "high", "difference", "difference_low", "difference_high"):
        assert np.allclose(getattr(found, name)[:3], getattr(expected, name))
        assert np.isnan(getattr(found, name)[3])
    assert friedman_test(failed) == friedman_test(values)
    pairs = {(row["first"], row["second"]): row for row in pairwise_tests(failed, "abcd")}
    alone = {(row["first"], row["second"]): row for row in pairwise_tests(values, "abc")}
    assert all(pairs[key]["p"] == alone[key]["p"] for key in alone)
    assert (pairs["a", "d"]["wins"], pairs["a", "d"]["p"]) == (0, 1.0)
    assert np.isnan(pairs["a", "d"]["median_difference"])


def test_without_a_reference_there_is_no_difference() -> None:
    """Means and intervals are the same; differences are NaN."""
    values = errors_of(6)
    found = paired_means(values, None, np.random.default_rng(0))
    assert np.allclose(found.low, paired_means(values, 0, np.random.default_rng(0)).low)
    assert np.isnan([found.difference, found.difference_low, found.difference_high]).all()
