"""Depth in millimetres, its frames and units, and where a sensor's pixels lie."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from shading_model.arrays import Float
from shading_model.depth_map import DepthMap, Registration, median_of_known, same_window
from shading_model.errors import RelightlabError

readings = st.one_of(st.just(np.nan), st.floats(-100, 100))


@given(arrays(np.float64, st.tuples(st.integers(1, 7), st.just(4)), elements=readings))
def test_the_median_is_that_of_the_known_values(values: Float) -> None:
    """Column by column it agrees with NumPy's on what is not NaN."""
    for found, column in zip(median_of_known(values), values.T, strict=True):
        known = column[np.isfinite(column)]
        assert np.isclose(found, np.median(known)) if known.size else np.isnan(found)


def test_frames_are_merged_by_their_median() -> None:
    """A pixel is known if any frame has a reading, and a wild frame does not count."""
    frames = np.array([[[500.0, 0.0]], [[510.0, 0.0]], [[9000.0, 700.0]], [[0.0, np.nan]]])
    merged = DepthMap(frames, focal_length=500.0).known_mm
    assert np.array_equal(merged, [[510.0, 700.0]])
    lost = DepthMap(frames[:2], focal_length=500.0).known_mm
    assert np.isnan(lost[0, 1])


@settings(max_examples=25)
@given(st.floats(0.4, 9), st.floats(0, 5), st.floats(0, 5))
def test_averaging_loses_no_light(scale: float, above: float, left: float) -> None:
    """The sensor's pixels, without gaps, hold the sum of the picture when they cover it all."""
    picture = np.random.default_rng(0).random((13, 17))
    first = (scale - 1) / 2
    averaged = Registration(scale, first - above, first - left).average(picture, (60, 60))
    assert np.isclose(averaged.sum() * scale**2, picture.sum())


def test_coverage_is_the_share_of_area() -> None:
    """A sensor pixel cut in half by the outline is half covered; one beyond the picture is not."""
    mask = np.zeros((4, 6), bool)
    mask[:, 3:] = True
    coverage = Registration(2.0, 0.5, 0.5).coverage(mask, (2, 4))
    assert np.allclose(coverage, [[0, 0.5, 1, 0]] * 2)


@pytest.mark.parametrize(
    ("sensor", "picture", "scale"),
    [
        ((5, 7), (5, 7), 1),
        ((320, 241), (640, 482), 2),
        ((160, 120), (481, 361), 3),
        ((9, 8), (4, 4), 0.5),
    ],
)
def test_grids_of_one_window(
    sensor: tuple[int, int], picture: tuple[int, int], scale: float
) -> None:
    """Their corners coincide: the first sensor pixel's corner is the picture's."""
    place = same_window(sensor, picture)
    assert place.scale == scale
    assert place.row - scale / 2 == place.column - scale / 2 == -0.5


@pytest.mark.parametrize(
    ("sensor", "picture"), [((5, 7), (5, 8)), ((240, 320), (480, 720)), ((424, 512), (600, 600))]
)
def test_sizes_of_other_windows(sensor: tuple[int, int], picture: tuple[int, int]) -> None:
    """Both sizes are named."""
    words = f"{sensor[1]}x{sensor[0]} pixels and the mask {picture[1]}x{picture[0]}"
    with pytest.raises(RelightlabError, match=words):
        same_window(sensor, picture)


@pytest.mark.parametrize(
    ("depth", "words"),
    [
        (np.full((3, 3), 0.546), "as if it were in metres: multiply by 1000"),
        (np.full((3, 3), 54.6), "as if it were in centimetres: multiply by 10"),
        (np.full((3, 3), 54600.0), "between 200 and 10000.*5.46e.04: give it in millimetres"),
        (np.zeros((3, 3)), "no reading at all"),
        (np.full((3, 3), np.nan), "no reading at all"),
        (np.full((3, 3), -500.0), "negative or infinite"),
        (np.full((3, 3), np.inf), "negative or infinite"),
        (np.full(3, 500.0), r"of shape \(r, c\)"),
    ],
)
def test_depth_that_cannot_be_used(depth: Float, words: str) -> None:
    """Each gets one sentence; metres are recognised."""
    with pytest.raises(RelightlabError, match=words):
        DepthMap(depth, focal_length=500.0)


@pytest.mark.parametrize("focal_length", [0.0, -1.0, np.nan])
def test_focal_lengths_that_cannot_be(focal_length: float) -> None:
    """A focal length is above zero."""
    with pytest.raises(RelightlabError, match="focal length"):
        DepthMap(np.full((3, 3), 500.0), focal_length)
