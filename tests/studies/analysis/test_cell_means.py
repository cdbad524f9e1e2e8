"""Joint means of cells: paired and unpaired comparisons, groups, interactions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import ttest_ind, ttest_rel

from shading_model.errors import RelightlabError
from studies.analysis.cell_means import (
    cell_means,
    contrast,
    group_test,
    interaction_test,
    labelled,
    paired_difference,
    wald_test,
)
from tests.studies.analysis.oracle_files import r_answers, r_fits


def grid(subjects: int = 12, trials: int = 8, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return outcomes and subjects, as many trials of each."""
    rng = np.random.default_rng(seed)
    chance = rng.uniform(0.2, 0.9, subjects)
    subject = np.repeat(np.arange(subjects), trials)
    return (rng.random(subjects * trials) < chance[subject]).astype(float), subject


def test_covariance_is_that_of_r() -> None:
    """Two cells that the same subjects have answers in have R's sandwich covariance."""
    table, oracle = r_answers(), r_fits()["cells"]
    means = cell_means(table["y"], table["left"], table["subject"])
    np.testing.assert_allclose(means.mean, oracle["mean"], rtol=1e-9)
    np.testing.assert_allclose(means.covariance, oracle["covariance"], rtol=1e-8)
    assert [round(error**2, 9) for _, _, error in labelled(means)] == pytest.approx(
        np.diag(oracle["covariance"]), abs=1e-8
    )


def test_pairs_within_subjects_are_a_paired_t_test() -> None:
    """Where every subject judges both methods equally often, the test is Student's paired one."""
    outcome, subject = grid()
    method = np.tile(["a", "b"], len(outcome) // 2)
    found = paired_difference(outcome, method, subject, ("a", "b"))
    own = [[outcome[(subject == s) & (method == m)].mean() for s in range(12)] for m in "ab"]
    expected = ttest_rel(*own)
    assert found.p == pytest.approx(expected.pvalue)
    assert found[1:3] == pytest.approx(expected.confidence_interval(0.95))


def test_groups_of_subjects_have_the_standard_error_of_welch() -> None:
    """Two groups of subjects differ with Welch's standard error, on the freedom of the smaller."""
    outcome, subject = grid()
    group = np.where(subject < 4, "few", "many")
    found = paired_difference(outcome, group, subject, ("few", "many"))
    rates = np.array([outcome[subject == s].mean() for s in range(12)])
    expected = ttest_ind(rates[:4], rates[4:], equal_var=False)
    assert found.difference / found.standard_error == pytest.approx(expected.statistic)
    assert found.subjects == 4
    assert found.p > expected.pvalue


def test_one_contrast_is_the_square_of_t() -> None:
    """F of a single contrast has the p-value of its t test."""
    outcome, subject = grid()
    half = np.tile([0, 1], len(outcome) // 2)
    means = cell_means(outcome, half, subject)
    test, single = wald_test(means, [[-1, 1]]), contrast(means, [-1, 1])
    assert test.p == pytest.approx(single.p)
    assert test.statistic == pytest.approx((single.difference / single.standard_error) ** 2)


def test_interaction_is_a_difference_of_differences() -> None:
    """With two methods and two groups of subjects it compares the subjects' own differences."""
    outcome, subject = grid()
    method = np.tile(["a", "b"], len(outcome) // 2)
    group = np.where(subject < 6, "f", "m")
    own = np.array(
        [
            outcome[(subject == s) & (method == "b")].mean()
            - outcome[(subject == s) & (method == "a")].mean()
            for s in range(12)
        ]
    )
    test = interaction_test(outcome, method, group, subject)
    expected = ttest_ind(own[:6], own[6:], equal_var=False).statistic ** 2
    assert test.statistic == pytest.approx(expected)
    assert (test.numerator, test.denominator) == (1, 5)


def test_tests_keep_their_level() -> None:
    """Without any effect a fifth of tests of three groups falls below p = 0.2."""
    rng = np.random.default_rng(7)
    subject = np.repeat(np.arange(45), 6)
    group = np.array(["x", "y", "z"])[subject % 3]
    chances = rng.uniform(0.2, 0.8, (400, 45))
    p = [group_test(rng.random(270) < row[subject], group, subject).p for row in chances]
    assert np.mean(np.array(p) < 0.2) == pytest.approx(0.2, abs=0.06)


def test_a_cell_of_one_subject_cannot_be_tested() -> None:
    """The spread of a group that has one subject is not taken for zero."""
    outcome, subject = grid()
    found = paired_difference(outcome, subject == 0, subject, (True, False))
    assert np.isnan(found.p)
    assert np.isnan(group_test(outcome, subject == 0, subject).p)


def test_comparing_nothing_is_refused() -> None:
    """A method without answers, one subject, one level: each is said."""
    with pytest.raises(RelightlabError, match="no answers on 'c'"):
        paired_difference([1, 0], ["a", "b"], [1, 2], ("a", "c"))
    with pytest.raises(RelightlabError, match="two subjects or more, got 1"):
        cell_means([1, 0], ["a", "b"], [1, 1])
    with pytest.raises(RelightlabError, match="two levels"):
        group_test([1, 0], ["a", "a"], [1, 2])
    with pytest.raises(RelightlabError, match="3 combinations of 2 methods and 2 groups"):
        interaction_test([1, 0, 1], ["a", "a", "b"], ["f", "m", "m"], [1, 2, 3])
