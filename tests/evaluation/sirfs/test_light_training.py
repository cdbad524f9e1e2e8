"""From measured lights to those a prior is learned from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from datasets.mit_axes import harmonics_from_mit_axes
from evaluation.sirfs.light_prior import LightPrior
from evaluation.sirfs.light_training import (
    are_valid,
    brightest_at_zero,
    disk_normals,
    laboratory_training_lights,
    light_priors,
    mirrored,
    natural_training_lights,
    released_light_priors,
    with_chroma,
    without_near_duplicates,
)
from shading_model.arrays import Float
from shading_model.illumination import harmonics
from shading_model.seeds import generator_for


def frontal_lights(count: int, spread: float = 0.15) -> Float:
    """Random lights, brighter from the front."""
    lights = generator_for("frontal lights").normal(scale=spread, size=(count, 9, 3))
    lights[:, 2] += 0.3
    return lights


def test_mirrored_lights_shade_mirrored_surfaces() -> None:
    """A normal and its mirror image are shaded alike by a light and its mirror image."""
    normals = disk_normals(8)
    light = frontal_lights(1)
    there = harmonics(normals * [-1.0, 1.0, 1.0]) @ mirrored(light)[0]
    assert np.allclose(there, harmonics(normals) @ light[0])
    assert np.array_equal(mirrored(mirrored(light)), light)


def test_chroma_keeps_the_gray_light() -> None:
    """Only what the channels differ by is scaled."""
    lights = frontal_lights(3)
    milder = with_chroma(lights, 0.25)
    assert np.allclose(milder.mean(axis=2), lights.mean(axis=2))
    assert np.allclose(milder[..., 0] - milder[..., 1], 0.25 * (lights[..., 0] - lights[..., 1]))


def test_the_brightest_shading_is_zero() -> None:
    """Over the front and the channels, whatever constant was added before."""
    lights = frontal_lights(4)
    scaled = brightest_at_zero(lights)
    shading = harmonics(disk_normals(256)) @ scaled
    assert np.allclose(shading.max(axis=(1, 2)), 0, atol=1e-12)
    lights[:, 0] += 3.0
    assert np.allclose(brightest_at_zero(lights), scaled)


def test_lights_from_behind_or_dark_are_not_valid() -> None:
    """From the front is; turned by half a turn, or dark in the centre, is not."""
    front = np.zeros((1, 9, 3))
    front[:, 2] = 0.5
    dark = front.copy()
    dark[:, 0] = -3.0
    assert are_valid(np.concatenate([front, -front, dark])).tolist() == [True, False, False]


def test_near_duplicates_are_dropped_from_the_second_on() -> None:
    """The first of those alike stays; a light unlike it stays as well."""
    far = np.zeros((3, 9, 3))
    far[1, 3] = 1e-3
    far[2, 3] = 1.0
    assert without_near_duplicates(far).tolist() == [True, False, True]


def test_disk_normals_are_unit_and_frontal() -> None:
    """One of them looks straight at the viewer."""
    normals = disk_normals(32)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1)
    assert (normals[:, 2] > 0).all()
    assert (normals == [0, 0, 1]).all(axis=1).sum() == 1


def test_half_of_the_natural_lights_is_drawn() -> None:
    """Valid and scaled lights, the same half each time, away from known ones."""
    environments = frontal_lights(6)
    chosen = natural_training_lights(environments, np.empty((0, 9, 3)))
    again = natural_training_lights(environments, np.empty((0, 9, 3)))
    assert np.array_equal(chosen, again)
    assert 10 < len(chosen) <= 6 * 18 // 2
    assert are_valid(chosen).all()
    assert np.allclose(brightest_at_zero(chosen), chosen)
    away = natural_training_lights(environments, chosen)
    nearest = np.abs(away[:, None] - chosen[None]).max(axis=(2, 3)).min(axis=1)
    assert (nearest > 1e-6).all()


def test_laboratory_lights_come_in_all_colours_and_mirrored() -> None:
    """The likelier half, times six orders of the colours, times two."""
    fitted = frontal_lights(40, 0.05)
    fitted[0] *= 4
    lights = laboratory_training_lights(fitted)
    assert len(lights) == 20 * 12
    assert np.allclose(lights[:, :, 0].mean(axis=0), lights[:, :, 2].mean(axis=0))
    assert np.allclose(lights.mean(axis=0)[[3, 4, 7]], 0, atol=1e-12)
    assert np.abs(lights - fitted[0]).max(axis=(1, 2)).min() > 0.1


def stored_order(prior: LightPrior) -> tuple[Float, Float]:
    """Mean and deviations of a gray prior in the order and axes of the files."""
    turn = harmonics_from_mit_axes(np.eye(9)).T
    return turn @ prior.mean, np.sqrt(np.diag(turn @ prior.covariance @ turn.T))


# Retrained by the original program on the same files; the half of the natural lights is another.
NATURAL = (
    [-1.150, 0.019, 0.285, -0.335, -0.010, 0.005, 0.014, -0.037, -0.120],
    [0.400, 0.288, 0.289, 0.620, 0.285, 0.211, 0.420, 0.215, 0.384],
)
LABORATORY = (
    [-2.549, 0.000, 2.469, -0.144, 0.000, 0.000, -1.415, 0.061, 0.068],
    [0.617, 1.066, 0.965, 0.597, 0.186, 0.791, 0.980, 0.593, 0.217],
)


@pytest.mark.real_data
def test_priors_of_the_measured_lights(mit_berkeley_root: Path) -> None:
    """They agree with those of the original program, the natural ones within sampling error."""
    priors = light_priors(mit_berkeley_root)
    for kind, (mean, deviations), tolerance in (
        ("natural", NATURAL, 0.04),
        ("laboratory", LABORATORY, 0.0011),
    ):
        found_mean, found_deviations = stored_order(priors[kind, "gray"])
        assert np.allclose(found_mean, mean, atol=tolerance)
        assert np.allclose(found_deviations, deviations, atol=tolerance)
    assert priors["laboratory", "color"].count == 684
    assert 700 < priors["natural", "color"].count < 850


@pytest.mark.real_data
def test_released_gaussians_are_near_the_learned(data_root: Path, mit_berkeley_root: Path) -> None:
    """The laboratory's is the same; the natural one comes from another half of the lights."""
    if not (data_root / "boundary-cues").is_dir():
        pytest.skip("the data root holds no boundary-cues/")
    learned, released = light_priors(mit_berkeley_root), released_light_priors(data_root)
    ours, theirs = learned["laboratory", "color"], released["laboratory", "color"]
    assert ours.count == theirs.count
    assert np.allclose(ours.mean, theirs.mean, atol=1e-10)
    assert np.allclose(ours.covariance, theirs.covariance, atol=1e-10)
    ours, theirs = learned["natural", "color"], released["natural", "color"]
    assert np.abs(ours.mean - theirs.mean).max() < 0.05
    ratio = np.sqrt(np.diag(ours.covariance) / np.diag(theirs.covariance))
    assert np.abs(ratio - 1).max() < 0.1
