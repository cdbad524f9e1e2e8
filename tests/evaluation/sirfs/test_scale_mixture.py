"""Gaussian scale mixtures: closed forms, what their fit finds, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal, norm

from evaluation.sirfs.scale_mixture import ScaleMixture, fit_scale_mixture, inverse_root
from shading_model.arrays import Float
from shading_model.errors import RelightlabError

SHAPE = np.array([[1.0, 0.6, 0.2], [0.6, 2.0, 0.5], [0.2, 0.5, 1.0]])
SHAPE = SHAPE / np.cbrt(np.linalg.det(SHAPE))
MIXED = ScaleMixture(np.array([0.7, 0.3]), np.array([0.1, 2.0]), 5.0)
MIXED_COLOR = ScaleMixture(np.array([0.7, 0.3]), np.array([0.1, 2.0]), 9.0, SHAPE)


def mean_log_density(mixture: ScaleMixture, samples: Float) -> float:
    """How likely samples are to a mixture, on average."""
    columns = samples.reshape(len(samples), -1)
    half = 0.5 * ((columns @ mixture.precision_root) ** 2).sum(axis=1)
    return float(mixture.log_density(half).mean())


@given(st.floats(0.01, 100.0), st.floats(-300.0, 300.0))
def test_one_scale_is_a_gaussian(scale: float, value: float) -> None:
    """The cost of a number is then half its squared distance from zero, in scales."""
    mixture = ScaleMixture(np.ones(1), np.array([scale]), 1.0)
    assert np.isclose(mixture.cost(np.array(value)), 0.5 * (value / scale) ** 2, atol=1e-12)
    found = mixture.log_density(np.array(0.5 * value**2))
    assert np.isclose(found, norm.logpdf(value, scale=scale), atol=1e-9)


def test_two_scales_are_the_sum_of_their_densities() -> None:
    """Far from under- and overflow, the density is the plain sum."""
    x = np.linspace(-3, 3, 61)
    plain = 0.7 * norm.pdf(x, scale=0.1) + 0.3 * norm.pdf(x, scale=2.0)
    middle = 0.7 * norm.pdf(0, scale=0.1) + 0.3 * norm.pdf(0, scale=2.0)
    assert np.allclose(MIXED.cost(x), np.log(middle) - np.log(plain), atol=1e-12)


def test_colors_have_the_density_of_three_variables() -> None:
    """Half squared lengths under the precision root give the three-variate mixture."""
    x = np.random.default_rng(0).normal(size=(50, 3))
    half = 0.5 * ((x @ MIXED_COLOR.precision_root) ** 2).sum(axis=1)
    plain = sum(
        weight * multivariate_normal(np.zeros(3), scale**2 * SHAPE).pdf(x)
        for weight, scale in ((0.7, 0.1), (0.3, 2.0))
    )
    assert np.allclose(MIXED_COLOR.log_density(half), np.log(plain), atol=1e-10)


@pytest.mark.parametrize("mixture", [MIXED, MIXED_COLOR])
@given(st.floats(0.0, 1e8), st.floats(0.0, 1e8))
def test_cost_rises_from_zero(mixture: ScaleMixture, one: float, other: float) -> None:
    """However far out, it is finite, and farther costs no less."""
    near, far = mixture.cost(np.array(sorted([one, other])))
    assert mixture.cost(np.array(0.0)) == 0.0
    assert 0 <= near <= far < np.inf


def test_tables_end_where_the_training_data_did() -> None:
    """Of numbers they are symmetric, of colours they start at zero."""
    table, color = MIXED.cost_table(101), MIXED_COLOR.cost_table(101)
    places = table.start + table.spacing * np.arange(101)
    assert np.allclose(places[[0, 50, -1]], [-5, 0, 5])
    assert np.allclose(table.values, MIXED.cost(places))
    assert np.allclose(table.values, table.values[::-1])
    assert (color.start, color.spacing) == (0.0, 0.09)
    assert np.allclose(color.values, MIXED_COLOR.cost(0.09 * np.arange(101)))
    assert MIXED.cost_table().values.size == 20_000
    assert MIXED_COLOR.cost_table().values.size == 100_000


@pytest.mark.parametrize("columns", [1, 3])
def test_every_round_is_likelier(columns: int) -> None:
    """Expectation and maximisation never lose, over steps of the shape either."""
    generator = np.random.default_rng(1)
    samples = generator.standard_t(2, size=(3000, columns)) @ np.eye(columns)
    if columns == 3:
        samples = samples @ np.linalg.cholesky(SHAPE).T
    given_samples = samples[:, 0] if columns == 1 else samples
    rounds = (1, 2, 5, 10, 20, 30, 60, 200)
    likelihoods = [
        mean_log_density(fit_scale_mixture(given_samples, rounds=count), given_samples)
        for count in rounds
    ]
    assert np.all(np.diff(likelihoods) > -1e-12)
    assert likelihoods[-1] - likelihoods[0] > 0.05


def test_numbers_of_a_known_mixture_are_recovered() -> None:
    """Up to sampling error, the cost of a fit rises as that of what the samples were drawn from.

    Away from zero, where the smallest scales keep some of the weight that they began with.
    """
    generator = np.random.default_rng(2)
    scales = generator.choice(MIXED.scales, 40_000, p=MIXED.weights)
    fitted = fit_scale_mixture(scales * generator.normal(size=scales.size))
    x = np.array([0.1, 0.3, 1.0, 2.0, 4.0])
    assert np.allclose(np.diff(fitted.cost(x)), np.diff(MIXED.cost(x)), atol=0.25)
    assert np.isclose(fitted.weights.sum(), 1)
    assert (fitted.weights >= 0).all()
    assert fitted.scales.size == 40


def test_the_shape_of_colors_is_recovered() -> None:
    """Heavy tails do not spoil it as they do the second moments."""
    generator = np.random.default_rng(3)
    scales = generator.choice([0.01, 0.1, 5.0], (30_000, 1), p=[0.5, 0.49, 0.01])
    samples = scales * generator.normal(size=(30_000, 3)) @ np.linalg.cholesky(SHAPE).T
    fitted = fit_scale_mixture(samples)
    assert fitted.covariance is not None
    assert np.isclose(np.linalg.det(fitted.covariance), 1)
    assert np.abs(fitted.covariance - SHAPE).max() < 0.05
    moments = samples.T @ samples
    assert np.abs(moments / np.cbrt(np.linalg.det(moments)) - SHAPE).max() > 0.05
    half = 0.5 * ((samples @ fitted.precision_root) ** 2).sum(axis=1)
    assert np.isclose(fitted.largest, half.max())


def test_scales_follow_the_samples() -> None:
    """Forty, even in their logarithm, from a thousandth of the mean to three times the largest."""
    samples = np.array([-1.0, 2.0, 3.0])
    fitted = fit_scale_mixture(samples)
    assert np.allclose(fitted.scales, np.geomspace(0.002, 9.0, 40))
    assert fitted.largest == 3.0


@pytest.mark.parametrize("columns", [1, 3])
def test_all_samples_scaled_scale_the_fit(columns: int) -> None:
    """The unit of the samples does not matter."""
    samples = np.random.default_rng(4).laplace(size=(500, columns)).squeeze()
    one, thousand = fit_scale_mixture(samples), fit_scale_mixture(1000 * samples)
    assert np.allclose(one.weights, thousand.weights, atol=1e-9)
    assert np.allclose(1000 * one.scales, thousand.scales)


def test_inverse_root_squares_to_the_inverse() -> None:
    """It is symmetric, and its square is the inverse of the padded matrix."""
    root = inverse_root(SHAPE, 0.1)
    assert np.allclose(root, root.T)
    assert np.allclose(root @ root @ (SHAPE + 0.1 * np.eye(3)), np.eye(3))


@pytest.mark.parametrize(
    ("samples", "sentence"),
    [
        (np.empty(0), "no samples to fit"),
        (np.empty((0, 3)), "no samples to fit"),
        (np.array([1.0, np.nan]), "NaN or infinite"),
        (np.array([[1.0, 2.0, np.inf]]), "NaN or infinite"),
        (np.zeros(5), "all samples of a mixture are zero"),
        (np.ones((5, 2)), r"expected samples of shape \(n,\) or \(n, 3\), got \(5, 2\)"),
        (np.array(1.0), r"expected samples of shape"),
        (np.ones((5, 3)), "lie in a plane"),
    ],
)
def test_bad_samples_are_one_sentence(samples: Float, sentence: str) -> None:
    """What cannot be fitted is refused in words."""
    with pytest.raises(RelightlabError, match=sentence):
        fit_scale_mixture(samples)
