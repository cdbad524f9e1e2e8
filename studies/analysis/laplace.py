r"""Laplace's approximation to the likelihood of a crossed logistic model, with its exact gradient.

The log-odds of answer i are ``x_i \beta + sum_k \theta_k u_k[g_k(i)]`` with standard normal effects
u, one set for each factor k (subjects, items). For given :math:`(\theta, \beta)` the penalised
likelihood is maximised over u; the integral over u is replaced by that of the normal density with
the curvature H there. H is diagonal for the effects of the largest factor, which are eliminated
first, so that only a matrix of the size of the other factors is decomposed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.special import expit

from shading_model.arrays import Float

Codes = NDArray[np.intp]

NEWTON_STEPS = 60
SETTLED = 1e-13
"""Newton's decrement at which the effects are taken as found."""


@dataclass(frozen=True, eq=False)
class CrossedDesign:
    """Answers, fixed-effect columns and the factors with random intercepts, largest factor first.

    Parameters
    ----------
    outcome : (n,) array
        1 or 0; 0.5 is half an answer each way.
    columns : (n, p) array
    codes : tuple of (n,) integer arrays
        Level of each factor, from 0. At least one factor.
    sizes : tuple of int
        Number of levels of each factor.
    """

    outcome: Float
    columns: Float
    codes: tuple[Codes, ...]
    sizes: tuple[int, ...]


class Curvature(NamedTuple):
    """H in two blocks: the diagonal of the first factor, and the others' Schur complement."""

    diagonal: Float
    cross: Float
    lower: Float

    def solve(self, first: Float, rest: Float) -> tuple[Float, Float]:
        """Return H^{-1} of a vector given by its two blocks."""
        scaled = first / self.diagonal
        if not rest.size:
            return scaled, rest
        solved = cho_solve((self.lower, True), rest - self.cross.T @ scaled, check_finite=False)
        return scaled - (self.cross @ solved) / self.diagonal, solved

    def log_determinant(self) -> float:
        """Return log |H|."""
        schur = 2 * np.log(np.diag(self.lower)).sum()
        return float(np.log(self.diagonal).sum() + schur)


class LaplaceValue(NamedTuple):
    """Negative log-likelihood, its gradient in (theta, beta), and the effects u that belong to it.

    `spread` holds the standard deviations of the effects u, given theta and beta.
    """

    value: float
    gradient: Float
    effects: tuple[Float, ...]
    spread: tuple[Float, ...]


def laplace(
    design: CrossedDesign, theta: Float, beta: Float, start: tuple[Float, ...] | None = None
) -> LaplaceValue:
    """Return Laplace's negative log-likelihood and its gradient.

    Parameters
    ----------
    design : CrossedDesign
    theta : (k,) array
        Standard deviations of the random intercepts; 0 is allowed.
    beta : (p,) array
    start : tuple of (q_k,) arrays, optional
        Effects to begin the search for u with.

    Returns
    -------
    LaplaceValue

    Examples
    --------
    >>> design = CrossedDesign(np.array([1.0, 0.0, 1.0]), np.ones((3, 1)),
    ...                        (np.array([0, 0, 1]),), (2,))
    >>> round(float(laplace(design, np.zeros(1), np.zeros(1)).value / np.log(2)), 6)
    3.0
    """
    fixed = design.columns @ beta
    effects = start or tuple(np.zeros(size) for size in design.sizes)
    effects, log_odds = _best_effects(design, theta, fixed, effects)
    chance = expit(log_odds)
    curvature = _curvature(design, theta, chance * (1 - chance))
    value = _penalised(design.outcome, log_odds, effects) + curvature.log_determinant() / 2
    inverse = _inverse_blocks(curvature)
    gradient = _gradient(design, theta, effects, chance, curvature, inverse)
    return LaplaceValue(value, gradient, effects, _spread(design, inverse))


def _penalised(outcome: Float, log_odds: Float, effects: tuple[Float, ...]) -> float:
    likelihood = np.logaddexp(0, log_odds).sum() - outcome @ log_odds
    return float(likelihood + sum(u @ u for u in effects) / 2)


def _best_effects(
    design: CrossedDesign, theta: Float, fixed: Float, effects: tuple[Float, ...]
) -> tuple[tuple[Float, ...], Float]:
    """Newton's method for u, halving a step that does not descend."""
    log_odds = fixed + _contribution(design, theta, effects)
    value = _penalised(design.outcome, log_odds, effects)
    for _ in range(NEWTON_STEPS):
        chance = expit(log_odds)
        downhill = _downhill(design, theta, design.outcome - chance, effects)
        step = _split(design, _curvature(design, theta, chance * (1 - chance)).solve(*downhill))
        decrement = _joined(design, step, downhill)
        size = 1.0
        while True:
            trial = tuple(u + size * du for u, du in zip(effects, step, strict=True))
            trial_odds = fixed + _contribution(design, theta, trial)
            trial_value = _penalised(design.outcome, trial_odds, trial)
            if trial_value <= value + 1e-12 * abs(value) or size < 1e-9:
                break
            size /= 2
        effects, log_odds, value = trial, trial_odds, trial_value
        if decrement < SETTLED * max(1.0, abs(value)):
            break
    return effects, log_odds


def _contribution(design: CrossedDesign, theta: Float, effects: tuple[Float, ...]) -> Float:
    terms = zip(theta, effects, design.codes, strict=True)
    total: Float = np.sum([scale * u[codes] for scale, u, codes in terms], axis=0)
    return total


