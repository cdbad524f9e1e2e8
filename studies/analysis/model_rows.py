"""Fitted models as rows ``model, term, estimate, se``, with R's names of terms."""

from __future__ import annotations

from shading_model.arrays import Float
from studies.analysis.bradley_terry import Strengths
from studies.analysis.estimating_equations import EstimatingFit
from studies.analysis.mixed_model import MixedFit
from studies.analysis.rates import Row, plain

MODEL_COLUMNS = ("model", "term", "estimate", "se")


def mixed_rows(model: str, fit: MixedFit) -> list[Row]:
    """Return the rows of a mixed model: effects, deviations ``sd:``, ``logLik`` and ``nobs``.

    Parameters
    ----------
    model : str
        What the rows are called.
    fit : MixedFit

    Returns
    -------
    list of dict
        ``se`` is None where there is none.
    """
    return [
        *_effects(model, fit.terms, fit.estimate, fit.standard_error),
        *(_row(model, f"sd:{name}", value) for name, value in fit.deviations.items()),
        _row(model, "logLik", fit.log_likelihood),
        _row(model, "nobs", fit.trials),
    ]


def gee_rows(model: str, fit: EstimatingFit) -> list[Row]:
    """Return the rows of estimating equations: effects, ``alpha`` (correlation) and ``nobs``.

    Parameters
    ----------
    model : str
    fit : EstimatingFit

    Returns
    -------
    list of dict
    """
    correlation = [] if fit.correlation is None else [_row(model, "alpha", fit.correlation)]
    effects = _effects(model, fit.terms, fit.estimate, fit.standard_error)
    return [*effects, *correlation, _row(model, "nobs", fit.trials)]


def strength_rows(model: str, fit: Strengths) -> list[Row]:
    """Return the rows of Bradley and Terry's model: the strength of each method.

    Parameters
    ----------
    model : str
    fit : Strengths

    Returns
    -------
    list of dict
    """
    return _effects(model, fit.methods, fit.strength, fit.standard_error)


def _effects(model: str, terms: tuple[str, ...], estimate: Float, error: Float) -> list[Row]:
    triples = zip(terms, estimate.tolist(), error.tolist(), strict=True)
    return [_row(model, term, value, se) for term, value, se in triples]


def _row(model: str, term: str, estimate: float, se: float | None = None) -> Row:
    return plain({"model": model, "term": term, "estimate": estimate, "se": se})
