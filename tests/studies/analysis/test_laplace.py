"""The Laplace approximation: against dense algebra, its gradient against finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.special import expit

from studies.analysis.laplace import CrossedDesign, laplace


def design(factors: int, seed: int = 0) -> CrossedDesign:
    """Return answers with one, two or three crossed factors, ties among them."""
    rng = np.random.default_rng(seed)
    sizes = (7, 4, 3)[:factors]
    codes = tuple(rng.permutation(np.arange(60) % size) for size in sizes)
    columns = np.column_stack([np.ones(60), rng.normal(size=60)])
    return CrossedDesign(rng.choice([0, 0.5, 1], 60), columns, codes, sizes)


def dense_value(one: CrossedDesign, theta: np.ndarray, beta: np.ndarray) -> float:
    """Return the same by a plain optimiser and a dense determinant."""
    loading = np.hstack(
        [
            scale * np.eye(size)[codes]
            for scale, codes, size in zip(theta, one.codes, one.sizes, strict=True)
        ]
    )

    def penalised(effects: np.ndarray) -> float:
        odds = one.columns @ beta + loading @ effects
        return float(np.logaddexp(0, odds).sum() - one.outcome @ odds + effects @ effects / 2)

    found = minimize(penalised, np.zeros(loading.shape[1]), options={"gtol": 1e-9})
    chance = expit(one.columns @ beta + loading @ found.x)
    curvature = loading.T @ (loading * (chance * (1 - chance))[:, None]) + np.eye(len(found.x))
    return float(found.fun + np.linalg.slogdet(curvature)[1] / 2)


@pytest.mark.parametrize("factors", [1, 2, 3])
def test_value_is_that_of_dense_algebra(factors: int) -> None:
    """Eliminating the largest factor changes nothing."""
    theta, beta = np.array([0.8, 1.3, 0.4])[:factors], np.array([0.3, -0.7])
    one = design(factors)
    assert laplace(one, theta, beta).value == pytest.approx(dense_value(one, theta, beta), abs=1e-6)


@pytest.mark.parametrize("factors", [1, 2, 3])
@pytest.mark.parametrize("first", [0.0, 0.9])
def test_gradient_is_that_of_differences(factors: int, first: float) -> None:
    """The gradient agrees with central differences, also where a deviation is zero."""
    one = design(factors, seed=3)
    point = np.concatenate([np.array([first, 1.1, 0.5])[:factors], [0.2, 0.6]])

    def value(x: np.ndarray) -> float:
        return laplace(one, x[:factors], x[factors:]).value

    steps = 1e-5 * np.eye(len(point))
    differences = [(value(point + step) - value(point - step)) / 2e-5 for step in steps]
    gradient = laplace(one, point[:factors], point[factors:]).gradient
    np.testing.assert_allclose(gradient, differences, atol=1e-6)


def test_without_random_effects_it_is_the_logistic_likelihood() -> None:
    """With deviations of zero the value is the binomial log-likelihood."""
    one, beta = design(2), np.array([0.4, 0.1])
    odds = one.columns @ beta
    plain = np.logaddexp(0, odds).sum() - one.outcome @ odds
    assert laplace(one, np.zeros(2), beta).value == pytest.approx(plain)


def test_where_the_search_begins_does_not_matter() -> None:
    """Starting from far-off effects leads to the same value."""
    one, theta, beta = design(2), np.array([1.5, 0.7]), np.array([0.1, -0.2])
    far = tuple(np.full(size, 9.0) for size in one.sizes)
    first, second = laplace(one, theta, beta), laplace(one, theta, beta, far)
    assert second.value == pytest.approx(first.value, abs=1e-9)
    np.testing.assert_allclose(second.spread[0], first.spread[0], rtol=1e-5)
