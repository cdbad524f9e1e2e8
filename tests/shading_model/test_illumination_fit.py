"""Illumination fitted to a shading on a known shape (`eq:argminL`)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import nnls

from shading_model import illumination_fit
from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from shading_model.illumination import LinearHarmonics, PointLights, harmonics
from shading_model.illumination_fit import (
    PointLightProblem,
    fit_harmonics,
    fit_point_lights,
    nonnegative_least_squares,
    unit_shading,
)
from tests.shading_model.outlines import dome, unit_normals

seeds = st.integers(0, 2**32 - 1)


def five_lights(radius: float, generator: np.random.Generator) -> PointLights:
    """Five random sources in front of a dome whose centre is the picture's."""
    directions = unit_normals(generator, 5)
    distance = generator.uniform(2, 6, size=5) * radius
    centre = np.array([radius + 2, -radius - 2, 0])
    return PointLights(
        directions * distance[:, None] + centre, generator.uniform(0.1, 0.4, 5) * distance**2
    )


def random_problem(generator: np.random.Generator, pixels: int = 40) -> PointLightProblem:
    """A surface of random points in the unit ball, with random normals and shading."""
    points = generator.uniform(-1, 1, size=(pixels, 3)) / np.sqrt(3)
    return PointLightProblem(
        points, unit_normals(generator, pixels), generator.random(pixels), clearance=1.2
    )


def central_differences(function: Callable[[Float], Float], at: Float, step: float = 1e-6) -> Float:
    """The derivative of a vector function, one column per argument."""
    offsets = step * np.eye(len(at))
    return np.stack([(function(at + o) - function(at - o)) / (2 * step) for o in offsets], axis=-1)


@given(seeds)
def test_the_derivative_of_one_source_agrees_with_finite_differences(seed: int) -> None:
    """For sources anywhere outside the object, where no point is about to turn dark."""
    generator = np.random.default_rng(seed)
    problem = random_problem(generator)
    position = unit_normals(generator) * generator.uniform(1.3, 8)
    shading, derivative = unit_shading(problem.points, problem.normals, position)
    numeric = central_differences(
        lambda p: unit_shading(problem.points, problem.normals, p)[0], position
    )
    kink = np.abs(np.einsum("ij,ij->i", problem.normals, position - problem.points)) < 1e-4
    assert np.allclose(derivative[~kink], numeric[~kink], rtol=1e-5, atol=1e-6)
    assert (shading >= 0).all()


@given(seeds)
def test_the_jacobian_agrees_with_finite_differences(seed: int) -> None:
    """All twenty parameters, in the coordinates that keep sources outside the object."""
    generator = np.random.default_rng(seed)
    problem = random_problem(generator)
    parameters = problem.start() * generator.lognormal(sigma=0.5, size=20)
    parameters += 0.3 * generator.normal(size=20)
    positions, _ = problem.lights(parameters)
    to_light = positions[:, None] - problem.points
    cosine = np.einsum("ij,mij->mi", problem.normals, to_light)
    smooth = (np.abs(cosine) > 1e-4).all(axis=0)
    numeric = central_differences(problem.residual, parameters)
    scale = np.abs(numeric).max()
    assert np.allclose(
        problem.jacobian(parameters)[smooth], numeric[smooth], rtol=1e-5, atol=1e-7 * max(scale, 1)
    )


@given(seeds)
def test_sources_stay_outside_and_shine(seed: int) -> None:
    """Whatever the twenty numbers, no source enters the clearance or has negative strength."""
    generator = np.random.default_rng(seed)
    problem = random_problem(generator)
    positions, strengths = problem.lights(generator.normal(size=20) * generator.lognormal(0, 2, 20))
    assert (np.linalg.norm(positions, axis=1) >= 1.2 * (1 - 1e-12)).all()
    assert (strengths >= 0).all()


