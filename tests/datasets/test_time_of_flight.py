"""The simulated time-of-flight sensor: the truth when ideal, its stated errors when not."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from datasets.time_of_flight import (
    IDEAL,
    KINECT_II,
    TimeOfFlightSensor,
    deviation_mm,
    simulate_time_of_flight,
)
from shading_model.arrays import Float, Map, Mask
from shading_model.depth_cleaning import AS_MEASURED
from shading_model.errors import RelightlabError
from shading_model.seeds import generator_for
from shading_model.sensor_shape import shape_from_depth
from tests.shading_model.outlines import angles, dome

CLEAN = replace(KINECT_II, noise_mm=0.0, blur=0.0, interreflection=0.0, dark_mm=0.0, step_mm=0.0)
"""The sensor's pixels, and no other fault."""


def read(
    height: Map,
    mask: Mask,
    sensor: TimeOfFlightSensor,
    albedo: Float | None = None,
    seed: int = 0,
) -> Map:
    """Return the readings of a sensor; of a uniform albedo if none is given."""
    uniform = np.ones(mask.shape) if albedo is None else albedo
    return simulate_time_of_flight(height, mask, uniform, generator_for(seed), sensor).depth


def middle(readings: Map, half: int) -> Map:
    """Return the readings around the middle of the sensor's view."""
    rows, columns = (size // 2 for size in readings.shape)
    return readings[rows - half : rows + half, columns - half : columns + half]


@settings(max_examples=10)
@given(st.integers(0, 1000), st.floats(-0.5, 0.5))
def test_the_ideal_sensor_returns_the_truth(seed: int, lean: float) -> None:
    """On the picture's own pixels the heights come back to rounding, whatever the albedo."""
    mask, height, normals = dome(30)
    columns = np.arange(mask.shape[1])
    albedo = np.random.default_rng(seed).random((*mask.shape, 3))
    truth = height + lean * columns
    reading = simulate_time_of_flight(truth, mask, albedo, generator_for(seed), IDEAL)
    shape = shape_from_depth(reading, mask, AS_MEASURED)
    assert np.allclose(shape.height[mask], (truth - np.median(truth[mask]))[mask], atol=1e-8)
    if lean == 0:
        assert angles(shape.normals, normals, mask).mean() < 0.2


@pytest.mark.parametrize(
    ("slant", "distance_mm", "dark"),
    [(0.0, 1000, 1.0), (1.0, 1000, 1.0), (0.0, 2000, 1.0), (0.5, 1500, 0.5)],
)
def test_noise_has_the_stated_deviation(slant: float, distance_mm: float, dark: float) -> None:
    """On planes it is inversely proportional to albedo, cosine and 1 / squared distance."""
    mask = np.ones((200, 200), bool)
    albedo = np.ones(mask.shape)
    albedo[:, :100] = dark
    height = np.broadcast_to(slant * np.arange(200.0)[:, None], mask.shape)
    sensor = replace(
        KINECT_II, focal_length=None, object_mm=50.0, distance_mm=distance_mm, wall_mm=4000.0,
        blur=0.0, interreflection=0.0, dark_mm=0.0, step_mm=0.0,
    )  # fmt: skip
    noisy = read(height, mask, sensor, albedo)
    noise = noisy - read(height, mask, replace(sensor, noise_mm=0.0), albedo)
    cosine = 1 / np.hypot(1, slant)
    light = dark / ((1 + dark) / 2) * cosine * (1000 / distance_mm) ** 2
    dark_part = noise[5:-5, 5:95]
    assert dark_part.std() == pytest.approx(1.5 / light, rel=0.05)
    assert abs(dark_part.mean()) < 4 * 1.5 / light / np.sqrt(dark_part.size)
    assert deviation_mm(np.array(light), sensor) == pytest.approx(1.5 / light)


def test_readings_are_multiples_of_the_step() -> None:
    """Whole millimetres by default, another step if told, and never off by more than half."""
    mask, height, _ = dome(60)
    for step in (1.0, 4.0):
        sensor = replace(CLEAN, step_mm=step)
        readings = read(height, mask, sensor)
        assert np.array_equal(readings, np.round(readings / step) * step)
        known = readings > 0
        assert np.abs(readings - read(height, mask, CLEAN))[known].max() <= step / 2
    assert len(np.unique(readings)) < len(np.unique(read(height, mask, CLEAN)))


def test_flying_pixels_lie_between_object_and_wall_and_only_at_the_outline() -> None:
    """A flat object: every reading off both surfaces is of a pixel that the outline cuts."""
    mask, *_ = dome(60)
    reading = simulate_time_of_flight(
        np.zeros(mask.shape), mask, mask * 1.0, generator_for(), CLEAN
    )
    place = reading.registration_to(mask)
    coverage = place.coverage(mask, reading.depth.shape)
    flying = (np.abs(reading.depth - 1000) > 1e-6) & (np.abs(reading.depth - 1500) > 1e-6)
    assert (flying == ((coverage > 1e-9) & (coverage < 1 - 1e-9))).all()
    assert flying.sum() > 100
    assert 1000 < reading.depth[flying].min() < 1050
    assert 1400 < reading.depth[flying].max() < 1500
    half = np.abs(coverage - 0.5) < 0.05
    # The object's half gives 2.25 times the light of the wall's, by the squared distances.
    assert np.median(reading.depth[half]) == pytest.approx((2.25 * 1000 + 1500) / 3.25, abs=20)


def test_hollows_read_farther_and_bumps_do_not() -> None:
    """Interreflection adds millimetres all over a bowl, and nothing to a dome."""
    mask, height, _ = dome(60)
    sensor = replace(CLEAN, interreflection=1.0)
    for sign, most in ((1, 0.1), (-1, 10.0)):
        added = middle(read(sign * height, mask, sensor) - read(sign * height, mask, CLEAN), 25)
        assert added.min() >= 0
        assert added.max() < most
    assert added.min() > 0.5


def test_dark_places_read_farther() -> None:
    """A plane that is black on one side reads farther there, by at most the stated offset."""
    mask = np.ones((100, 100), bool)
    albedo = np.where(np.arange(100) < 50, 0.1, 1.0) * mask
    sensor = replace(CLEAN, dark_mm=3.0, focal_length=None)
    readings = read(np.zeros(mask.shape), mask, sensor, albedo)
    relative = 0.1 / 0.55
    assert readings[50, 10] == pytest.approx(1000 + 3 * (1 - relative))
    assert readings[50, 90] == pytest.approx(1000)


def test_readings_are_lost_at_grazing_angles_and_without_light() -> None:
    """A roof of 85 degrees and a black patch have no reading; the rest has."""
    mask = np.ones((120, 120), bool)
    columns = np.arange(120.0)
    steep = np.where(columns > 60, (columns - 60) * np.tan(np.radians(85)), 0.0) / 20 * mask
    lost = read(steep * 20, mask, replace(CLEAN, focal_length=None, object_mm=20.0))
    assert (lost[5:-5, 65:115] == 0).all()
    assert (lost[5:-5, 5:55] > 0).all()
    albedo = np.where(columns < 60, 0.0, 1.0) * mask
    black = read(np.zeros(mask.shape), mask, replace(CLEAN, focal_length=None), albedo)
    assert (black[:, :60] == 0).all()
    assert (black[:, 60:] > 0).all()


def test_readings_outside_the_range_are_lost() -> None:
    """An object nearer than half a metre is not seen, and the wall behind it is."""
    mask, height, _ = dome(60)
    readings = read(height, mask, replace(CLEAN, distance_mm=400.0))
    assert (middle(readings, 10) == 0).all()
    assert readings[0, 0] == 1500


def test_unknown_heights_have_no_reading() -> None:
    """A pixel of the mask without a height is a hole, not the wall."""
    mask, height, _ = dome(20)
    height[20:24, 20:24] = np.nan
    readings = read(height, mask, IDEAL)
    assert (readings[20:24, 20:24] == 0).all()
    assert np.count_nonzero(readings[mask] == 0) == 16


def test_the_same_seed_gives_the_same_bytes() -> None:
    """Readings depend on the generator alone."""
    mask, height, _ = dome(60)
    first, again, other = (read(height, mask, KINECT_II, seed=seed) for seed in (1, 1, 2))
    assert first.tobytes() == again.tobytes()
    assert first.tobytes() != other.tobytes()


def test_the_sensor_sees_few_pixels_of_the_object() -> None:
    """20 cm at one metre are 73 of its pixels, and lie in the middle of its view."""
    mask, height, _ = dome(100)
    reading = simulate_time_of_flight(height, mask, mask * 1.0, generator_for(), KINECT_II)
    assert reading.depth.shape == (424, 512)
    coverage = reading.registration_to(mask).coverage(mask, reading.depth.shape)
    rows, columns = np.nonzero(coverage > 0.5)
    assert np.ptp(rows) + 1 == pytest.approx(73, abs=1)
    assert (rows.min() + rows.max()) / 2 == pytest.approx(211.5, abs=0.5)
    assert (columns.min() + columns.max()) / 2 == pytest.approx(255.5, abs=0.5)


def test_a_real_sensor_is_worse_than_an_ideal_one_and_better_than_nothing() -> None:
    """With default cleaning the normals of a dome are some degrees off, far from a flat shape."""
    mask, height, normals = dome(100)
    reading = simulate_time_of_flight(height, mask, mask * 1.0, generator_for(), KINECT_II)
    off = angles(shape_from_depth(reading, mask).normals, normals, mask).mean()
    assert 1 < off < 10


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"height": np.full((9, 9), np.nan)}, "no height of the object is known"),
        ({"height": np.zeros((9, 8))}, r"heights of shape \(h, w\)"),
        ({"albedo": np.ones((8, 9))}, r"albedos of shape \(h, w\)"),
        ({"albedo": np.zeros((9, 9))}, "not black"),
        ({"albedo": -np.ones((9, 9))}, "not negative"),
        ({"albedo": np.full((9, 9), np.nan)}, "known"),
        ({"mask": np.zeros((9, 9), bool)}, "mask is empty"),
        ({"sensor": replace(KINECT_II, object_mm=2000.0)}, "does not fit into a view of 512x424"),
    ],
)
def test_scenes_that_cannot_be_simulated(change: dict[str, Any], words: str) -> None:
    """Each gets one sentence."""
    scene = {"height": np.zeros((9, 9)), "mask": np.ones((9, 9), bool), "albedo": np.ones((9, 9))}
    with pytest.raises(RelightlabError, match=words):
        simulate_time_of_flight(**(scene | {"generator": generator_for()} | change))


def test_a_simulation_takes_less_than_a_fifth_of_a_second() -> None:
    """600 x 600 pixels; the best of three runs, for busy machines."""
    mask, height, _ = dome(298)
    albedo = np.random.default_rng(0).uniform(0.1, 1, (*mask.shape, 3))
    seconds = []
    for _ in range(3):
        start = time.perf_counter()
        reading = simulate_time_of_flight(height, mask, albedo, generator_for())
        between = time.perf_counter()
        shape_from_depth(reading, mask)
        seconds.append((between - start, time.perf_counter() - between))
    assert min(first for first, _ in seconds) < 0.4  # 0.2 s are asked for on an idle core
    assert min(second for _, second in seconds) < 0.4
