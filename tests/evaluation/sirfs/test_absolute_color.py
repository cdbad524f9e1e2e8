"""How common a colour of albedo is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from evaluation.sirfs.absolute_color import (
    _interpolation,
    _Pyramid,
    color_whitening,
    fit_color_absolute,
    mean_cost,
    trilinear_splat,
)
from evaluation.sirfs.bending import bending
from evaluation.sirfs.smoothness_search import held_out_costs
from shading_model.arrays import Float
from shading_model.errors import RelightlabError

KNOTS = 27
AXIS = np.linspace(-7, 4, KNOTS)


def colors(count: int = 20_000) -> Float:
    """Whitened log albedos of one broad cloud."""
    return np.random.default_rng(0).normal(-1.0, 1.0, (count, 3))


def test_whitened_samples_are_white() -> None:
    """Their second moments around zero are the identity, but for the padding."""
    spread = np.array([[1.0, 0.5, 0], [0, 1.0, 0.2], [0, 0, 1.0]])
    samples = (colors() - 1.0) @ spread
    whitening = color_whitening(samples)
    whitened = samples @ whitening
    assert np.allclose(whitening, whitening.T)
    assert np.allclose(whitened.T @ whitened / len(whitened), np.eye(3), atol=0.05)


@given(st.lists(st.tuples(*[st.floats(-7, 4)] * 3), min_size=1, max_size=10))
def test_splat_keeps_the_mean(values: list[tuple[float, float, float]]) -> None:
    """Shared between eight knots, a colour stays where it was on average."""
    histogram = trilinear_splat(np.array(values), KNOTS)
    assert np.isclose(histogram.sum(), 1)
    for axis, mean in enumerate(np.mean(values, axis=0)):
        others = tuple({0, 1, 2} - {axis})
        assert np.isclose(histogram.sum(axis=others) @ AXIS, mean)


def test_a_smooth_density_is_recovered() -> None:
    """Where samples fell, F is minus the log of the density they were drawn from."""
    samples = colors(100_000)
    cost = fit_color_absolute(samples, 2.0**-14, KNOTS)
    grid = np.stack(np.meshgrid(AXIS, AXIS, AXIS, indexing="ij"), axis=-1)
    squared = ((grid + 1.0) ** 2).sum(axis=-1)
    common = squared < 2.0**2
    assert (cost[common] - 0.5 * squared[common]).std() < 0.07
    entropy = 1.5 * (1 + np.log(2 * np.pi))
    assert abs(mean_cost(cost, trilinear_splat(samples, KNOTS)) - entropy) < 0.15


def test_no_other_cost_is_much_better() -> None:
    """Nudged broadly or narrowly, the loss does not fall; least the cost is zero."""
    samples, weight = colors(3000), 2.0**-10
    cost, histogram = fit_color_absolute(samples, weight, KNOTS), trilinear_splat(samples, KNOTS)
    coarser = 101 / (KNOTS - 1)

    def loss(candidate: Float) -> float:
        bent = bending(candidate, 1e-5 * coarser**4, np.empty_like(candidate))
        return mean_cost(candidate, histogram) + weight * coarser * bent

    assert cost.min() == 0
    best = loss(cost)
    grid = np.stack(np.meshgrid(AXIS, AXIS, AXIS, indexing="ij"), axis=-1)
    for width in (0.3, 1.0, 3.0):
        for centre in (-4.0, -1.0, 1.0):
            nudge = np.exp(-0.5 * ((grid - centre) ** 2).sum(axis=-1) / width**2)
            assert loss(cost + 0.05 * nudge) > best - 1e-6
            assert loss(cost - 0.05 * nudge) > best - 1e-6


def test_grids_agree_where_it_is_smooth() -> None:
    """With a weight that holds it smooth, twice the knots give the same function."""
    samples = colors(5000)
    coarse = fit_color_absolute(samples, 2.0**-8, 27)
    fine = fit_color_absolute(samples, 2.0**-8, 52)
    there = np.stack([fine[::2, ::2, ::2], coarse[:26, :26, :26]])  # about the same places
    common = there[1] < 4
    assert abs(np.median(there[0][common] - there[1][common])) < 0.2


def test_pyramid_and_its_adjoint() -> None:
    """<sum(x), y> = <x, adjoint(y)>, and a constant on the coarsest level is one on all."""
    pyramid, generator = _Pyramid.of(12), np.random.default_rng(2)
    x, y = generator.normal(size=pyramid.size), generator.normal(size=(12, 12, 12))
    assert np.isclose((pyramid.sum(x) * y).sum(), x @ pyramid.adjoint(y))
    coarse = np.zeros(pyramid.size)
    coarse[-(pyramid.sizes[-1] ** 3) :] = 1.0
    assert np.allclose(pyramid.sum(coarse), 1)


def test_interpolation_is_exact_for_lines() -> None:
    """Between knots of another spacing over the same interval."""
    assert np.allclose(_interpolation(5, 12) @ np.linspace(-7, 4, 5), np.linspace(-7, 4, 12))


@pytest.mark.parametrize("function", [color_whitening, trilinear_splat, fit_color_absolute])
@pytest.mark.parametrize(
    ("samples", "sentence"),
    [(np.empty((0, 3)), "no log albedos"), (np.full((2, 3), np.nan), "contain NaN")],
)
def test_bad_samples_are_one_sentence(function: object, samples: Float, sentence: str) -> None:
    """Nothing, or NaN, is not learned from."""
    assert callable(function)
    with pytest.raises(RelightlabError, match=sentence):
        function(samples)


@pytest.mark.slow
def test_held_out_colors_prefer_some_smoothing() -> None:
    """Neither too little nor too much: the search has its minimum inside."""
    generator = np.random.default_rng(3)
    objects = [generator.normal(-1.0, 0.3, (40, 3)) + generator.normal(0, 0.5, 3) for _ in range(2)]
    costs = held_out_costs(objects, (2.0**-8, 2.0**-12, 2.0**-18), KNOTS).mean(axis=1)
    assert costs.argmin() == 1
    with pytest.raises(RelightlabError, match="at least two objects to leave one out, got 1"):
        held_out_costs(objects[:1])
