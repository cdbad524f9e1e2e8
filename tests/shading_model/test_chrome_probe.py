"""The direction of a light from its highlight on a mirror sphere."""

from __future__ import annotations

import re
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shading_model.arrays import Image
from shading_model.chrome_probe import chrome_direction, mirrored
from shading_model.errors import RelightlabError
from tests.shading_model.probe_pictures import chrome_picture, degrees_between, sphere_mask
from tests.shading_model.psm_pictures import light_directions, mask_of, picture_of, psm_uw

MASK = sphere_mask()


def spot(row: int, column: int, half: int = 1, brightness: float = 1.0) -> Image:
    """Return a dim picture with a bright square."""
    picture = np.full((90, 120), 0.05)
    picture[row - half : row + half + 1, column - half : column + half + 1] = brightness
    return picture


@settings(max_examples=40)
@given(st.floats(0, 1.9), st.floats(-3.1, 3.1))
def test_a_light_is_found_to_a_pixels_worth(tilt: float, turn: float) -> None:
    """A saturated highlight of a known direction, in front or far to the side, is found again."""
    direction = np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
    probe = chrome_direction(chrome_picture(direction, MASK, 0.1), MASK)
    assert degrees_between(probe.direction, direction) < probe.degrees_per_pixel
    assert probe.area >= 3
    assert probe.share == 1.0


@given(st.floats(-0.7, 0.7), st.floats(-0.7, 0.7))
def test_a_mirror_halves_the_angle(x: float, y: float) -> None:
    """The normal is half way between the viewer and the light, in their plane."""
    normal = np.array([x, y, np.sqrt(1 - x * x - y * y)])
    light = mirrored(normal)
    assert np.linalg.norm(light) == pytest.approx(1)
    np.testing.assert_allclose(light @ normal, normal[2], atol=1e-12)
    half = light + np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(half / np.linalg.norm(half), normal, atol=1e-9)


def test_where_the_highlight_is() -> None:
    """Centre, area and direction of a square highlight right of and above the centre."""
    probe = chrome_direction(spot(30, 70), MASK)
    assert (probe.row, probe.column, probe.area) == (pytest.approx(30), pytest.approx(70), 9)
    assert probe.direction[0] > 0
    assert probe.direction[1] > 0
    np.testing.assert_allclose(probe.direction, mirrored(probe.normal))


def test_exposure_and_lesser_lights_do_not_matter() -> None:
    """A darker picture, a weaker highlight elsewhere and a bright background change nothing."""
    plain = chrome_direction(spot(30, 70), MASK)
    second = np.maximum(spot(30, 70), spot(60, 50, brightness=0.45))
    second[~MASK] = 1.0
    for picture in (0.01 * spot(30, 70), second):
        np.testing.assert_allclose(
            chrome_direction(picture, MASK).direction, plain.direction, atol=1e-12
        )


def test_a_defect_of_the_sensor_is_passed_over() -> None:
    """One white pixel elsewhere weighs less than a highlight of nine."""
    picture = spot(30, 70)
    picture[55, 45] = 1.0
    probe = chrome_direction(picture, MASK)
    assert (round(probe.row), round(probe.column)) == (30, 70)
    assert 0.85 < probe.share < 0.95


@pytest.mark.parametrize(
    ("image", "options", "words"),
    [
        (np.full((90, 120), 0.5), {}, "no distinct highlight: 100 % of the sphere"),
        (spot(40, 60, 12), {}, "no distinct highlight: 15 % of the sphere"),
        (spot(30, 70, 0), {}, "the brightest region has 1 of 3 pixels"),
        (np.maximum(spot(30, 70), spot(55, 45)), {}, "the brightest of 2 bright regions holds 50"),
        (np.zeros((90, 120)), {}, "black all over the mask"),
        (np.full((90, 100), 0.5), {}, "the photograph is 100x90 pixels but its mask is 120x90"),
        (np.full((90, 120), np.nan), {}, "NaN or infinite pixels"),
        (spot(30, 70), {"threshold": 1.0}, "expected a threshold above 0 and below 1"),
        (spot(30, 70), {"border": 1.0}, "the sphere is too small"),
    ],
)
def test_pictures_without_a_highlight(image: Image, options: dict[str, float], words: str) -> None:
    """Each gets one sentence that says what was found instead."""
    with pytest.raises(RelightlabError, match=re.escape(words)):
        chrome_direction(image, MASK, **options)  # type: ignore[arg-type]


def test_a_matt_sphere_has_no_highlight() -> None:
    """Noise and a smooth shading are refused, too."""
    rng = np.random.default_rng(0)
    ramp = np.tile(np.linspace(0.1, 1.0, 120), (90, 1))
    for picture in (rng.random((90, 120)), ramp):
        with pytest.raises(RelightlabError, match="no distinct highlight"):
            chrome_direction(picture, MASK)


def test_the_search_is_quick() -> None:
    """A sphere in a picture of 512x340 takes about 0.02 s; a busy machine more."""
    mask = sphere_mask((340, 512), (147.8, 253.3), 119.5)
    picture = chrome_picture(np.array([0.48, 0.6, 0.64]), mask)
    times = []
    for _ in range(3):
        started = time.perf_counter()
        chrome_direction(picture, mask)
        times.append(time.perf_counter() - started)
    assert min(times) < 0.2


@pytest.mark.real_data
def test_the_chrome_sphere_of_psm_uw(data_root: Path) -> None:
    """Twelve highlights of about 110 pixels agree with lights.txt to 3.1 degrees on average.

    Measured: 1.2 to 8.5 degrees, the most for the second light; the gray sphere disagrees with the
    file there as well (5.5 degrees), and agrees with the highlight to 3.1.
    """
    folder = psm_uw(data_root)
    mask = mask_of(folder, "chrome")
    angles = []
    for index, stated in enumerate(light_directions(folder)):
        probe = chrome_direction(picture_of(folder, "chrome", index), mask)
        assert 80 < probe.area < 150
        assert probe.share > 0.99
        assert 0.95 < probe.degrees_per_pixel < 1.05
        angles.append(degrees_between(probe.direction, stated))
    assert max(angles) < 9
    assert np.mean(angles) < 3.4
    assert np.median(angles) < 2.5


@pytest.mark.real_data
def test_the_gray_sphere_of_psm_uw_is_no_mirror(data_root: Path) -> None:
    """A picture of the gray sphere has no highlight to be found."""
    folder = psm_uw(data_root)
    with pytest.raises(RelightlabError, match="no distinct highlight"):
        chrome_direction(picture_of(folder, "gray", 0), mask_of(folder, "gray"))
