"""Nine coefficients from the picture of a matt sphere."""

from __future__ import annotations

import re
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shading_model.arrays import Image
from shading_model.chrome_probe import chrome_direction
from shading_model.diffuse_probe import FITS, dominant_direction, fit_diffuse_probe
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics
from shading_model.probe_sphere import fit_sphere
from tests.shading_model.probe_pictures import (
    bright_light,
    degrees_between,
    diffuse_picture,
    sphere_mask,
)
from tests.shading_model.psm_pictures import light_directions, mask_of, picture_of, psm_uw

MASK = sphere_mask()


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.floats(20, 40))
def test_nine_coefficients_are_recovered(seed: int, radius: float) -> None:
    """A sphere shaded by nine coefficients of three colours gives them back to 1e-9."""
    light, mask = bright_light(seed), sphere_mask(radius=radius)
    probe = fit_diffuse_probe(diffuse_picture(light, mask), mask)
    np.testing.assert_allclose(probe.linear.coefficients, light.coefficients, atol=1e-9)
    assert probe.residual < 1e-9
    assert probe.rank == 9
    assert 1 < probe.condition < 200
    assert probe.saturated_share == 0
    assert probe.pixels == fit_sphere(mask).inner_pixels(mask).sum()
    expected = dominant_direction(light)
    assert expected is not None
    assert probe.direction is not None
    np.testing.assert_allclose(probe.direction, expected, atol=1e-6)


def test_log_coefficients_are_recovered() -> None:
    """A sphere shaded by nine log coefficients gives them back, and no linear light fits better."""
    truth = np.random.default_rng(3).normal(scale=0.3, size=(9, 3))
    truth[0] -= 2
    light = LogHarmonics(truth)
    picture = np.nan_to_num(light.shade(fit_sphere(MASK).normals((90, 120))))
    probe = fit_diffuse_probe(picture, MASK)
    assert probe.log is not None
    np.testing.assert_allclose(probe.log.coefficients, truth, atol=1e-7)
    assert probe.log_residual < 1e-8 < probe.residual


@given(st.integers(0, 100), st.floats(0.01, 1.0), st.floats(0.01, 1.0))
@settings(max_examples=10)
def test_light_and_paint_are_factors(seed: int, exposure: float, albedo: float) -> None:
    """The coefficients grow with the exposure and fall with the albedo; direction and fit stay."""
    picture = diffuse_picture(bright_light(seed), MASK)
    plain = fit_diffuse_probe(picture, MASK)
    other = fit_diffuse_probe(exposure * picture, MASK, albedo=albedo)
    factor = exposure / albedo
    np.testing.assert_allclose(
        other.linear.coefficients, factor * plain.linear.coefficients, rtol=1e-9, atol=1e-9 * factor
    )
    assert plain.log is not None
    assert other.log is not None
    np.testing.assert_allclose(other.log.coefficients[1:], plain.log.coefficients[1:], atol=1e-6)


def test_colours_have_paint_of_their_own() -> None:
    """Three albedos divide three colours."""
    light = bright_light(1)
    paint = np.array([0.9, 0.5, 0.1])
    probe = fit_diffuse_probe(paint * diffuse_picture(light, MASK), MASK, albedo=paint)
    np.testing.assert_allclose(probe.linear.coefficients, light.coefficients, atol=1e-9)


def test_a_mirrored_picture_mirrors_the_light() -> None:
    """Left and right exchanged, the harmonics odd in x change their sign."""
    picture = diffuse_picture(bright_light(5), MASK)
    plain = fit_diffuse_probe(picture, MASK).linear.coefficients
    mirrored = fit_diffuse_probe(picture[:, ::-1], MASK[:, ::-1]).linear.coefficients
    signs = np.array([1, 1, 1, -1, -1, 1, 1, -1, 1])[:, None]
    np.testing.assert_allclose(mirrored, signs * plain, atol=1e-9)


def test_a_distant_light_leaves_a_few_per_cent() -> None:
    """Nine harmonics miss the edge of the attached shadow; one distant light does not."""
    toward = np.array([0.6, 0.48, 0.64])
    normals = fit_sphere(MASK).normals((90, 120))
    picture = np.nan_to_num(0.8 * np.maximum(0.0, normals @ toward))
    probe = fit_diffuse_probe(picture, MASK)
    assert 0.02 < probe.residual < 0.08
    assert probe.distant is not None
    assert degrees_between(probe.distant.direction, toward) < 1e-4
    assert probe.distant.intensity == pytest.approx(0.8)


