"""Joint means of cells: paired and unpaired comparisons."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import ttest_ind, ttest_rel

from shading_model.errors import RelightlabError
from studies.analysis.cell_means import cell_means, labelled, paired_difference
from tests.studies.analysis.made_answers import answer_grid
from tests.studies.analysis.oracle_files import r_answers, r_fits


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
    outcome, subject = answer_grid()
    method = np.tile(["a", "b"], len(outcome) // 2)
    found = paired_difference(outcome, method, subject, ("a", "b"))
    own = [[outcome[(subject == s) & (method == m)].mean() for s in range(12)] for m in "ab"]
    expected = ttest_rel(*own)
    assert found.p == pytest.approx(expected.pvalue)
    assert found[1:3] == pytest.approx(expected.confidence_interval(0.95))


def test_groups_of_subjects_have_the_standard_error_of_welch() -> None:
    """Two groups of subjects differ with Welch's standard error, on the freedom of the smaller."""
    outcome, subject = answer_grid()
    group = np.where(subject < 4, "few", "many")
    found = paired_difference(outcome, group, subject, ("few", "many"))
    rates = np.array([outcome[subject == s].mean() for s in range(12)])
    expected = ttest_ind(rates[:4], rates[4:], equal_var=False)
    assert found.difference / found.standard_error == pytest.approx(expected.statistic)
    assert found.subjects == 4
    assert found.p > expected.pvalue


def test_a_cell_of_one_subject_cannot_be_tested() -> None:
    """The spread of a group that has one subject is not taken for zero."""
    outcome, subject = answer_grid()
    found = paired_difference(outcome, subject == 0, subject, (True, False))
    assert np.isnan(found.p)


def test_comparing_nothing_is_refused() -> None:
    """A method without answers and a single subject are said."""
    with pytest.raises(RelightlabError, match="no answers on 'c'"):
        paired_difference([1, 0], ["a", "b"], [1, 2], ("a", "c"))
    with pytest.raises(RelightlabError, match="two subjects or more, got 1"):
        cell_means([1, 0], ["a", "b"], [1, 1])
