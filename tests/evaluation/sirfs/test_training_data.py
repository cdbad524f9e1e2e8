"""Samples that the priors are learned from."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from datasets.mit_berkeley import MitBerkeley
from evaluation.sirfs.training_data import (
    OFFSETS,
    draw,
    filled_height,
    mean_curvature,
    neighbor_differences,
    training_samples,
)
from shading_model.errors import RelightlabError
from tests.datasets.mit_miniature import write_miniature


@given(st.integers(1, 6), st.integers(1, 6), st.integers(0, 1000))
def test_all_pairs_of_a_window_are_compared(height: int, width: int, seed: int) -> None:
    """Every unordered pair of valid pixels at most two rows and columns apart, once."""
    generator = np.random.default_rng(seed)
    values, valid = generator.normal(size=(height, width)), generator.random((height, width)) < 0.7
    pixels = list(zip(*np.nonzero(valid), strict=True))
    expected = [
        abs(values[one] - values[other])
        for one, other in combinations(pixels, 2)
        if abs(one[0] - other[0]) <= 2 and abs(one[1] - other[1]) <= 2
    ]
    found = np.abs(neighbor_differences(values, valid))
    assert np.allclose(np.sort(found), np.sort(expected))


def test_twelve_offsets() -> None:
    """Half of the 24 neighbours in a 5x5 window; the other half is their mirror image."""
    assert len(set(OFFSETS) | {(-down, -right) for down, right in OFFSETS}) == 24


def test_differences_of_colors_keep_their_channels() -> None:
    """A colour's difference is that of each channel."""
    values = np.random.default_rng(0).normal(size=(4, 5, 3))
    valid = np.ones((4, 5), dtype=bool)
    found = neighbor_differences(values, valid)
    assert np.array_equal(found[:, 1], neighbor_differences(values[..., 1], valid))


def test_draws_are_without_replacement() -> None:
    """No value twice, and all where there are few."""
    drawn = draw(np.arange(100.0), 30, np.random.default_rng(0))
    assert np.unique(drawn).size == 30
    assert draw(np.arange(10.0), 30, np.random.default_rng(0)).size == 10


def test_curvature_of_a_paraboloid() -> None:
    """At its top, half the sum of the two second derivatives; bulging out is negative."""
    y, x = np.mgrid[-4.0:5.0, -4.0:5.0]
    curvature = mean_curvature(-0.5 * (0.02 * x**2 + 0.06 * y**2))
    assert np.isclose(curvature[4, 4], -0.04)


def test_curvature_of_a_sphere_is_one_over_its_radius() -> None:
    """Away from the rim, at all slopes and directions."""
    y, x = np.mgrid[-60.0:61.0, -60.0:61.0]
    curvature = mean_curvature(np.sqrt(np.maximum(100.0**2 - x**2 - y**2, 0.0)))
    inside = x**2 + y**2 < 55**2
    assert np.allclose(curvature[inside], -0.01, rtol=0.01)


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_planes_are_not_curved(right: float, down: float) -> None:
    """However they lean."""
    y, x = np.mgrid[0.0:5.0, 0.0:6.0]
    inner = mean_curvature(right * x + down * y)[1:-1, 1:-1]
    assert np.allclose(inner, 0, atol=1e-12)


def test_filled_height_bends_least() -> None:
    """A plane with holes is whole again; no other filling of a bent surface bends less."""
    generator = np.random.default_rng(1)
    y, x = np.mgrid[0.0:12.0, 0.0:15.0]
    height = 0.1 * (x - 7) ** 2 + 0.3 * y + generator.normal(scale=0.1, size=x.shape)
    holed = np.where(generator.random(x.shape) < 0.4, np.nan, height)
    filled = filled_height(holed)
    known = np.isfinite(holed)
    assert np.array_equal(filled[known], holed[known])

    def energy(surface: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> float:
        twist = np.diff(np.diff(surface, axis=0), axis=1)
        bent = [np.diff(surface, 2, axis=axis) for axis in (0, 1)]
        return float((bent[0] ** 2).sum() + (bent[1] ** 2).sum() + 2 * (twist**2).sum())

    for _ in range(20):
        nudge = np.where(known, 0.0, generator.normal(scale=0.01, size=x.shape))
        assert energy(filled + nudge) > energy(filled)


def test_a_whole_height_stays() -> None:
    """Nothing to fill, nothing changed."""
    height = np.random.default_rng(0).normal(size=(4, 4))
    assert np.array_equal(filled_height(height), height)


@pytest.mark.parametrize("known", [[], [(0, 0)], [(0, 0), (1, 1), (3, 3)]])
def test_too_few_heights_are_one_sentence(known: list[tuple[int, int]]) -> None:
    """No plate stands on points of one line."""
    height = np.full((5, 5), np.nan)
    for pixel in known:
        height[pixel] = 1.0
    with pytest.raises(RelightlabError, match="three pixels at least that are not on one line"):
        filled_height(height)


def test_samples_of_a_miniature(tmp_path: Path) -> None:
    """Two colours give two log albedos, and differences that are zero or one jump."""
    made = write_miniature(tmp_path, "apple")
    (samples,) = training_samples(MitBerkeley(tmp_path), ("apple",))
    assert len(samples.gray) == made.mask.sum()
    assert np.allclose(np.unique(samples.color[:, 0].round(3)), np.log([0.3, 0.7]).round(3))
    assert np.allclose(np.unique(np.abs(samples.color_differences[:, 0]).round(3))[0], 0)
    jumps = np.unique(np.abs(samples.gray_differences).round(3))
    expected = abs(np.log((0.7 + 0.3 + 0.2) / (0.3 + 0.5 + 0.6)))
    assert np.allclose(jumps, [0, expected], atol=2e-3)
    assert np.isfinite(samples.curvature_differences).all()
    (again,) = training_samples(MitBerkeley(tmp_path), ("apple",))
    assert np.array_equal(again.gray_differences, samples.gray_differences)