def test_a_uniform_light_has_no_direction() -> None:
    """Where the three linear coefficients vanish there is no dominant direction."""
    assert fit_diffuse_probe(np.full((90, 120), 0.5), MASK).direction is None


def test_saturated_pixels_are_left_out() -> None:
    """Two per cent of white pixels do not change the coefficients; their share is told."""
    light = bright_light(2)
    picture = diffuse_picture(light, MASK)
    inner = np.argwhere(fit_sphere(MASK).inner_pixels(MASK))
    for row, column in inner[:: len(inner) // 80]:
        picture[row, column, 1] = 1.0
    probe = fit_diffuse_probe(picture, MASK)
    np.testing.assert_allclose(probe.linear.coefficients, light.coefficients, atol=1e-9)
    assert 0.01 < probe.saturated_share < 0.03
    assert probe.pixels == round((1 - probe.saturated_share) * len(inner))
    assert fit_diffuse_probe(picture, MASK, saturated=np.inf).saturated_share == 0


def test_a_dark_colour_has_no_log() -> None:
    """Under a pure red light the linear fit stands and the log fit is left out."""
    picture = diffuse_picture(bright_light(4), MASK) * np.array([1.0, 0.0, 0.0])
    probe = fit_diffuse_probe(picture, MASK)
    assert probe.log is None
    assert np.isnan(probe.log_residual)
    np.testing.assert_allclose(probe.linear.coefficients[:, 1:], 0, atol=1e-12)


def test_a_cut_sphere_will_do() -> None:
    """Three quarters of a sphere determine nine coefficients."""
    light, cut = bright_light(6), MASK[:, :80]
    probe = fit_diffuse_probe(diffuse_picture(light, cut), cut)
    assert probe.sphere.is_cut
    np.testing.assert_allclose(probe.linear.coefficients, light.coefficients, atol=1e-8)


def test_noise_moves_the_shading_little() -> None:
    """One per cent of noise leaves one per cent of residual, and shading half a per cent right."""
    light = bright_light(7)
    picture = diffuse_picture(light, MASK)
    noisy = picture * np.random.default_rng(0).normal(1.0, 0.01, picture.shape)
    probe = fit_diffuse_probe(noisy, MASK)
    assert probe.residual == pytest.approx(0.01, rel=0.1)
    normals = fit_sphere(MASK).normals((90, 120))[fit_sphere(MASK).inner_pixels(MASK)]
    np.testing.assert_allclose(probe.linear.shade(normals), light.shade(normals), rtol=5e-3)


SMALL = sphere_mask((12, 12), (6.0, 6.0), 2.7)


def test_too_few_pixels_are_refused_or_regularised() -> None:
    """Five pixels determine five coefficients: refused with the rank, or solved as is asked."""
    picture = np.full((12, 12), 0.4)
    with pytest.raises(RelightlabError, match="5 pixels determine 5 of the 9 coefficients"):
        fit_diffuse_probe(picture, SMALL)
    least = fit_diffuse_probe(picture, SMALL, method="minimum-norm")
    assert (least.rank, least.pixels, least.log) == (5, 5, None)
    assert least.residual < 1e-9
    damped = fit_diffuse_probe(picture, SMALL, method="ridge", ridge=0.1)
    assert damped.residual > 1e-3
    norms = [np.linalg.norm(probe.linear.coefficients) for probe in (damped, least)]
    assert norms[0] < norms[1]


def test_minimum_norm_is_least_squares_at_full_rank() -> None:
    """Where nine are determined the two are one; a faint ridge is near them."""
    picture = diffuse_picture(bright_light(8), MASK)
    squares, norm, ridge = (
        fit_diffuse_probe(picture, MASK, method=method, ridge=1e-12).linear.coefficients
        for method in FITS
    )
    np.testing.assert_array_equal(squares, norm)
    np.testing.assert_allclose(ridge, squares, atol=1e-6)


def picture(**changes: float) -> Image:
    """Return a gray picture with one value changed inside the sphere."""
    values = np.full((90, 120, 3), 0.5)
    for value in changes.values():
        values[40, 60] = value
    return values


@pytest.mark.parametrize(
    ("image", "options", "words"),
    [
        (np.full((90, 120), 1.0), {}, "saturated on 100 % of the sphere"),
        (np.full((90, 100), 0.5), {}, "the photograph is 100x90 pixels but its mask is 120x90"),
        (np.full((90, 120, 2), 0.5), {}, "expected an image of shape (h, w, 3)"),
        (np.zeros((90, 120)), {}, "the light probe is dark"),
        (np.where(np.arange(120) == 60, 1.0, np.zeros((90, 120))), {}, "the light probe is dark"),
        (picture(value=np.nan), {}, "1 NaN or infinite pixels"),
        (picture(value=-1.0), {}, "1 negative pixels"),
        (picture(), {"method": "lasso"}, "Unknown fit 'lasso'"),
        (picture(), {"ridge": 0.0}, "expected a ridge above zero"),
        (picture(), {"albedo": 0.0}, "expected an albedo above 0 and at most 1"),
        (picture(), {"albedo": np.array([0.5, np.nan, 0.5])}, "expected an albedo above 0"),
        (picture(), {"albedo": np.array([0.5, 0.5])}, "expected an albedo above 0"),
        (picture(), {"border": 1.0}, "the sphere is too small"),
    ],
)
def test_probes_that_cannot_be_used(image: Image, options: dict[str, object], words: str) -> None:
    """Each gets one sentence."""
    with pytest.raises(RelightlabError, match=re.escape(words)):
        fit_diffuse_probe(image, MASK, **options)  # type: ignore[arg-type]


def test_the_fit_is_quick() -> None:
    """A sphere of 37000 pixels in a picture of 512x340 takes about 0.06 s; a busy machine more."""
    mask = sphere_mask((340, 512), (144.5, 244.5), 108.2)
    picture = diffuse_picture(bright_light(9), mask)
    fit_diffuse_probe(picture, mask)
    times = []
    for _ in range(3):
        started = time.perf_counter()
        fit_diffuse_probe(picture, mask)
        times.append(time.perf_counter() - started)
    assert min(times) < 0.2


@pytest.mark.real_data
def test_the_gray_sphere_of_psm_uw(data_root: Path) -> None:
    """Residuals of 3.3 to 3.9 per cent; directions as the chrome sphere's, better than the file's.

    Measured: the single distant light is 2.0 degrees from the chrome sphere's highlight on average
    (0.7 to 4.8) and 3.2 from lights.txt (1.0 to 7.1); the linear coefficients 5.3 and 6.2, where
    the first light, with the most shadow, is 25 from the file. The twelve fits take 0.5 s.
    """
    folder = psm_uw(data_root)
    mask, chrome_mask = mask_of(folder, "gray"), mask_of(folder, "chrome")
    to_file, to_chrome, linear_to_file = [], [], []
    for index, stated in enumerate(light_directions(folder)):
        probe = fit_diffuse_probe(picture_of(folder, "gray", index), mask)
        chrome = chrome_direction(picture_of(folder, "chrome", index), chrome_mask)
        assert 0.03 < probe.residual < 0.042
        assert probe.log_residual < 0.056
        assert (probe.rank, round(probe.condition)) == (9, 72)
        assert probe.saturated_share < 2e-4
        assert probe.distant is not None
        assert probe.direction is not None
        to_file.append(degrees_between(probe.distant.direction, stated))
        to_chrome.append(degrees_between(probe.distant.direction, chrome.direction))
        linear_to_file.append(degrees_between(probe.direction, stated))
    assert max(to_file) < 8
    assert np.mean(to_file) < 3.6
    assert max(to_chrome) < 5.5
    assert np.mean(to_chrome) < 2.4
    assert np.median(linear_to_file) < 4
    assert max(linear_to_file) < 27


@pytest.mark.real_data
def test_the_axes_of_psm_uw(data_root: Path) -> None:
    """Directions of lights.txt are x right, y up, z to the viewer: any other sign is 20 off."""
    folder = psm_uw(data_root)
    mask, stated = mask_of(folder, "gray"), light_directions(folder)
    found = []
    for index in range(len(stated)):
        light = fit_diffuse_probe(picture_of(folder, "gray", index), mask).distant
        assert light is not None
        found.append(light.direction)

    def mean_angle(*signs: float) -> float:
        pairs = zip(found, stated, strict=True)
        return float(np.mean([degrees_between(a, np.array(signs) * b) for a, b in pairs]))

    assert mean_angle(1, 1, 1) < 3.6
    assert mean_angle(-1, 1, 1) > 18
    assert mean_angle(1, -1, 1) > 35
