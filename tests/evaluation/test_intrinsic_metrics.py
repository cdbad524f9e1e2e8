"""Errors of an albedo and shading estimate against the truth."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from evaluation.intrinsic_metrics import intrinsic_error, local_mean_squared_error
from shading_model.arrays import Float, Mask
from shading_model.errors import RelightlabError

seeds = st.integers(0, 2**32 - 1)


def slow_error(estimate: Float, truth: Float, mask: Mask, side: int) -> float:
    """One window after another: four copies, starting at 0 and at half a window less one."""
    error = power = 0.0
    starts = (0, side // 2 - 1)
    for first_row in starts:
        for first_column in starts:
            for row in range(first_row, mask.shape[0], side):
                for column in range(first_column, mask.shape[1], side):
                    window = (slice(row, row + side), slice(column, column + side))
                    ours, true = estimate[window][mask[window]], truth[window][mask[window]]
                    scale = ours @ true / (ours @ ours) if ours @ ours > 0 else 0.0
                    error += float(np.sum((true - scale * ours) ** 2))
                    power += float(true @ true)
    return error / power


@settings(max_examples=40)
@given(seeds, st.integers(5, 50), st.integers(5, 50), st.sampled_from([4, 8, 20]))
def test_it_agrees_with_a_loop_over_windows(seed: int, height: int, width: int, side: int) -> None:
    """For any sizes, masks and windows, those that reach over the edge included."""
    generator = np.random.default_rng(seed)
    estimate, truth = generator.normal(size=(2, height, width))
    mask = generator.random((height, width)) > 0.3
    mask[height // 2, width // 2] = True
    found = local_mean_squared_error(estimate, truth, mask, side)
    assert np.isclose(found, slow_error(estimate, truth, mask, side), rtol=1e-9, atol=1e-12)
    assert 0 <= found <= 1


@given(seeds)
@settings(max_examples=20)
def test_a_multiple_of_the_truth_is_perfect(seed: int) -> None:
    """Zero for any nonzero scale, whatever lies outside the mask."""
    generator = np.random.default_rng(seed)
    truth = generator.normal(size=(33, 47))
    mask = generator.random(truth.shape) > 0.4
    estimate = np.where(mask, generator.choice([-3, 0.01, 5]) * truth, np.nan)
    assert local_mean_squared_error(estimate, truth, mask) < 1e-12


@given(seeds)
@settings(max_examples=20)
def test_the_scale_of_the_estimate_does_not_matter(seed: int) -> None:
    """Multiplying the estimate, or both, by a constant changes nothing."""
    generator = np.random.default_rng(seed)
    estimate, truth = generator.random((2, 30, 30))
    mask = np.ones((30, 30), bool)
    error = local_mean_squared_error(estimate, truth, mask)
    assert np.isclose(local_mean_squared_error(7 * estimate, truth, mask), error)
    assert np.isclose(local_mean_squared_error(3 * estimate, 5 * truth, mask), error)


def test_each_window_has_its_own_scale() -> None:
    """In the unshifted copy a scale that changes from window to window costs nothing.

    With windows of the whole picture's size one scale serves all: truth (1, 1), estimate (1, 3)
    leaves 1 - (1 + 3)^2 / (2 * 10) = 0.2 of the power.
    """
    truth = np.ones((20, 40))
    estimate = np.ones((20, 40))
    estimate[:, 20:] = 3
    mask = np.ones((20, 40), bool)
    shifted = local_mean_squared_error(estimate, truth, mask)
    assert 0 < shifted < 0.2
    whole = local_mean_squared_error(estimate, truth, mask, window=2 * 41)
    # The copies shifted by 40 columns hold nothing but what lies beyond the picture.
    assert np.isclose(whole, 0.2)


def test_a_constant_estimate_leaves_the_variance() -> None:
    """In one window, 1 - mean^2 / mean square: for 1 and 3 in equal parts, 0.2."""
    truth = np.where(np.indices((4, 4)).sum(axis=0) % 2, 1.0, 3.0)
    error = local_mean_squared_error(np.ones((4, 4)), truth, np.ones((4, 4), bool), window=100)
    assert np.isclose(error, 0.2)


def test_an_estimate_of_zero_leaves_everything() -> None:
    """No scale helps a black estimate: the error is one."""
    truth = np.random.default_rng(0).random((25, 25))
    assert np.isclose(local_mean_squared_error(0 * truth, truth, truth > 0), 1)


def test_channels_are_averaged() -> None:
    """The error of a colour picture is the mean of its channels' errors."""
    generator = np.random.default_rng(1)
    estimate, truth = generator.random((2, 25, 30, 3))
    mask = np.ones((25, 30), bool)
    each = [local_mean_squared_error(estimate[..., c], truth[..., c], mask) for c in range(3)]
    assert np.isclose(local_mean_squared_error(estimate, truth, mask), np.mean(each))
    assert np.std(each) > 0


def test_the_score_is_the_mean_of_shading_and_albedo() -> None:
    """Right albedo and wrong shading score half the shading's error, over the known pixels only."""
    generator = np.random.default_rng(2)
    albedo, true_shading = generator.random((2, 25, 30, 3)) + 0.1
    shading = generator.random((25, 30))
    mask = np.ones((25, 30), bool)
    colour = np.repeat(shading[..., None], 3, axis=-1)
    albedo[3, 4] = np.nan
    known = np.isfinite(albedo).all(axis=-1)
    expected = local_mean_squared_error(colour, true_shading, known) / 2
    found = intrinsic_error(2 * albedo, shading, albedo, true_shading, mask)
    assert np.isclose(found, expected)
    assert found > 0.01
    gray_truth = np.repeat(shading[..., None], 3, axis=-1)
    assert intrinsic_error(2 * albedo, shading, albedo, 3 * gray_truth, mask) < 1e-12


def test_shapes_that_differ_and_black_truths_are_refused() -> None:
    """Each with its sentence."""
    ones = np.ones((5, 6))
    with pytest.raises(RelightlabError, match=r"expected an estimate of shape \(5, 6\), got"):
        local_mean_squared_error(ones.T, ones, ones > 0)
    with pytest.raises(RelightlabError, match="the truth is zero all over the mask"):
        local_mean_squared_error(ones, 0 * ones, ones > 0)