def _downhill(
    design: CrossedDesign, theta: Float, residual: Float, effects: tuple[Float, ...]
) -> tuple[Float, Float]:
    sums = _transposed(design, theta, residual)
    blocks = [total - u for total, u in zip(sums, effects, strict=True)]
    return blocks[0], _concatenated(blocks[1:])


def _transposed(design: CrossedDesign, theta: Float, values: Float) -> list[Float]:
    """A'v: sums over the levels of each factor, times its theta."""
    return [
        scale * np.bincount(codes, values, minlength=size)
        for scale, codes, size in zip(theta, design.codes, design.sizes, strict=True)
    ]


def _concatenated(blocks: list[Float]) -> Float:
    return np.concatenate(blocks) if blocks else np.zeros(0)


def _split(design: CrossedDesign, blocks: tuple[Float, Float]) -> tuple[Float, ...]:
    bounds = np.cumsum(design.sizes[1:])[:-1]
    rest = np.split(blocks[1], bounds) if len(design.sizes) > 1 else []
    return (blocks[0], *rest)


def _joined(design: CrossedDesign, step: tuple[Float, ...], downhill: tuple[Float, Float]) -> float:
    return float(sum(a @ b for a, b in zip(step, _split(design, downhill), strict=True)))


def _curvature(design: CrossedDesign, theta: Float, weight: Float) -> Curvature:
    sizes, codes = design.sizes, design.codes
    diagonal = 1 + theta[0] ** 2 * np.bincount(codes[0], weight, minlength=sizes[0])
    starts = np.concatenate([[0], np.cumsum(sizes[1:])]).astype(int)
    cross = np.empty((sizes[0], starts[-1]))
    rest = np.eye(starts[-1])
    for k in range(1, len(sizes)):
        here = slice(starts[k - 1], starts[k])
        cross[:, here] = theta[0] * theta[k] * _table(design, 0, k, weight)
        for other in range(1, k + 1):
            there = slice(starts[other - 1], starts[other])
            block = theta[k] * theta[other] * _table(design, k, other, weight)
            rest[here, there] += block
            if other != k:
                rest[there, here] += block.T
    schur = rest - cross.T @ (cross / diagonal[:, None])
    lower = cho_factor(schur, lower=True, check_finite=False)[0] if schur.size else schur
    return Curvature(diagonal, cross, lower)


def _table(design: CrossedDesign, row: int, column: int, weight: Float) -> Float:
    """Sums of the weights over the levels of two factors."""
    rows, columns = design.sizes[row], design.sizes[column]
    if row == column:
        return np.diag(np.bincount(design.codes[row], weight, minlength=rows))
    cell = design.codes[row] * columns + design.codes[column]
    counts = np.bincount(cell, weight, minlength=rows * columns)
    return np.asarray(counts, dtype=float).reshape(rows, columns)


def _inverse_blocks(curvature: Curvature) -> tuple[Float, Float, Float]:
    """H^{-1}: the diagonal of its first block, the block beside it, and the last block."""
    scaled = curvature.cross / curvature.diagonal[:, None]
    if not scaled.size:
        return 1 / curvature.diagonal, scaled, curvature.lower
    last = cho_solve((curvature.lower, True), np.eye(scaled.shape[1]), check_finite=False)
    beside = -scaled @ last
    return 1 / curvature.diagonal - (beside * scaled).sum(axis=1), beside, last


def _spread(design: CrossedDesign, inverse: tuple[Float, Float, Float]) -> tuple[Float, ...]:
    first, _, last = inverse
    return _split(design, (np.sqrt(first), np.sqrt(np.diag(last)) if last.size else np.zeros(0)))


def _gradient(
    design: CrossedDesign,
    theta: Float,
    effects: tuple[Float, ...],
    chance: Float,
    curvature: Curvature,
    inverse: tuple[Float, Float, Float],
) -> Float:
    """Differentiate through u as well: its own change moves the weights in H."""
    residual, weight = design.outcome - chance, chance * (1 - chance)
    rows = _inverse_rows(design, theta, inverse)
    leverage = np.sum([scale * row for scale, row in zip(theta, rows, strict=True)], axis=0)
    slope = weight * (1 - 2 * chance) * leverage
    sums = _transposed(design, theta, slope)
    moved = _split(design, curvature.solve(sums[0], _concatenated(sums[1:])))
    through = (slope - weight * _contribution(design, theta, moved)) / 2
    net = through - residual
    of_theta = [
        net @ u[codes] + weight @ row + (residual @ shift[codes]) / 2
        for u, codes, row, shift in zip(effects, design.codes, rows, moved, strict=True)
    ]
    return np.concatenate([of_theta, design.columns.T @ net])


def _inverse_rows(
    design: CrossedDesign, theta: Float, inverse: tuple[Float, Float, Float]
) -> list[Float]:
    """For each factor k: sum over factors l of theta_l times H^{-1} between the levels of a row."""
    first, beside, last = inverse
    starts = np.concatenate([[0], np.cumsum(design.sizes[1:])]).astype(int)
    places = [codes + start for codes, start in zip(design.codes[1:], starts, strict=False)]
    head = design.codes[0]
    of_first = theta[0] * first[head]
    of_rest = []
    for scale, place in zip(theta[1:], places, strict=True):
        between = beside[head, place]
        of_first = of_first + scale * between
        others = [s * last[place, p] for s, p in zip(theta[1:], places, strict=True)]
        of_rest.append(theta[0] * between + np.sum(others, axis=0))
    return [of_first, *of_rest]
