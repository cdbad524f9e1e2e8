"""Lights told from the object itself, in pictures made under known ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from shading_model.harmonic_conversion import visible_normals
from shading_model.illumination import LogHarmonics
from shading_model.relative_light import DARKEST, RIDGE, relative_light

NORMALS = visible_normals(2500).reshape(50, 50, 3)
EVERYWHERE = np.ones((50, 50), bool)


def cloth(seed: int) -> Float:
    """A picture of many colours under even light."""
    return np.random.default_rng(seed).uniform(0.1, 0.6, (50, 50, 3))


@settings(max_examples=15)
@given(st.integers(0, 10**6))
def test_the_light_is_found_whatever_the_albedo(seed: int) -> None:
    """The shading of a coloured log-linear light comes back, but for the pull to zero."""
    truth = LogHarmonics(np.random.default_rng(seed).normal(scale=0.1, size=(9, 3)))
    reference = cloth(seed)
    found = relative_light(reference * truth.shade(NORMALS), reference, NORMALS, EVERYWHERE)
    error = found.illumination.shade(NORMALS) / truth.shade(NORMALS) - 1
    assert np.sqrt(np.mean(error**2)) < 0.02
    assert found.residual < 0.01 < found.unlit_residual


def test_the_same_picture_is_under_the_same_light() -> None:
    """All coefficients are zero and nothing was to be explained."""
    found = relative_light(cloth(0), cloth(0), NORMALS, EVERYWHERE)
    assert np.allclose(found.illumination.coefficients, 0)
    assert found.residual == found.unlit_residual == 0


def test_normals_never_seen_do_not_run_away() -> None:
    """Of a nearly flat object in noisy pictures, the light stays moderate at grazing normals."""
    x, y = np.meshgrid(np.linspace(-0.2, 0.2, 50), np.linspace(-0.2, 0.2, 50))
    flat = np.stack([x, y, np.sqrt(1 - x**2 - y**2)], axis=-1)
    noise = np.random.default_rng(3).normal(scale=0.1, size=(50, 50, 3))
    found = relative_light(cloth(3) * np.exp(noise), cloth(3), flat, EVERYWHERE)
    shading = found.illumination.shade(visible_normals())
    assert 0.8 < shading.min() < shading.max() < 1.25
    assert RIDGE > 0


def test_pixels_that_tell_nothing_are_left_out() -> None:
    """Saturated ones by the mask, dark ones and those without a normal by themselves."""
    truth = LogHarmonics(np.full((9, 3), 0.1))
    image = cloth(4) * truth.shade(NORMALS)
    expected = relative_light(image, cloth(4), NORMALS, EVERYWHERE).illumination.shade(NORMALS)
    normals, usable = NORMALS.copy(), EVERYWHERE.copy()
    image[0], normals[1] = DARKEST / 2, np.nan
    image[2], usable[2] = np.nan, False
    found = relative_light(image, cloth(4), normals, usable).illumination.shade(NORMALS)
    assert np.allclose(found, expected, rtol=0.01)


def test_what_cannot_be_used_is_one_sentence() -> None:
    """Too few pixels, sizes that differ, NaN."""
    few = np.zeros((50, 50), bool)
    few[0, :8] = True
    with pytest.raises(RelightlabError, match="8 pixels are neither dark nor saturated"):
        relative_light(cloth(0), cloth(0), NORMALS, few)
    with pytest.raises(RelightlabError, match="expected normals of shape"):
        relative_light(cloth(0), cloth(0), NORMALS[:, :9], EVERYWHERE)
    with pytest.raises(RelightlabError, match="give a mask of the photograph's size"):
        relative_light(cloth(0)[:9], cloth(0), NORMALS, EVERYWHERE)
    with pytest.raises(RelightlabError, match="NaN or infinite"):
        relative_light(cloth(0) * np.nan, cloth(0), NORMALS, EVERYWHERE)
