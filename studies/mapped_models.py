"""The models that a mapping plans, fitted to the choices of its file."""

from __future__ import annotations

from collections.abc import Iterator

from shading_model.arrays import Float
from studies.analysis.estimating_equations import Working, fit_estimating_equations
from studies.analysis.mixed_model import fit_mixed_model
from studies.mapped_trials import MappedTrials
from studies.model_formula import ModelFormula, design_of, parse_formula
from studies.trial_mapping import TrialMapping

MIXED, INDEPENDENCE = "mixed", "gee-independence"


def model_rows(
    trials: MappedTrials, mapping: TrialMapping
) -> Iterator[dict[str, str | float | None]]:
    """Yield the terms of all models of a mapping.

    Parameters
    ----------
    trials : MappedTrials
    mapping : TrialMapping

    Yields
    ------
    dict
        ``model, term, estimate, se``. After the coefficients, in log-odds, come without standard
        errors what R prints besides: ``sd:column``, ``logLik``, ``nobs``, ``alpha``.

    Raises
    ------
    RelightlabError
        If a formula cannot be read, or a model cannot be fitted.
    """
    for planned in mapping.models:
        formula = parse_formula(planned.formula)
        terms, estimates, errors, extras = _fitted(planned.kind, formula, trials)
        for term, estimate, error in zip(terms, estimates, errors, strict=True):
            yield _row(planned.name, term, float(estimate), float(error))
        for term, value in extras.items():
            yield _row(planned.name, term, value, None)


def _row(model: str, term: str, estimate: float, se: float | None) -> dict[str, str | float | None]:
    return {"model": model, "term": term, "estimate": estimate, "se": se}


def _fitted(
    kind: str, formula: ModelFormula, trials: MappedTrials
) -> tuple[tuple[str, ...], Float, Float, dict[str, float]]:
    """Fit a model; return terms, estimates, standard errors, and what R prints besides.

    That is, under R's names, the standard deviation of each random intercept (``sd:column``),
    ``logLik`` and ``nobs`` of a mixed model; ``alpha``, the correlation of a subject's answers, of
    a GEE that estimates it.
    """
    frame = trials.frame
    matrix, terms = design_of(formula, frame)
    outcome = frame[formula.outcome].astype(float)
    if kind == MIXED:
        mixed = fit_mixed_model(
            outcome, matrix, terms, {name: frame[name] for name in formula.factors}
        )
        extras = {f"sd:{name}": float(value) for name, value in mixed.deviations.items()}
        extras |= {"logLik": mixed.log_likelihood, "nobs": float(len(outcome))}
        return mixed.terms, mixed.estimate, mixed.standard_error, extras
    working: Working = "independence" if kind == INDEPENDENCE else "exchangeable"
    averaged = fit_estimating_equations(outcome, matrix, terms, trials.trials["subject"], working)
    alpha = {} if averaged.correlation is None else {"alpha": averaged.correlation}
    return averaged.terms, averaged.estimate, averaged.standard_error, alpha
