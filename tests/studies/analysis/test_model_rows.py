"""Rows of models: names of terms as R has them."""

from __future__ import annotations

import numpy as np

from studies.analysis.bradley_terry import bradley_terry
from studies.analysis.estimating_equations import fit_estimating_equations
from studies.analysis.mixed_model import fit_mixed_model
from studies.analysis.model_rows import MODEL_COLUMNS, gee_rows, mixed_rows, strength_rows
from tests.studies.analysis.oracle_files import r_answers


def test_terms_are_named_as_in_r() -> None:
    """Effects, then deviations, likelihood, correlation and number of answers."""
    table = r_answers()
    ones, subject = np.ones((len(table), 1)), table["subject"].to_numpy()
    mixed = fit_mixed_model(table["y"], ones, ["(Intercept)"], {"subject": subject})
    rows = mixed_rows("m", mixed)
    assert [row["term"] for row in rows] == ["(Intercept)", "sd:subject", "logLik", "nobs"]
    assert tuple(rows[0]) == MODEL_COLUMNS
    assert rows[1]["se"] is None
    gee = fit_estimating_equations(table["y"], ones, ["(Intercept)"], subject)
    assert [row["term"] for row in gee_rows("g", gee)] == ["(Intercept)", "alpha", "nobs"]
    strengths = bradley_terry(table["won"], table["first"], table["second"], subject)
    assert {row["term"] for row in strength_rows("b", strengths)} == set("abcd")
