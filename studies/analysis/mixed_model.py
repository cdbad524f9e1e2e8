"""The crossed logistic mixed model, fitted by Laplace's approximation.

Subjects and items are both drawn from larger populations; the model gives each its own intercept.
Estimates maximise the likelihood over the standard deviations of the intercepts and the fixed
effects together, and standard errors come from its curvature there, as lme4's ``glmer`` has them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.optimize import Bounds, minimize
from scipy.special import expit
from scipy.stats import chi2

from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from studies.analysis.laplace import CrossedDesign, LaplaceValue, laplace
from studies.analysis.model_inputs import (
    LARGEST_LOG_ODDS,
    check_answers,
    check_columns,
    triangular_factor,
)

DIFFERENCE = 1e-4
"""Step at which the gradient is differenced for the curvature."""
SINGULAR = 1e-3
"""A standard deviation below this is tried at zero."""
ESCAPE = 0.1
"""Where a deviation goes on from that came out as zero though this one is likelier."""


@dataclass(frozen=True, eq=False)
class MixedFit:
    """A fitted crossed logistic model.

    Parameters
    ----------
    terms : tuple of str
        Names of the fixed effects.
    estimate, standard_error : (p,) arrays
        In log-odds.
    covariance : (p, p) array
    deviations : dict
        Standard deviation of the random intercepts of each factor; 0 where the fit is singular.
    intercepts : dict of Series
        The mode of each level's intercept, in log-odds.
    log_likelihood : float
        Laplace's approximation.
    trials : int
    parameters : int
        Fixed effects and standard deviations.
    converged : bool
    """

    terms: tuple[str, ...]
    estimate: Float
    standard_error: Float
    covariance: Float
    deviations: dict[str, float]
    intercepts: dict[str, pd.Series]
    log_likelihood: float
    trials: int
    parameters: int
    converged: bool


def fit_mixed_model(
    outcome: ArrayLike, columns: ArrayLike, terms: Sequence[str], factors: Mapping[str, ArrayLike]
) -> MixedFit:
    """Fit a logistic model with random intercepts for one factor or several.

    Parameters
    ----------
    outcome : (n,) array
        1 or 0; a tie of 0.5 counts as half an answer each way.
    columns : (n, p) array
        Fixed effects, the intercept among them. No NaN.
    terms : sequence of str
        Names of the columns.
    factors : mapping of str to (n,) arrays
        Labels of the levels: ``{"subject": ..., "item": ...}``.

    Returns
    -------
    MixedFit

    Raises
    ------
    RelightlabError
        If there is no factor or answer, an outcome is not within 0 and 1, a column repeats others
        (named), or the answers leave an effect without a finite estimate.

    Examples
    --------
    >>> rng = np.random.default_rng(3)
    >>> subject = np.repeat(np.arange(40), 20)
    >>> chance = expit(0.5 + rng.normal(size=40)[subject])
    >>> fit = fit_mixed_model(rng.random(800) < chance, np.ones((800, 1)), ["(Intercept)"],
    ...                       {"subject": subject})
    >>> fit.terms, fit.trials, fit.deviations["subject"] > 0.5
    (('(Intercept)',), 800, True)
    """
    answers = np.asarray(outcome, dtype=float)
    matrix = np.asarray(columns, dtype=float)
    check_answers(answers)
    check_columns(matrix, terms)
    if not factors:
        raise RelightlabError("expected a factor with random intercepts, such as (1|subject)")
    names, design, labels = _ordered_design(answers, matrix, factors)
    transform = _whitening(matrix)
    white = CrossedDesign(answers, matrix @ transform, design.codes, design.sizes)
    point, best, converged = _optimum(white)
    covariance = _covariance(white, point, best, transform)
    count = len(names)
    deviations = dict(zip(names, point[:count].tolist(), strict=True))
    intercepts = {
        name: pd.Series(deviations[name] * u, index=levels, name=name)
        for name, u, levels in zip(names, best.effects, labels, strict=True)
    }
    return MixedFit(
        terms=tuple(terms),
        estimate=transform @ point[count:],
        standard_error=np.sqrt(np.diag(covariance)),
        covariance=covariance,
        deviations={name: deviations[name] for name in factors},
        intercepts={name: intercepts[name] for name in factors},
        log_likelihood=-best.value,
        trials=len(answers),
        parameters=len(point),
        converged=converged,
    )


def likelihood_ratio(full: MixedFit, reduced: MixedFit) -> tuple[float, int, float]:
    """Return twice the difference of log-likelihoods of nested fits, its freedom, and p.

    Parameters
    ----------
    full, reduced : MixedFit
        To the same answers; the terms of `reduced` are among those of `full`.

    Returns
    -------
    statistic : float
    freedom : int
    p : float
        Of a chi-squared variable.

    Raises
    ------
    RelightlabError
        If the fits are not of the same answers, or `full` has no more parameters.
    """
    freedom = full.parameters - reduced.parameters
    if full.trials != reduced.trials or freedom < 1:
        raise RelightlabError(
            f"expected a model of more parameters fitted to the same answers, got"
            f" {full.parameters} parameters on {full.trials} answers against"
            f" {reduced.parameters} on {reduced.trials}"
        )
    statistic = max(0.0, 2 * (full.log_likelihood - reduced.log_likelihood))
    return statistic, freedom, float(chi2.sf(statistic, freedom))


def _ordered_design(
    answers: Float, matrix: Float, factors: Mapping[str, ArrayLike]
) -> tuple[list[str], CrossedDesign, list[pd.Index]]:
    """The factor with most levels first: it is eliminated without a decomposition."""
    coded = {name: pd.factorize(np.asarray(labels)) for name, labels in factors.items()}
    names = sorted(coded, key=lambda name: -len(coded[name][1]))
    codes = tuple(np.asarray(coded[name][0], dtype=np.intp) for name in names)
    sizes = tuple(len(coded[name][1]) for name in names)
    if any((code < 0).any() for code in codes):
        raise RelightlabError(f"expected a label of {' and '.join(names)} in every row")
    labels = [pd.Index(coded[name][1]) for name in names]
    return names, CrossedDesign(answers, matrix, codes, sizes), labels


def _whitening(matrix: Float) -> Float:
    """The transform that makes the columns orthogonal with mean square 1."""
    return np.asarray(np.linalg.inv(triangular_factor(matrix)) * np.sqrt(len(matrix)))


def _optimum(design: CrossedDesign) -> tuple[Float, LaplaceValue, bool]:
    count = len(design.sizes)
    effects: list[tuple[Float, ...]] = []

    def at(point: Float) -> tuple[float, Float]:
        found = laplace(design, point[:count], point[count:], effects[-1] if effects else None)
        effects[:] = [found.effects]
        return found.value, found.gradient

    def descend(begin: Float) -> Float:
        lowest = np.concatenate([np.zeros(count), np.full(design.columns.shape[1], -np.inf)])
        found = minimize(
            at,
            begin,
            jac=True,
            method="L-BFGS-B",
            bounds=Bounds(lowest, np.full(len(begin), np.inf)),
            options={"maxiter": 500, "ftol": 1e-13, "gtol": 1e-9 * len(design.outcome)},
        )
        return np.asarray(found.x, dtype=float)

    point = descend(np.concatenate([np.ones(count), _plain_logistic(design)]))
    # The likelihood is even in each deviation: a step that lands on 0 finds no slope to leave by.
    for _ in range(count):
        value = at(point)[0]
        inner = [k for k in range(count) if point[k] < SINGULAR and _falls(at, point, k, value)]
        if not inner:
            break
        point[inner] = ESCAPE
        point = descend(point)
    _check_finite(design, point[count:])
    point = _without_singular(design, point, effects[-1])
    best = laplace(design, point[:count], point[count:], effects[-1])
    slope = np.where((point > 0) | (np.arange(len(point)) >= count), best.gradient, 0)
    return point, best, bool(np.abs(slope).max() < 1e-3 * max(1.0, len(design.outcome) / 1000))


def _falls(at: Callable[[Float], tuple[float, Float]], point: Float, k: int, value: float) -> bool:
    """Whether a small deviation is likelier than none."""
    moved = point.copy()
    moved[k] = ESCAPE
    return at(moved)[0] < value


def _without_singular(design: CrossedDesign, point: Float, start: tuple[Float, ...]) -> Float:
    """Set a standard deviation that is nearly 0 to 0 where that is as likely."""
    count = len(design.sizes)
    for k in np.flatnonzero(point[:count] < SINGULAR):
        trial = point.copy()
        trial[k] = 0.0
        values = [laplace(design, x[:count], x[count:], start).value for x in (trial, point)]
        point = trial if values[0] <= values[1] + 1e-6 else point
    return point


def _plain_logistic(design: CrossedDesign) -> Float:
    """A few steps of the logistic regression without random intercepts, to begin with."""
    beta = np.zeros(design.columns.shape[1])
    for _ in range(8):
        chance = np.clip(expit(design.columns @ beta), 1e-6, 1 - 1e-6)
        weighted = design.columns * (chance * (1 - chance))[:, None]
        slope = design.columns.T @ (design.outcome - chance)
        beta = beta + np.linalg.solve(design.columns.T @ weighted, slope)
        if np.abs(slope).max() < 1e-6 or np.abs(design.columns @ beta).max() > LARGEST_LOG_ODDS:
            break
    fixed = np.abs(design.columns @ beta).max()
    return beta if fixed <= LARGEST_LOG_ODDS else beta * 3.0 / fixed


def _check_finite(design: CrossedDesign, beta: Float) -> None:
    if np.abs(design.columns @ beta).max() > LARGEST_LOG_ODDS:
        raise RelightlabError(
            "the answers leave an effect without a finite estimate: for some values of the terms"
            " all are alike; leave a term out, or join levels"
        )


def _covariance(design: CrossedDesign, point: Float, best: LaplaceValue, transform: Float) -> Float:
    """Invert the curvature over all parameters off the boundary; keep the fixed effects' part."""
    count = len(design.sizes)
    free = np.flatnonzero((point > 0) | (np.arange(len(point)) >= count))
    rows = []
    for index in free:
        sides = []
        for sign in (1.0, -1.0):
            moved = point.copy()
            moved[index] += sign * DIFFERENCE
            sides.append(laplace(design, moved[:count], moved[count:], best.effects).gradient[free])
        rows.append((sides[0] - sides[1]) / (2 * DIFFERENCE))
    curvature = (np.array(rows) + np.array(rows).T) / 2
    fixed = int((free < count).sum())
    white = np.linalg.inv(curvature)[fixed:, fixed:]
    if not (np.diag(white) > 0).all():
        raise RelightlabError(
            "the likelihood has no maximum that a standard error could be taken at: the answers are"
            " too few for this model"
        )
    return transform @ white @ transform.T