def test_the_start_is_frontal_and_from_four_sides() -> None:
    """Five sources of equal strength whose mean shading is the target's."""
    problem = random_problem(np.random.default_rng(0))
    positions, strengths = problem.lights(problem.start())
    assert np.allclose(strengths, strengths[0])
    assert np.allclose(positions[0, :2], 0)
    assert np.allclose(positions[1:, :2].sum(axis=0), 0)
    assert (positions[:, 2] > 0).all()
    assert np.isclose(problem.residual(problem.start()).mean(), 0, atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_five_known_lights_are_explained(seed: int) -> None:
    """A dome lit by five sources is fitted to a twentieth of its shading's deviation.

    Measured: 0 to 4.5 %; what is left is a local minimum of the sources' positions.
    """
    mask, height, normals = dome(30)
    shading = five_lights(30, np.random.default_rng(seed)).shade(normals, height)
    fit = fit_point_lights(shading, normals, height)
    residual = (shading - fit.illumination.shade(normals, height))[mask]
    assert np.isclose(np.sqrt(np.mean(residual**2)), fit.root_mean_square, rtol=1e-9)
    assert fit.root_mean_square < 0.05 * shading[mask].std()


@settings(max_examples=10)
@given(seeds)
def test_no_fit_is_worse_than_one_frontal_source(seed: int) -> None:
    """On any shading, five sources explain at least what a distant frontal one does."""
    generator = np.random.default_rng(seed)
    mask, height, normals = dome(16)
    shading = five_lights(16, generator).shade(normals, height)
    shading *= generator.lognormal(sigma=0.3, size=shading.shape)
    fit = fit_point_lights(shading, normals, height)
    centre, distance = np.array([18.0, -18.0, 4.0]), 3 * 1.2 * 16
    frontal = PointLights(centre[None] + [0, 0, distance], np.array([distance**2]))
    column = frontal.shade(normals, height)[mask]
    target = shading[mask]
    best = target - column * (column @ target) / (column @ column)
    assert fit.root_mean_square <= np.sqrt(np.mean(best**2)) * (1 + 1e-9)
    assert fit.root_mean_square <= np.sqrt(np.mean(target**2))
    assert (fit.illumination.intensities >= 0).all()


def test_a_sample_of_the_pixels_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """The residual of a fit to a sample is that of a fit to all pixels within three percent."""
    _, height, normals = dome(60)
    generator = np.random.default_rng(5)
    shading = five_lights(60, generator).shade(normals, height)
    shading *= generator.lognormal(sigma=0.1, size=shading.shape)
    sampled = fit_point_lights(shading, normals, height).root_mean_square
    monkeypatch.setattr(illumination_fit, "SAMPLED_PIXELS", 10**9)
    everything = fit_point_lights(shading, normals, height).root_mean_square
    assert np.isclose(sampled, everything, rtol=0.03)


@given(seeds)
@settings(max_examples=10)
def test_brighter_shading_has_brighter_lights(seed: int) -> None:
    """Doubling the shading doubles what the fitted lights give."""
    _, height, normals = dome(12)
    shading = five_lights(12, np.random.default_rng(seed)).shade(normals, height) + 0.1
    one, two = (fit_point_lights(k * shading, normals, height) for k in (1, 2))
    assert np.isclose(two.root_mean_square, 2 * one.root_mean_square, rtol=0.05, atol=2e-3)


def test_where_the_picture_lies_does_not_matter() -> None:
    """Moving the object in its picture, or in depth, moves the lights with it."""
    mask, height, normals = dome(15)
    shading = five_lights(15, np.random.default_rng(6)).shade(normals, height)
    room = ((5, 0), (0, 9))
    moved = fit_point_lights(
        np.pad(shading, room, constant_values=np.nan),
        np.pad(normals, (*room, (0, 0)), constant_values=np.nan),
        np.pad(height + 100, room, constant_values=np.nan),
    )
    here = fit_point_lights(shading, normals, height)
    assert np.isclose(here.root_mean_square, moved.root_mean_square, rtol=0.05)
    shift = moved.illumination.shade(
        np.pad(normals, (*room, (0, 0))), np.pad(height + 100, room, constant_values=100.0)
    )[5:, : mask.shape[1]]
    assert np.allclose(shift[mask], shading[mask], atol=0.02 * np.nanmax(shading))


def test_a_dark_object_and_a_single_pixel_are_fitted() -> None:
    """A shading of zeros gives no light; one pixel is explained exactly."""
    mask, height, normals = dome(8)
    dark = fit_point_lights(np.where(mask, 0.0, np.nan), normals, height)
    assert dark.root_mean_square < 1e-5
    lone = np.full(mask.shape, np.nan)
    lone[10, 10] = 0.4
    assert fit_point_lights(lone, normals, height).root_mean_square < 1e-6


@given(seeds)
@settings(max_examples=25)
def test_harmonics_are_fitted_as_least_squares(seed: int) -> None:
    """The coefficients are those of numpy.linalg.lstsq on the whole system."""
    generator = np.random.default_rng(seed)
    normals = generator.normal(size=(9, 12, 3))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    shading = 5 + generator.random((9, 12))
    shading[0, :3] = np.nan
    fit = fit_harmonics(shading, normals)
    known = np.isfinite(shading)
    basis = harmonics(normals[known])
    expected = np.linalg.lstsq(basis, shading[known], rcond=None)[0]
    assert np.allclose(fit.illumination.coefficients, expected, atol=1e-6)
    residual = shading[known] - np.maximum(basis @ expected, 0)
    assert np.isclose(fit.root_mean_square, np.sqrt(np.mean(residual**2)))


def test_linear_harmonics_are_recovered_where_they_show() -> None:
    """A shading made by nine harmonics is explained exactly, and gives the same shading back."""
    mask, _, normals = dome(20)
    light = LinearHarmonics(np.array([0.5, 0.1, 0.3, -0.1, 0.05, 0.02, 0.1, -0.04, 0.03]))
    shading = light.shade(normals)
    fit = fit_harmonics(shading, normals)
    assert fit.root_mean_square < 1e-9
    assert np.allclose(fit.illumination.shade(normals)[mask], shading[mask])


def test_a_flat_object_determines_only_one_number() -> None:
    """All normals alike: the coefficients of minimum norm explain the mean shading."""
    normals = np.broadcast_to([0.0, 0.0, 1.0], (6, 6, 3))
    fit = fit_harmonics(np.full((6, 6), 0.7), normals)
    basis = harmonics(np.array([0.0, 0.0, 1.0]))
    assert np.allclose(fit.illumination.coefficients, 0.7 * basis / (basis @ basis))


@given(seeds, st.integers(1, 6))
def test_nonnegative_least_squares_agrees_with_scipy(seed: int, count: int) -> None:
    """Solution and residual norm are those of scipy.optimize.nnls on the tall matrix."""
    generator = np.random.default_rng(seed)
    columns = generator.normal(size=(30, count)) + 0.5
    target = generator.normal(size=30)
    solution, norm = nonnegative_least_squares(columns, target)
    expected, expected_norm = nnls(columns, target)
    assert np.allclose(solution, expected, atol=1e-9)
    assert np.isclose(norm, expected_norm)


def test_columns_of_any_scale_and_empty_ones_are_handled() -> None:
    """Columns 1e12 apart are solved as if they were alike, and a zero column gets zero."""
    columns = np.array([[1e-6, 0, 0], [0, 1e6, 0], [0, 0, 0]])
    solution, norm = nonnegative_least_squares(columns, np.array([2.0, 3.0, 4.0]))
    assert np.allclose(solution, [2e6, 3e-6, 0])
    assert np.isclose(norm, 4)


@pytest.mark.parametrize("fit", [fit_point_lights, lambda s, n, _: fit_harmonics(s, n)])
def test_maps_that_do_not_meet_are_refused(fit: Callable[..., object]) -> None:
    """Sizes that differ, and masks without a common pixel, each get a sentence."""
    mask, height, normals = dome(8)
    shading = np.where(mask, 1.0, np.nan)
    with pytest.raises(RelightlabError, match="expected normals of shape"):
        fit(shading, normals[:-1], height)
    with pytest.raises(RelightlabError, match="no pixel has both a shading and a normal"):
        fit(np.where(mask, np.nan, 1.0), normals, height)


def test_heights_of_another_size_are_refused() -> None:
    """The height map is checked too."""
    mask, height, normals = dome(8)
    with pytest.raises(RelightlabError, match="expected heights of shape"):
        fit_point_lights(np.where(mask, 1.0, np.nan), normals, height[:, 1:])
