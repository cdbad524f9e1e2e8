"""Tests of groups and interactions: closed forms, level, bad input."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import ttest_ind

from shading_model.errors import RelightlabError
from studies.analysis.cell_means import cell_means, contrast
from studies.analysis.group_tests import group_test, interaction_test, wald_test
from tests.studies.analysis.made_answers import answer_grid


def test_one_contrast_is_the_square_of_t() -> None:
    """F of a single contrast has the p-value of its t test."""
    outcome, subject = answer_grid()
    half = np.tile([0, 1], len(outcome) // 2)
    means = cell_means(outcome, half, subject)
    test, single = wald_test(means, [[-1, 1]]), contrast(means, [-1, 1])
    assert test.p == pytest.approx(single.p)
    assert test.statistic == pytest.approx((single.difference / single.standard_error) ** 2)


def test_interaction_is_a_difference_of_differences() -> None:
    """With two methods and two groups of subjects it compares the subjects' own differences."""
    outcome, subject = answer_grid()
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


def test_groups_that_cannot_be_compared() -> None:
    """One level, a missing combination and a level of one subject are said, or have no p."""
    outcome, subject = answer_grid()
    assert np.isnan(group_test(outcome, subject == 0, subject).p)
    with pytest.raises(RelightlabError, match="two levels"):
        group_test([1, 0], ["a", "a"], [1, 2])
    with pytest.raises(RelightlabError, match="3 combinations of 2 methods and 2 groups"):
        interaction_test([1, 0, 1], ["a", "a", "b"], ["f", "m", "m"], [1, 2, 3])
