"""The base shape of a depth sensor: registration, outliers, holes, smoothing, units."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from datasets.image_files import read_linear_png, read_mask
from shading_model.arrays import Map, Mask
from shading_model.depth_cleaning import AS_MEASURED, Cleaning
from shading_model.depth_map import DepthMap, Registration
from shading_model.errors import RelightlabError
from shading_model.sensor_shape import shape_from_depth
from tests.shading_model.outlines import angles, disk, dome

FOCAL = 1000.0
DISTANCE = 800.0


def depth_of(height: Map) -> Map:
    """Return the depth in millimetres of a height in pixels with median zero."""
    return DISTANCE - height * DISTANCE / FOCAL


def plane(mask: Mask, right: float, down: float) -> Map:
    """Return a plane's height over a mask, its median zero."""
    rows, columns = np.indices(mask.shape, dtype=float)
    height = np.where(mask, right * columns + down * rows, np.nan)
    return height - np.nanmedian(height)


def test_a_dome_measured_without_noise_comes_back() -> None:
    """Height to rounding; normals to half a degree inside and within the outline's last pixel."""
    mask, height, normals = dome(60)
    shape = shape_from_depth(DepthMap(depth_of(np.nan_to_num(height)), FOCAL), mask, AS_MEASURED)
    relative = height - np.median(height[mask])
    # The median depth, which sets the pixel's width, is that of the median height.
    expected = relative * DISTANCE / (DISTANCE - np.median(height[mask]) * DISTANCE / FOCAL)
    assert np.allclose(shape.height[mask], expected[mask], atol=1e-9)
    flat = DepthMap(depth_of(np.nan_to_num(relative)), FOCAL)
    exact = shape_from_depth(flat, mask, AS_MEASURED)
    assert np.allclose(exact.height[mask], relative[mask], atol=1e-9)
    off = angles(exact.normals, normals, mask)
    assert off.mean() < 0.1
    assert off.max() < 2


def test_a_coarse_grid_is_set_on_the_picture() -> None:
    """A dome seen by pixels five times as large keeps its heights and normals."""
    mask, height, normals = dome(60)
    height -= np.median(height[mask])
    place = Registration(5.0, 1.3, 0.4)
    shape_of_sensor = (26, 26)
    coverage = place.coverage(mask, shape_of_sensor)
    total = place.average(np.where(mask, depth_of(height), 0), shape_of_sensor)
    coarse = np.divide(total, coverage, out=np.zeros_like(total), where=coverage > 0)
    shape = shape_from_depth(DepthMap(coarse, FOCAL, place), mask, AS_MEASURED)
    off = (shape.height - height)[mask]
    # Pixels that the outline cuts see the inner part of theirs, where the dome is higher.
    assert np.abs(off).max() < 2
    assert np.abs(off).mean() < 0.2
    assert angles(shape.normals, normals, mask).mean() < 1.5


@settings(max_examples=10)
@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.integers(0, 100))
def test_a_plane_is_filled_exactly(right: float, down: float, seed: int) -> None:
    """With 60 per cent of the readings lost at random and default cleaning, a plane is a plane."""
    mask, *_ = disk(18)
    height = plane(mask, right, down)
    depth = depth_of(np.nan_to_num(height))
    places = np.flatnonzero(mask)
    lost = np.random.default_rng(seed).permutation(places)[: int(0.6 * len(places))]
    depth.ravel()[lost] = 0.0
    shape = shape_from_depth(DepthMap(depth, FOCAL), mask)
    assert np.allclose(shape.height[mask], height[mask], rtol=1e-3, atol=1e-3)
    assert angles(shape.normals, plane_normals(mask, right, down), mask).max() < 0.1


def plane_normals(mask: Mask, right: float, down: float) -> Map:
    """Return a plane's normals all over a picture."""
    normal = np.array([-right, down, 1.0])
    return np.tile(normal / np.linalg.norm(normal), (*mask.shape, 1))


def test_one_large_hole_in_a_quadratic_is_filled_exactly() -> None:
    """A saddle and a bowl keep their form over a hole of half the object."""
    mask, x, y = disk(20)
    hole = np.hypot(x, y) < np.sqrt(0.5)
    for height in (8 * (x**2 - y**2) + 3 * x, 6 * (x**2 + y**2) - 2 * x * y):
        level = height - np.median(height[mask])
        depth = np.where(mask & ~hole, depth_of(level), 0.0)
        shape = shape_from_depth(DepthMap(depth, FOCAL), mask, AS_MEASURED)
        assert np.allclose(shape.height[mask], level[mask], atol=1e-4)


