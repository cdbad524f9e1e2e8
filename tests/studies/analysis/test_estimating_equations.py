"""Estimating equations: geepack's numbers, and what has no solution."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from shading_model.errors import RelightlabError
from studies.analysis.estimating_equations import fit_estimating_equations
from tests.studies.analysis.oracle_files import r_answers, r_fits


@pytest.mark.parametrize(("index", "working"), [(0, "exchangeable"), (1, "independence")])
def test_fits_are_those_of_geepack(index: int, working: Any) -> None:
    """Estimates, robust errors and correlation agree with geeglm, whatever the order of rows."""
    table, oracle = r_answers(), r_fits()["geeglm"][index]
    table = table.sample(frac=1, random_state=1)
    columns = np.column_stack([np.ones(len(table)), table[oracle["terms"][1:]]])
    subject = table["subject"].to_numpy()
    fit = fit_estimating_equations(table["y"], columns, oracle["terms"], subject, working)
    np.testing.assert_allclose(fit.estimate, oracle["estimate"], atol=1e-6)
    np.testing.assert_allclose(fit.standard_error, oracle["se"], atol=1e-6)
    if working == "exchangeable":
        assert fit.correlation == pytest.approx(oracle["alpha"], abs=1e-6)
    else:
        assert fit.correlation is None
    assert (fit.trials, fit.subjects) == (len(table), 24)


def test_a_mean_is_the_log_odds_of_its_rate() -> None:
    """With the intercept alone and balanced subjects the estimate is a rate's log-odds."""
    outcome = np.array([1, 1, 0, 1, 0, 1, 0, 0, 1, 1])
    fit = fit_estimating_equations(outcome, np.ones((10, 1)), ["a"], np.repeat(range(5), 2))
    assert fit.estimate[0] == pytest.approx(np.log(0.6 / 0.4))


def test_answers_without_exception_have_no_solution() -> None:
    """A column whose answers are all alike is said to be without a finite estimate."""
    outcome = np.repeat([1.0, 0.0, 1.0, 1.0], 10)
    group = np.repeat([0.0, 0.0, 1.0, 1.0], 10)
    columns = np.column_stack([np.ones(40), group])
    with pytest.raises(RelightlabError, match="no finite solution"):
        fit_estimating_equations(outcome, columns, ["a", "b"], np.arange(40) // 4)
