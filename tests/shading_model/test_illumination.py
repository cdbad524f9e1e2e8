"""Illuminations: spherical harmonics and point lights."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from shading_model.illumination import (
    Illumination,
    LinearHarmonics,
    LogHarmonics,
    PointLights,
    harmonics,
    surface_points,
)
from tests.shading_model.outlines import unit_normals

seeds = st.integers(0, 2**32 - 1)


def sphere(rows: int = 60, columns: int = 120) -> tuple[Float, Float]:
    """Directions over the whole sphere, and the solid angle of each."""
    polar = (np.arange(rows) + 0.5) * np.pi / rows
    azimuth = np.arange(columns) * 2 * np.pi / columns
    polar, azimuth = np.meshgrid(polar, azimuth, indexing="ij")
    directions = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1
    )
    weights = np.sin(polar) * (np.pi / rows) * (2 * np.pi / columns)
    return directions.reshape(-1, 3), weights.ravel()


def distant_light(direction: Float) -> Float:
    """Irradiance coefficients of a unit distant light: its nine real spherical harmonics."""
    x, y, z = direction
    return np.array(
        [
            0.282095,
            0.488603 * y,
            0.488603 * z,
            0.488603 * x,
            1.092548 * x * y,
            1.092548 * y * z,
            0.315392 * (3 * z * z - 1),
            1.092548 * x * z,
            0.546274 * (x * x - y * y),
        ]
    )


def test_harmonics_are_the_irradiance_form_by_hand() -> None:
    """At (0.6, 0, 0.8) and (0, -1, 0) the nine terms are the published polynomials."""
    c1, c2, c3, c4, c5 = 0.429043, 0.511664, 0.743125, 0.886227, 0.247708
    found = harmonics(np.array([[0.6, 0.0, 0.8], [0.0, -1.0, 0.0]]))
    tilted = [c4, 0, 1.6 * c2, 1.2 * c2, 0, 0, 0.64 * c3 - c5, 0.96 * c1, 0.36 * c1]
    down = [c4, -2 * c2, 0, 0, 0, 0, -c5, 0, -c1]
    assert np.allclose(found, [tilted, down])


def test_harmonics_are_orthogonal_over_the_sphere() -> None:
    """Their Gram matrix is diagonal, with A_l^2 (pi, 2 pi / 3 and pi / 4 squared) on it."""
    directions, weights = sphere()
    basis = harmonics(directions)
    gram = basis.T @ (weights[:, None] * basis)
    expected = np.array([np.pi] + [2 * np.pi / 3] * 3 + [np.pi / 4] * 5) ** 2
    assert np.allclose(gram, np.diag(expected), atol=0.01)


@given(seeds)
def test_a_distant_light_is_the_lambert_cosine_within_the_known_error(seed: int) -> None:
    """Nine terms reproduce max(0, n . l) with a root-mean-square error of 9 % of its own.

    Ramamoorthi and Hanrahan (2001): orders 0 to 2 hold 99.22 % of the energy of the clamped cosine.
    """
    light = np.random.default_rng(seed).normal(size=3)
    light /= np.linalg.norm(light)
    directions, weights = sphere()
    cosine = np.maximum(directions @ light, 0)
    error = harmonics(directions) @ distant_light(light) - cosine
    share = (weights @ error**2) / (weights @ cosine**2)
    assert np.isclose(share, 1 - 0.9922, atol=1e-3)
    assert np.abs(error).max() < 0.1


@given(seeds)
def test_turning_light_and_surface_together_changes_nothing(seed: int) -> None:
    """Linear harmonics of a distant light depend on the angle between normal and light alone."""
    generator = np.random.default_rng(seed)
    rotation = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    light, normals = unit_normals(generator), unit_normals(generator, 4, 5)
    before = LinearHarmonics(distant_light(light)).shade(normals)
    after = LinearHarmonics(distant_light(rotation @ light)).shade(normals @ rotation.T)
    assert np.allclose(before, after, atol=1e-5)


@given(seeds)
def test_a_turn_about_the_viewing_axis_turns_point_light_shading(seed: int) -> None:
    """Turning normals, surface and sources about z leaves every shading value as it was."""
    generator = np.random.default_rng(seed)
    height, normals = generator.normal(size=(5, 5)), unit_normals(generator, 5, 5)
    positions = generator.normal(size=(3, 3)) * 10 + [2, -2, 20]
    before = PointLights(positions, np.ones(3)).shade(normals, height)
    # A quarter turn counterclockwise about the centre (2, -2): np.rot90 on the picture.
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    centre = np.array([2.0, -2, 0])
    turned = PointLights((positions - centre) @ quarter.T + centre, np.ones(3))
    after = turned.shade(np.rot90(normals @ quarter.T), np.rot90(height))
    assert np.allclose(after, np.rot90(before))


def test_log_harmonics_are_the_exponential_and_linear_ones_the_clamp() -> None:
    """Both conventions share B(N) . L and differ as they say."""
    generator = np.random.default_rng(0)
    normals, coefficients = unit_normals(generator, 6, 7), generator.normal(size=(9, 3))
    product = harmonics(normals) @ coefficients
    assert np.allclose(LogHarmonics(coefficients).shade(normals), np.exp(product))
    linear = LinearHarmonics(coefficients).shade(normals)
    assert np.array_equal(linear, np.maximum(product, 0))
    assert (linear == 0).any()


@pytest.mark.parametrize("kind", [LogHarmonics, LinearHarmonics])
def test_a_monochrome_light_is_the_mean_of_the_coefficients(
    kind: type[LogHarmonics | LinearHarmonics],
) -> None:
    """For log harmonics that is the geometric mean of the channels; a gray light is itself."""
    coefficients = np.random.default_rng(1).normal(size=(9, 3))
    gray = kind(coefficients).monochrome()
    assert np.allclose(gray.coefficients, coefficients.mean(axis=1))
    assert gray.monochrome() is gray


@pytest.mark.parametrize("kind", [LogHarmonics, LinearHarmonics])
@pytest.mark.parametrize("shape", [(8,), (9, 2), (3, 9), (9, 3, 1), ()])
def test_other_numbers_of_coefficients_are_refused(
    kind: type[LogHarmonics | LinearHarmonics], shape: tuple[int, ...]
) -> None:
    """Nine, or nine for each of three channels; the sentence says what came."""
    with pytest.raises(RelightlabError, match=r"shape \(9,\) or \(9, 3\), got"):
        kind(np.zeros(shape))


@pytest.mark.parametrize("kind", [LogHarmonics, LinearHarmonics])
def test_coefficients_are_finite_and_cannot_be_changed(
    kind: type[LogHarmonics | LinearHarmonics],
) -> None:
    """NaN is refused, the caller's array is copied, and the copy is read-only."""
    with pytest.raises(RelightlabError, match="contain NaN or infinite values"):
        kind(np.full(9, np.nan))
    given_array = np.zeros(9)
    light = kind(given_array)
    given_array[0] = 1
    assert light.coefficients[0] == 0
    with pytest.raises(ValueError, match="read-only"):
        light.coefficients[0] = 1


