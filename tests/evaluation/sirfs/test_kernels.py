"""Kernels, regions, pyramid and frames against plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.ndimage import convolve1d

from evaluation.sirfs.color_histogram_kernels import locate, smoothed_histogram, splat_color
from evaluation.sirfs.depth_term import DepthTerm
from evaluation.sirfs.framing import frame_around
from evaluation.sirfs.pair_kernels import LINES, difference_loss
from evaluation.sirfs.problem import Observation
from evaluation.sirfs.pyramid import Pyramid, level_count
from evaluation.sirfs.regions import PAIR_OFFSETS, outline_of, pair_runs, runs_of
from shading_model.errors import RelightlabError
from tests.evaluation.sirfs.toy_problems import ellipse

masks = arrays(bool, st.tuples(st.integers(1, 9), st.integers(1, 9)))


@given(masks)
def test_runs_cover_the_mask(mask: np.ndarray) -> None:
    """Runs are the mask, each pixel once."""
    covered = np.zeros(mask.shape, int)
    for row, start, stop in runs_of(mask):
        covered[row, start:stop] += 1
    np.testing.assert_array_equal(covered, mask)


@given(masks)
def test_pairs_are_all_pairs_of_the_window(mask: np.ndarray) -> None:
    """Pairs are all unordered pairs of mask pixels within two rows and columns."""
    found = {
        ((row, column), (row + down, column + right))
        for row, start, stop, down, right in pair_runs(mask)
        for column in range(start, stop)
    }
    pixels = list(zip(*np.nonzero(mask), strict=True))
    expected = {
        (a, b)
        for a in pixels
        for b in pixels
        if a < b and b[0] - a[0] <= 2 and abs(b[1] - a[1]) <= 2
    }
    assert found == expected
    assert len(PAIR_OFFSETS) == 12


def test_outline_of_a_disk_points_outward() -> None:
    """On a disk the outward directions are radial to eight degrees, as a window tells."""
    y, x = np.mgrid[-40:41, -40:41]
    outline = outline_of(np.hypot(x, y) < 30)
    radial = np.stack([outline.columns - 40, 40 - outline.rows], axis=-1)
    radial = radial / np.linalg.norm(radial, axis=-1, keepdims=True)
    assert (outline.outward * radial).sum(axis=-1).min() > np.cos(np.radians(8))


def test_outline_leaves_the_edge_of_the_picture_out() -> None:
    """Where the picture cuts an object there is no contour."""
    outline = outline_of(np.ones((30, 30), bool))
    assert outline.rows.size == 0


@given(st.integers(2, 23), st.integers(2, 23))
def test_pyramid_metric_is_symmetric_and_positive(rows: int, columns: int) -> None:
    """The metric is symmetric, and no less than the identity."""
    generator = np.random.default_rng(rows * 31 + columns)
    first, second = generator.normal(size=(2, rows, columns))
    pyramid, of_first, of_second = Pyramid((rows, columns)), np.empty_like(first), first.copy()
    pyramid.metric(first, of_first)
    pyramid.metric(second, of_second)
    assert np.vdot(second, of_first) == pytest.approx(np.vdot(first, of_second), rel=1e-9)
    assert np.vdot(first, of_first) >= np.vdot(first, first) * (1 - 1e-12)


def test_pyramid_metric_by_matrices() -> None:
    """The metric is T T' of the levels built from explicit decimating matrices."""

    def decimate(size: int) -> np.ndarray:
        matrix = np.zeros((-(-size // 2), size))
        for row in range(len(matrix)):
            for place, weight in zip(range(2 * row - 1, 2 * row + 3), (1, 3, 3, 1), strict=True):
                matrix[row, min(max(place, 0), size - 1)] += weight / np.sqrt(8)
        return matrix

    shape = (11, 13)
    first = np.kron(decimate(11), decimate(13))
    second = np.kron(decimate(6), decimate(7)) @ first
    spread = np.concatenate([np.eye(143), first, second]).T
    gradient, step = np.random.default_rng(0).normal(size=shape), np.empty(shape)
    Pyramid(shape).metric(gradient, step)
    assert level_count(shape) == 3
    np.testing.assert_allclose(step.ravel(), spread @ (spread.T @ gradient.ravel()))


def test_difference_loss_by_a_plain_loop() -> None:
    """The kernel of differences agrees with a loop over pairs, in value and gradient."""
    mask, generator = ellipse(), np.random.default_rng(4)
    values, table = generator.normal(size=mask.shape), np.sqrt(np.arange(60.0))
    gradient, expected, total = np.zeros(mask.shape), np.zeros(mask.shape), 0.0
    pairs, spacing, start, floor = pair_runs(mask), 0.05, -0.1, 0.01
    found = difference_loss(
        values, pairs, table, spacing, start, floor, gradient, np.zeros((LINES, mask.shape[1]))
    )
    for row, first, last, down, right in pairs:
        for column in range(first, last):
            change = values[row, column] - values[row + down, column + right]
            length = np.hypot(change, floor)
            place = (length - start) / spacing
            knot = min(int(place), 58)
            rise = table[knot + 1] - table[knot]
            total += table[knot] + rise * (place - knot)
            slope = rise / spacing * change / length
            expected[row, column] += slope
            expected[row + down, column + right] -= slope
    assert found == pytest.approx(total)
    np.testing.assert_allclose(gradient, expected, atol=1e-9)


def test_color_histogram_by_numpy() -> None:
    """The histogram holds every colour once, at its trilinear place, clamped at the ends."""
    generator = np.random.default_rng(6)
    values = 4.0 * generator.normal(size=(3, 20, 21))
    mask = ellipse((20, 21))
    runs, count = runs_of(mask), int(mask.sum())
    cells, shares = np.zeros((3, count), np.int32), np.zeros((3, count))
    corner, size = locate(values, runs, -7.0, 0.5, 23, cells, shares)
    histogram = np.zeros(tuple(size))
    splat_color(cells, shares, corner, histogram)
    assert histogram.sum() == pytest.approx(count)
    for axis in range(3):
        clipped = np.clip((values[axis][mask] + 7.0) / 0.5, 0, 22)
        others = tuple(k for k in range(3) if k != axis)
        knots = corner[axis] + np.arange(size[axis])
        mean = histogram.sum(axis=others) @ knots / count
        assert mean == pytest.approx(clipped.mean())


def test_smoothed_histogram_by_scipy() -> None:
    """Where rows are occupied the smoothed histogram is SciPy's separable convolution."""
    generator = np.random.default_rng(8)
    histogram = np.where(generator.random((7, 9, 8)) < 0.1, generator.random((7, 9, 8)), 0.0)
    kernel = np.array([0.1, 0.2, 0.4, 0.2, 0.1])
    expected = histogram
    for axis in range(3):
        expected = convolve1d(expected, kernel, axis=axis, mode="constant")
    occupied = histogram.any(axis=2)
    np.testing.assert_allclose(smoothed_histogram(histogram, kernel)[occupied], expected[occupied])


def test_halving_keeps_means_and_depth() -> None:
    """Half the resolution keeps a constant photograph, and depths become half as many pixels."""
    mask = ellipse()
    image = np.where(mask[..., None], 0.4, 0.0) * np.ones(3)
    depth = np.where(mask, 10.0, np.nan)
    half = Observation((image,), (mask,), mask, depth).halved()
    assert half.shape == (20, 24)
    assert half.scale == 2.0
    np.testing.assert_allclose(half.images[0][half.valid[0]], 0.4)
    assert np.nanmax(half.depth) == np.nanmin(half.depth) == 5.0


@given(st.integers(0, 30), st.integers(0, 30))
def test_frames_put_things_back(row: int, column: int) -> None:
    """What is cut out of a frame is pasted back in its place, NaN around it."""
    mask = np.zeros((60, 70), bool)
    mask[row : row + 9, column : column + 7] = True
    values = np.arange(4200.0).reshape(60, 70)
    frame = frame_around(mask, margin=5)
    pasted = frame.pasted(frame.cut(values))
    assert np.isfinite(pasted[mask]).all()
    known = np.isfinite(pasted)
    np.testing.assert_array_equal(pasted[known], values[known])
    assert known.any(axis=1).sum() <= 19


@pytest.mark.parametrize("blur", [0.0, 2.0])
def test_depth_term_has_the_gradient_of_differences(blur: float) -> None:
    """The pull of an external depth has the gradient of finite differences, with holes."""
    generator = np.random.default_rng(9)
    depth = np.where(generator.random((15, 17)) < 0.6, generator.normal(size=(15, 17)), np.nan)
    term = DepthTerm(depth, 3.0, 1.2, blur)
    height, along = generator.normal(size=(2, 15, 17))
    gradient = np.zeros((15, 17))
    term.add(height, gradient)
    above, below = (term.add(height + s * along, np.zeros((15, 17))) for s in (1e-6, -1e-6))
    assert np.vdot(gradient, along) == pytest.approx((above - below) / 2e-6, rel=1e-6)


def test_depth_term_refuses_nonsense() -> None:
    """A depth that is known nowhere and a negative blur are refused."""
    with pytest.raises(RelightlabError, match="known nowhere"):
        DepthTerm(np.full((2, 2), np.nan), 1.0, 1.0)
    with pytest.raises(RelightlabError, match="at least 0 pixels"):
        DepthTerm(np.zeros((2, 2)), 1.0, 1.0, blur=-1.0)
