"""Strengths of several methods: R's fit, closed forms, and methods that never meet."""

from __future__ import annotations

import math

import numpy as np
import pytest

from shading_model.errors import RelightlabError
from studies.analysis.bradley_terry import bradley_terry
from tests.studies.analysis.oracle_files import r_answers, r_fits


def test_strengths_and_errors_are_those_of_r() -> None:
    """Differences to one method and their covariance agree with glm and vcovCL.

    As far as R's glm iterates: until its deviance changes by less than 1e-8.
    """
    table, oracle = r_answers(), r_fits()["bradley_terry"]
    fit = bradley_terry(table["won"], table["first"], table["second"], table["subject"].to_numpy())
    places = [fit.methods.index(name) for name in "abcd"]
    strength = fit.strength[places]
    contrast = np.hstack([-np.ones((3, 1)), np.eye(3)])
    covariance = contrast @ fit.covariance[np.ix_(places, places)] @ contrast.T
    np.testing.assert_allclose(contrast @ strength, oracle["against_a"], atol=1e-8)
    np.testing.assert_allclose(covariance, oracle["covariance"], rtol=3e-5)
    assert list(fit.strength) == sorted(fit.strength, reverse=True)


def test_two_methods_have_the_log_odds_of_their_rate() -> None:
    """With two methods the difference of strengths is the log-odds of one's rate."""
    outcome = [1, 1, 1, 0, 1, 0.5, 0, 1]
    fit = bradley_terry(outcome, ["a"] * 8, ["b"] * 8, np.repeat(np.arange(4), 2))
    rate = float(np.mean(outcome))
    assert fit.strength[0] - fit.strength[1] == pytest.approx(math.log(rate / (1 - rate)))
    assert fit.chance("a", "b") == pytest.approx(rate)
    assert (fit.low < fit.strength).all()


def test_sides_of_a_pair_do_not_matter() -> None:
    """Which method is named first changes nothing if the outcome is turned as well."""
    table = r_answers()
    names = [table[name].to_list() for name in ("first", "second")]
    subject = table["subject"].to_numpy()
    fit = bradley_terry(table["won"], *names, subject)
    turned = bradley_terry(1 - table["won"], *reversed(names), subject)
    assert turned.methods == fit.methods
    np.testing.assert_allclose(turned.strength, fit.strength, atol=1e-9)


@pytest.mark.parametrize(
    ("outcome", "first", "second", "subject", "sentence"),
    [
        ([1, 0, 1, 0], "aabb", "bbaa", [1, 1, 1, 1], "two subjects and two methods"),
        ([1, 0], "aa", "ab", [1, 2], "'a' is compared with itself"),
        ([1, 0, 1, 0], "aacc", "bbdd", [1, 2, 1, 2], "'a' and 'c' cannot be compared"),
        ([1, 1, 1], "aaa", "bbb", [1, 2, 3], "'a' and 'b' cannot be compared"),
    ],
)
def test_methods_that_cannot_be_compared(
    outcome: list[float], first: str, second: str, subject: list[int], sentence: str
) -> None:
    """Methods that never meet, or of which one always wins, are named."""
    with pytest.raises(RelightlabError, match=sentence):
        bradley_terry(outcome, list(first), list(second), subject)
