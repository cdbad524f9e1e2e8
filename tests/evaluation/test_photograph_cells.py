"""Tests of the error of a model against a photograph under a known light."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from evaluation.photograph_cells import photograph_cell
from shading_model.errors import RelightlabError
from shading_model.illumination import LinearHarmonics, LogHarmonics, PointLights
from shading_model.object_model import ObjectModel, Weights

DARK = "the light leaves the whole shape dark"


def a_model(seed: int = 0, side: int = 12) -> ObjectModel:
    """A model of random albedo, normals and details on a disk."""
    generator = np.random.default_rng(seed)
    rows, columns = np.mgrid[:side, :side] - (side - 1) / 2
    mask = np.hypot(rows, columns) < side / 2
    normals = np.stack([columns, -rows, np.full(mask.shape, side)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    detail = generator.normal(scale=0.1, size=(2, side, side))
    light = PointLights(np.array([[6.0, -6.0, 60.0]]), np.array([2000.0]))
    albedo = generator.uniform(0.2, 0.9, size=(side, side, 3))
    return ObjectModel(mask, albedo, np.zeros(mask.shape), normals, *detail, light)


def a_light(seed: int, channels: int = 3) -> LogHarmonics:
    """A mild log-harmonic light."""
    shape = (9, 3) if channels == 3 else 9
    return LogHarmonics(np.random.default_rng(seed).normal(scale=0.2, size=shape))


def exposed(model: ObjectModel, light: LogHarmonics) -> LogHarmonics:
    """The light at the scale of the shading that the model was built from."""
    own = model.illumination.shade(model.normals, model.height) + model.parametric_residual
    gain = own[model.mask].mean() / light.shade(model.normals)[model.mask].mean()
    return LogHarmonics(light.coefficients + np.eye(9)[0][:, None] * np.log(gain) / 0.886227)


@given(st.integers(0, 2**32 - 1))
@pytest.mark.parametrize("channels", ["gray", "color"])
def test_the_photograph_of_the_model_itself_has_no_error(channels: str, seed: int) -> None:
    """A photograph that the model makes at some weights and any scale has error zero there."""
    model, light = a_model(seed), a_light(seed)
    weights = Weights(0.7, -0.4)
    photograph = 3.0 * model.relight(exposed(model, light), weights)
    cell = photograph_cell(model, photograph, light, channels)
    assert cell.error(weights) < 1e-12 * cell.power
    assert np.allclose(dataclasses.astuple(cell.oracle()), (0.7, -0.4), atol=1e-6)


def test_the_error_is_that_of_the_pictures() -> None:
    """At any weights it is the mean squared difference of relit model and photograph, scaled."""
    model, light = a_model(1), a_light(2)
    photograph = np.random.default_rng(3).uniform(size=(*model.mask.shape, 3))
    relit = model.relight(exposed(model, light), Weights(0.3, 0.6))[model.mask]
    target = photograph[model.mask]
    scale = (relit * target).sum() / (relit**2).sum()
    found = photograph_cell(model, photograph, light, "color").error(Weights(0.3, 0.6))
    assert found == pytest.approx(np.mean((target - scale * relit) ** 2), rel=1e-9)


@given(st.floats(-3.0, 3.0))
def test_the_scale_of_a_light_plays_no_part(gain: float) -> None:
    """A light of another brightness gives the same cell, unless its own exposure is asked for."""
    model, light = a_model(4), a_light(5, channels=1)
    photograph = model.relight(a_light(6))
    brighter = LogHarmonics(light.coefficients + gain * np.eye(9)[0])
    one, two = (photograph_cell(model, photograph, x) for x in (light, brighter))
    assert np.allclose(one.gram, two.gram)
    assert np.allclose(one.cross, two.cross)
    own = [photograph_cell(model, photograph, x, match_exposure=False) for x in (light, brighter)]
    assert np.isclose(own[1].gram[0, 0], own[0].gram[0, 0] * np.exp(2 * gain * 0.886227))


def test_pixels_outside_the_mask_play_no_part() -> None:
    """Whatever the photograph holds outside the object, the cell is the same."""
    model, light = a_model(7), a_light(8)
    photograph = model.relight(light)
    elsewhere = np.where(model.mask[..., None], photograph, np.nan)
    one, two = (photograph_cell(model, p, light) for p in (photograph, elsewhere))
    assert np.array_equal(one.gram, two.gram)
    assert one.power == two.power


@pytest.mark.parametrize(
    ("photograph", "light", "channels", "words"),
    [
        (np.ones((5, 5, 3)), a_light(0), "gray", r"expected a photograph of shape \(12, 12, 3\)"),
        (np.full((12, 12, 3), np.nan), a_light(0), "gray", "not finite"),
        (np.ones((12, 12, 3)), a_light(0), "grey", "Unknown channels 'grey'"),
        (np.ones((12, 12, 3)), LinearHarmonics(-np.eye(9)[0]), "gray", DARK),
    ],
)
def test_what_cannot_be_compared_is_refused(
    photograph: np.ndarray, light: LogHarmonics, channels: str, words: str
) -> None:
    """Other sizes, unknown pixels or channels, and a light that does not reach the object."""
    with pytest.raises(RelightlabError, match=words):
        photograph_cell(a_model(), photograph, light, channels)
