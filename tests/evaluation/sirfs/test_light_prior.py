"""The Gaussian of lights and its round coordinates."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from datasets.training_lights import released_gaussian
from evaluation.sirfs.light_prior import LightPrior, light_prior, light_whitening
from shading_model.arrays import Float
from shading_model.errors import RelightlabError


def some_lights(count: int = 60) -> Float:
    """Lights in colour, correlated and of different spreads."""
    generator = np.random.default_rng(0)
    return generator.normal(size=(count, 9, 1)) * np.arange(1, 10)[:, None] + generator.normal(
        scale=0.2, size=(count, 9, 3)
    )


def test_vectors_are_channel_by_channel() -> None:
    """Nine coefficients of the first colour come first."""
    lights = some_lights()
    prior = light_prior(lights)
    assert prior.count == 60
    assert np.allclose(prior.mean.reshape(3, 9).T, lights.mean(axis=0))
    fifth_of_second = lights[:, 4, 1]
    assert np.isclose(prior.covariance[13, 13], fifth_of_second.var(ddof=1))
    third_of_third = lights[:, 2, 2]
    assert np.isclose(prior.covariance[13, 20], np.cov(fifth_of_second, third_of_third)[0, 1])


def test_gray_is_the_mean_of_the_channels() -> None:
    """A gray prior has the mean of the colours' means."""
    lights = some_lights()
    gray, color = light_prior(lights.mean(axis=2)), light_prior(lights)
    assert np.allclose(gray.mean, color.mean.reshape(3, 9).mean(axis=0))
    assert gray.covariance.shape == (9, 9)


@pytest.mark.parametrize("padding", [0.0, 0.01, 1.0])
def test_whitened_lights_have_unit_mean_square(padding: float) -> None:
    """The coordinates of the lights that were learned from are of root mean square one."""
    lights = some_lights()
    vectors = np.swapaxes(lights, 1, 2).reshape(-1, 27)
    whitening = light_whitening(light_prior(lights), padding)
    whitened = (vectors - whitening.mean) @ whitening.map
    assert np.isclose((whitened**2).mean(), 1)
    assert np.allclose(whitening.map, whitening.map.T)
    assert np.allclose(whitened @ whitening.inverse.T + whitening.mean, vectors)


def test_padding_keeps_what_hardly_varies() -> None:
    """A coefficient of no variance is mapped no more than ten times as far as its unit."""
    prior = LightPrior(np.zeros(9), np.diag([1.0] * 8 + [0.0]), 1000)
    assert np.isclose(light_whitening(prior).map[8, 8], 10 * np.sqrt(9 / 8 * 1.01), rtol=1e-3)


@pytest.mark.parametrize(
    ("lights", "sentence"),
    [
        (np.ones((4, 27)), r"expected lights of shape .*got \(4, 27\)"),
        (np.ones((1, 9, 3)), "at least two lights to learn from, got 1"),
        (np.full((4, 9), np.nan), "NaN or infinite"),
    ],
)
def test_bad_lights_are_one_sentence(lights: Float, sentence: str) -> None:
    """Lights that no Gaussian can be learned from are refused."""
    with pytest.raises(RelightlabError, match=sentence):
        light_prior(lights)


@pytest.mark.real_data
@pytest.mark.parametrize("kind", ["natural", "laboratory"])
def test_released_whitening(data_root: Path, kind: str) -> None:
    """The map that boundary-cues ships is that of its lights, without padding."""
    if not (data_root / "boundary-cues").is_dir():
        pytest.skip("the data root holds no boundary-cues/")
    released = released_gaussian(data_root, kind)
    prior = LightPrior(released.mean, released.covariance, len(released.lights))
    assert np.allclose(released.lights.mean(axis=0), prior.mean, atol=1e-12)
    assert np.allclose(np.cov(released.lights, rowvar=False), prior.covariance, atol=1e-12)
    assert np.allclose(light_whitening(prior, 0.0).map, released.whitening, atol=1e-8)
