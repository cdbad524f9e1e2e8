"""Environment maps projected to lights, and the shipped table."""

from __future__ import annotations

import json
import math
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from datasets.environment_maps import (
    TABLE_NAME,
    directions,
    irradiance_harmonics,
    lights_of_map,
    main,
    make_table,
    shipped_lights,
)
from datasets.openexr_files import write_openexr
from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from shading_model.harmonic_conversion import visible_normals

LAMP_RADIUS = 12 * math.pi / 256


@pytest.fixture
def map_folder(data_root: Path) -> Path:
    """The environment maps under the data root; skips where it has none."""
    folder = data_root / "hdri"
    if not folder.is_dir():
        pytest.skip(f"{data_root} holds no hdri/")
    return folder


def lamp(direction: tuple[float, float, float], height: int = 256) -> Float:
    """A map that is black but for a small white lamp in the given direction."""
    cosine = directions(height, 2 * height) @ np.array(direction)
    return np.where(cosine[..., None] > math.cos(LAMP_RADIUS), 1.0, np.zeros(3))


def test_directions_are_unit_and_turn_to_the_right() -> None:
    """Top is up, the centre lies behind the object, right of it lies to the right."""
    found = directions(180, 360)
    np.testing.assert_allclose(np.linalg.norm(found, axis=-1), 1.0, atol=1e-12)
    np.testing.assert_allclose(found[0, 0], [0, 1, 0], atol=0.02)
    np.testing.assert_allclose(found[90, 180], [0, 0, -1], atol=0.02)
    np.testing.assert_allclose(found[90, 270], [1, 0, 0], atol=0.02)


def test_a_white_sky_gives_irradiance_pi() -> None:
    """Radiance one from everywhere is irradiance pi on every normal, to the constants' digits."""
    light = irradiance_harmonics(np.ones((64, 128, 3)))
    np.testing.assert_allclose(light.shade(visible_normals()), math.pi, atol=1e-3)


@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0.0, 0.8)])
def test_a_lamp_is_brightest_on_the_surface_that_faces_it(
    direction: tuple[float, float, float],
) -> None:
    """The irradiance of a lamp is largest, near its closed form, on the normal toward it."""
    light = irradiance_harmonics(lamp(direction))
    solid_angle = 2 * math.pi * (1 - math.cos(LAMP_RADIUS))
    facing = light.shade(np.array([direction]))[0, 0]
    assert light.shade(visible_normals()).max() <= facing * 1.01
    # Nine harmonics give a lamp 17/16 of its cosine lobe's peak.
    assert facing == pytest.approx(solid_angle * 17 / 16, rel=0.03)


def test_lights_peak_at_one_and_turn_with_the_map() -> None:
    """Every light peaks at shading 1; four turns of a map are four rolls of its columns."""
    radiance = np.random.default_rng(0).random((32, 64, 3)) ** 4
    turned = lights_of_map(radiance, turns=4)
    rolled = lights_of_map(np.roll(radiance, -16, axis=1), turns=4)
    for light in turned:
        assert light.shade(visible_normals()).max() == pytest.approx(1.0)
    np.testing.assert_allclose(rolled[0].coefficients, turned[1].coefficients, atol=1e-6)


@pytest.mark.parametrize("shape", [(8, 16), (8, 8, 3), (8, 16, 4)])
def test_a_map_of_another_shape_is_refused(shape: tuple[int, ...]) -> None:
    """Only an RGB map twice as wide as high covers the sphere."""
    with pytest.raises(RelightlabError, match="expected an equirectangular map"):
        irradiance_harmonics(np.ones(shape))


def test_bad_radiance_is_refused() -> None:
    """NaN poisons a light, and a black map gives none; small negatives count as zero."""
    with pytest.raises(RelightlabError, match="NaN or infinite"):
        irradiance_harmonics(np.full((8, 16, 3), np.nan))
    with pytest.raises(RelightlabError, match="dark on every visible normal"):
        lights_of_map(np.zeros((8, 16, 3)))
    np.testing.assert_array_equal(irradiance_harmonics(-np.ones((8, 16, 3))).coefficients, 0.0)


def test_the_command_writes_the_same_bytes_twice(tmp_path: Path) -> None:
    """Two runs over one folder give one file, sorted by name, with its provenance."""
    for name, direction in (("b", (0, 0, 1)), ("a", (0, 1, 0))):
        write_openexr(tmp_path / f"{name}.exr", lamp(direction, 16) + 0.01)
    for out in ("one.json", "two.json"):
        main([str(tmp_path), "--out", str(tmp_path / out)])
    text = (tmp_path / "one.json").read_text()
    assert text == (tmp_path / "two.json").read_text()
    table = json.loads(text)
    assert [row["map"] for row in table["lights"][::5]] == ["a", "b"]
    assert table["provenance"]["licence"] == "CC0-1.0"


def test_a_folder_without_maps_is_refused(tmp_path: Path) -> None:
    """An empty folder gives one sentence and no table."""
    with pytest.raises(RelightlabError, match="found none"):
        main([str(tmp_path), "--out", str(tmp_path / "table.json")])
    assert list(tmp_path.iterdir()) == []


def test_the_shipped_pool_resembles_natural_lights() -> None:
    """Ninety lights that peak at 1, with mean shading and contrast of the measured pool's order."""
    lights = shipped_lights()
    shading = np.array([light.shade(visible_normals()) for light in lights])
    assert len(lights) == 90
    np.testing.assert_allclose(shading.max(axis=(1, 2)), 1.0, atol=1e-4)
    gray = shading.mean(axis=2)
    assert 0.4 < np.median(gray.mean(axis=1)) < 0.6
    assert 0.25 < np.median(gray.std(axis=1) / gray.mean(axis=1)) < 0.45


@pytest.mark.slow
@pytest.mark.real_data
def test_the_maps_give_the_shipped_table(map_folder: Path) -> None:
    """The eighteen CC0 maps, projected again, give the table to its last digit or two."""
    made = json.loads(make_table(sorted(map_folder.glob("*.exr"))))
    shipped = json.loads(resources.files("datasets").joinpath(TABLE_NAME).read_text("utf-8"))
    assert made["provenance"] == shipped["provenance"]
    for ours, theirs in zip(made["lights"], shipped["lights"], strict=True):
        assert {k: ours[k] for k in ("map", "sha256", "degrees")} == {
            k: theirs[k] for k in ("map", "sha256", "degrees")
        }
        np.testing.assert_allclose(ours["log"], theirs["log"], rtol=0, atol=5e-6)
