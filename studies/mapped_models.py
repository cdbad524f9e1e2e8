"""The models that a mapping plans, fitted to the choices of its file."""

from __future__ import annotations

from collections.abc import Iterator

from studies.analysis.estimating_equations import Working, fit_estimating_equations
from studies.analysis.mixed_model import fit_mixed_model
from studies.analysis.model_rows import gee_rows, mixed_rows
from studies.analysis.rates import Row
from studies.mapped_trials import MappedTrials
from studies.model_formula import ModelFormula, design_of, parse_formula
from studies.trial_mapping import PlannedModel, TrialMapping

MIXED, INDEPENDENCE = "mixed", "gee-independence"


def model_rows(trials: MappedTrials, mapping: TrialMapping) -> Iterator[Row]:
    """Yield the terms of all models of a mapping.

    Parameters
    ----------
    trials : MappedTrials
    mapping : TrialMapping

    Yields
    ------
    dict
        ``model, term, estimate, se``, see `studies.analysis.model_rows`.

    Raises
    ------
    RelightlabError
        If a formula cannot be read, or a model cannot be fitted.
    """
    for planned in mapping.models:
        yield from _fitted(planned, parse_formula(planned.formula), trials)


def _fitted(planned: PlannedModel, formula: ModelFormula, trials: MappedTrials) -> list[Row]:
    frame = trials.frame
    matrix, terms = design_of(formula, frame)
    outcome = frame[formula.outcome].astype(float)
    if planned.kind == MIXED:
        factors = {name: frame[name] for name in formula.factors}
        return mixed_rows(planned.name, fit_mixed_model(outcome, matrix, terms, factors))
    working: Working = "independence" if planned.kind == INDEPENDENCE else "exchangeable"
    subject = trials.trials["subject"]
    fit = fit_estimating_equations(outcome, matrix, terms, subject, working)
    return gee_rows(planned.name, fit)
