"""Tests of studies.analysis.mixed_model where deviations are small: no fit is left at zero."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import expit

from shading_model.seeds import generator_for
from studies.analysis.mixed_model import fit_mixed_model


@pytest.mark.parametrize("number", range(8))
def test_more_terms_are_never_less_likely(number: int) -> None:
    """A model with a term more fits at least as well, however small the deviations are."""
    generator = generator_for("nested mixed models", number)
    subject, item = (places.ravel() for places in np.indices((46, 10)))
    effects = 0.35 * generator.standard_normal(46)[subject]
    effects = effects + 0.2 * generator.standard_normal(10)[item]
    outcome = generator.random(len(subject)) < expit(effects)
    factors = {"subject": subject, "item": item}
    side = generator.permutation(np.resize([0.5, -0.5], len(subject)))
    one = np.ones(len(subject))
    plain = fit_mixed_model(outcome, one[:, None], ("(Intercept)",), factors)
    full = fit_mixed_model(outcome, np.column_stack([one, side]), ("(Intercept)", "side"), factors)
    assert full.log_likelihood >= plain.log_likelihood - 1e-6
