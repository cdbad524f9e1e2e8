"""Equivalence to chance, tests against chance and Holm's correction."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import ttest_1samp
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.weightstats import DescrStatsW

from shading_model.errors import RelightlabError
from studies.analysis.equivalence import chance_test, equivalence_test, holm


def answers(subjects: int = 40, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return outcomes, subjects and items."""
    rng = np.random.default_rng(seed)
    chance = rng.uniform(0.3, 0.7, subjects)
    subject = np.repeat(np.arange(subjects), 10)
    outcome = (rng.random(10 * subjects) < chance[subject]).astype(float)
    return outcome, subject, np.tile(np.arange(10), subjects)


def test_equivalence_is_two_t_tests_of_subjects() -> None:
    """For balanced answers it is the two one-sided t tests of the subjects' rates."""
    outcome, subject, _ = answers()
    rates = outcome.reshape(40, 10).mean(axis=1)
    expected = DescrStatsW(rates).ttost_mean(0.42, 0.58)[0]
    found = equivalence_test(outcome, subject, margin=0.08)
    assert found.p == pytest.approx(expected)
    assert chance_test(outcome, subject) == pytest.approx(ttest_1samp(rates, 0.5).pvalue)


@given(st.integers(0, 30), st.floats(0.01, 0.3))
def test_equivalent_where_the_interval_is_within(seed: int, margin: float) -> None:
    """The verdict and the interval of 90 % say the same."""
    found = equivalence_test(*answers(12, seed)[:2], margin=margin)
    within = 0.5 - margin < found.low and found.high < 0.5 + margin
    assert found.equivalent == within


def test_items_make_equivalence_harder() -> None:
    """With items drawn as well, p is not smaller."""
    outcome, subject, item = answers()
    assert equivalence_test(outcome, subject, item, margin=0.08).p >= (
        equivalence_test(outcome, subject, margin=0.08).p
    )


def test_nothing_is_equivalent_without_spread() -> None:
    """One subject, or subjects who all answer alike, show no equivalence."""
    for subject in (np.zeros(4), np.arange(4) // 2):
        assert not equivalence_test([1, 0, 1, 0], subject, margin=0.1).equivalent
        assert np.isnan(chance_test([1, 0, 1, 0], subject))


@pytest.mark.parametrize("margin", [0.0, 0.5, -1.0])
def test_margins_are_sensible(margin: float) -> None:
    """A margin of nothing or of everything is refused."""
    with pytest.raises(RelightlabError, match="expected an equivalence margin"):
        equivalence_test([1, 0], [1, 2], margin=margin)


def test_holm_agrees_with_statsmodels() -> None:
    """The correction is statsmodels' own, for small and large p-values and equal ones."""
    values = [0.004, 0.9, 0.004, 0.03, 0.0, 1.0, 0.2, 0.011]
    assert holm(values) == pytest.approx(multipletests(values, method="holm")[1], abs=1e-12)


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12))
def test_holm_only_raises_and_keeps_the_order(values: list[float]) -> None:
    """No p-value falls, the smallest is multiplied by their number, and order is kept."""
    corrected = holm(values)
    assert min(corrected) == pytest.approx(min(1.0, len(values) * min(values)))
    assert all(after >= before for before, after in zip(values, corrected, strict=True))
    order = np.argsort(values, kind="stable")
    assert (np.diff(np.array(corrected)[order]) >= 0).all()


def test_holm_of_nothing() -> None:
    """An empty family stays empty, and values not known do not count."""
    assert holm([]) == []
    assert holm([0.02, np.nan])[0] == 0.02