@pytest.mark.parametrize(
    "light",
    [
        LogHarmonics(np.ones(9)),
        LogHarmonics(np.ones((9, 3))),
        LinearHarmonics(np.ones(9)),
        PointLights(np.array([[3.0, 1.0, 9.0]]), np.array([50.0])),
    ],
)
def test_shading_is_nan_exactly_where_normals_are(light: Illumination) -> None:
    """A forgotten mask shows as NaN, in every kind of light."""
    normals = unit_normals(np.random.default_rng(2), 4, 6)
    normals[1, 2] = normals[3, 3] = np.nan
    shading = light.shade(normals, np.zeros((4, 6)))
    unknown = np.isnan(shading).reshape(4, 6, -1)
    assert (unknown == np.isnan(normals[..., :1])).all()


def test_a_frontal_point_light_over_a_plane_is_the_closed_form() -> None:
    """At lateral distance d under a source at height H the shading is I H / (H^2 + d^2)^(3/2)."""
    normals = np.zeros((9, 9, 3))
    normals[..., 2] = 1
    light = PointLights(np.array([[4.0, -4.0, 12.0]]), np.array([144.0]))
    rows, columns = np.indices((9, 9))
    squared = (rows - 4) ** 2 + (columns - 4) ** 2
    expected = 144 * 12 / (144 + squared) ** 1.5
    assert np.allclose(light.shade(normals, np.zeros((9, 9))), expected)
    raised = 144 * 10 / (100 + squared) ** 1.5
    assert np.allclose(light.shade(normals, np.full((9, 9), 2.0)), raised)


def test_point_lights_add_and_do_not_shine_from_behind() -> None:
    """Two sources are the sum of each; a source below the surface gives nothing."""
    generator = np.random.default_rng(3)
    normals, height = unit_normals(generator, 5, 6), generator.normal(size=(5, 6))
    positions = np.array([[9.0, 3.0, 20.0], [-8.0, 2.0, 15.0]])
    both = PointLights(positions, np.array([3.0, 5.0])).shade(normals, height)
    each = [
        PointLights(positions[k : k + 1], np.array([s])).shade(normals, height)
        for k, s in enumerate((3.0, 5.0))
    ]
    assert np.allclose(both, sum(each))
    facing = np.broadcast_to([0.0, 0.0, 1.0], (5, 6, 3))
    below = PointLights(np.array([[2.0, -2.0, -20.0]]), np.ones(1))
    assert (below.shade(facing, np.zeros((5, 6))) == 0).all()


@pytest.mark.parametrize(
    ("positions", "intensities"), [((2, 3), (3,)), ((2, 2), (2,)), ((3,), (1,)), ((0, 2), (0,))]
)
def test_positions_and_intensities_belong_together(
    positions: tuple[int, ...], intensities: tuple[int, ...]
) -> None:
    """One intensity for each position of three coordinates."""
    with pytest.raises(RelightlabError, match=r"positions of shape \(m, 3\) and intensities"):
        PointLights(np.ones(positions), np.ones(intensities))


def test_surface_points_run_right_and_up() -> None:
    """The column is x and minus the row is y."""
    points = surface_points(np.arange(6.0).reshape(2, 3))
    assert points[1, 2].tolist() == [2.0, -1.0, 5.0]