def test_too_large_holes_are_refused() -> None:
    """Sixty per cent is filled; more is told, whether it is lost or out of the sensor's view."""
    mask = np.ones((10, 10), bool)
    depth = np.full((10, 10), 500.0)
    depth[:6] = 0.0
    assert np.allclose(shape_from_depth(DepthMap(depth, FOCAL), mask).height, 0)
    depth[6, :3] = 0.0
    with pytest.raises(RelightlabError, match="no reading on 63 per cent of the object"):
        shape_from_depth(DepthMap(depth, FOCAL), mask)
    aside = DepthMap(np.full((10, 10), 500.0), FOCAL, Registration(1.0, 0.0, 100.0))
    with pytest.raises(RelightlabError, match="no reading on 100 per cent of the object"):
        shape_from_depth(aside, mask)


def test_sizes_that_do_not_belong_together_are_refused() -> None:
    """A depth map of another window is not stretched."""
    with pytest.raises(RelightlabError, match="not one window"):
        shape_from_depth(DepthMap(np.full((9, 9), 500.0), FOCAL), np.ones((9, 11), bool))


def test_flying_pixels_and_wild_readings_are_thrown_away() -> None:
    """Readings half way to the wall, at the outline and inside, leave a plane as it was."""
    mask, *_ = disk(30)
    height = plane(mask, 0.3, 0.2)
    depth = depth_of(np.nan_to_num(height))
    expected = shape_from_depth(DepthMap(depth, FOCAL), mask)
    rim = mask & ~(disk(29, margin=3)[0])
    depth[rim] += np.random.default_rng(3).uniform(0, 400, np.count_nonzero(rim))
    depth[25, 30] = depth[40, 22] = 2000.0
    cleaned = shape_from_depth(DepthMap(depth, FOCAL), mask)
    assert angles(cleaned.normals, expected.normals, mask).max() < 0.5
    believed = shape_from_depth(DepthMap(depth, FOCAL), mask, AS_MEASURED)
    assert angles(believed.normals, expected.normals, mask).max() > 45


def test_outliers_inside_are_found_without_a_rim() -> None:
    """The median test alone removes a wild reading, and leaves a steep plane whole."""
    mask = np.ones((20, 20), bool)
    height = plane(mask, 3.0, 0.0)
    depth = depth_of(height)
    depth[10, 10] += 60
    cleaning = Cleaning(least_coverage=0.5, rim=0, smoothing=0.0)
    shape = shape_from_depth(DepthMap(depth, FOCAL), mask, cleaning)
    assert np.allclose(shape.height, height, atol=1e-3)


def test_every_pixel_of_thin_and_separate_parts_is_known() -> None:
    """Lines and lone pixels, which no sensor pixel sees well, get finite heights and normals."""
    mask = np.zeros((60, 60), bool)
    mask[10:40, 10:40] = mask[50, 5:55] = mask[3, 3] = True
    place = Registration(4.0, 1.5, 1.5)
    readings = np.random.default_rng(0).normal(600, 2, (15, 15))
    shape = shape_from_depth(DepthMap(readings, FOCAL, place), mask)
    assert np.isfinite(shape.height[mask]).all()
    assert np.allclose(np.linalg.norm(shape.normals[mask], axis=-1), 1)
    assert np.isnan(shape.height[~mask]).all()
    thin = mask & (np.arange(60)[:, None] > 45)
    assert np.isfinite(shape_from_depth(DepthMap(readings, FOCAL, place), thin).height[thin]).all()


def test_an_object_takes_less_than_a_fifth_of_a_second() -> None:
    """600 x 600 pixels, each with a reading; the best of three runs, for busy machines."""
    mask, height, _ = dome(298)
    depth = DepthMap(depth_of(np.nan_to_num(height / 4)), FOCAL)
    seconds = []
    for _ in range(3):
        start = time.perf_counter()
        shape_from_depth(depth, mask)
        seconds.append(time.perf_counter() - start)
    assert min(seconds) < 0.4  # 0.15 s on an idle core


@pytest.mark.real_data
def test_a_measured_object(data_root: Path) -> None:
    """The mitten: median depth, share of known pixels, and a shape that is finite all over."""
    folder = data_root / "rgbd-mitten"
    if not folder.is_dir():
        pytest.skip(f"{data_root} holds no rgbd-mitten/")
    mask = read_mask(folder / "mask.png")
    frames = [read_linear_png(folder / f"depth_{k:02d}.png") for k in range(1, 21)]
    stack = np.stack(frames) * 9870
    one = DepthMap(stack[0], 1216.73)
    place = one.registration_to(mask)
    on_object = place.coverage(mask, one.known_mm.shape) >= 0.5
    assert abs(np.nanmedian(one.known_mm[on_object]) - 546) < 2
    assert abs(np.isfinite(one.known_mm[on_object]).mean() - 0.968) < 0.003
    shape = shape_from_depth(DepthMap(stack, 1216.73), mask)
    assert np.isfinite(shape.height[mask]).all()
    assert np.isfinite(shape.normals[mask]).all()
    # The mitten is 2 to 10 cm thick, at 0.45 mm a pixel.
    assert 20 < np.ptp(np.percentile(shape.height[mask], [2, 98])) * 546 / 1216.73 < 100
