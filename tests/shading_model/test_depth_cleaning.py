"""Readings thrown away, filled and smoothed."""

from __future__ import annotations

import numpy as np

from shading_model.depth_cleaning import AS_MEASURED, USUAL, accepted, fill, smoothed


def test_readings_at_the_outline_are_thrown_away() -> None:
    """Pixels that the mask cuts and the ring beside them go; what is lost already stays lost."""
    coverage = np.zeros((9, 9))
    coverage[1:8, 1:8] = 1.0
    coverage[1] = 0.6
    readings = np.full((9, 9), 500.0)
    readings[4, 4] = np.nan
    kept = accepted(readings, coverage, USUAL)
    expected = np.zeros((9, 9), bool)
    expected[3:7, 2:7] = True
    expected[4, 4] = False
    assert np.array_equal(kept, expected)
    believed = accepted(readings, coverage, AS_MEASURED)
    assert np.array_equal(believed, (coverage > 0.5) & np.isfinite(readings))


def test_of_a_thin_object_the_best_readings_are_kept() -> None:
    """Where no pixel is covered well, those that are covered most count."""
    coverage = np.zeros((5, 5))
    coverage[2] = [0.1, 0.3, 0.3, 0.2, 0.3]
    readings = np.full((5, 5), 500.0)
    readings[2, 4] = np.nan
    assert np.array_equal(np.argwhere(accepted(readings, coverage, USUAL)), [[2, 1], [2, 2]])


def test_filling_is_harmonic() -> None:
    """Where values are a discrete harmonic function, holes get it; parts without any get zero."""
    rows, columns = np.indices((30, 40), dtype=float)
    harmonic = rows * columns + rows**2 - columns**2
    values = harmonic.copy()
    values[5:25, 7:30] = np.nan
    domain = np.ones(values.shape, bool)
    assert np.allclose(fill(values, domain), harmonic, atol=1e-4)
    domain[:, 35] = False
    values[:, 36:] = np.nan
    assert np.allclose(fill(values, domain)[:, 36:], 0)
    assert np.isnan(fill(values, domain)[:, 35]).all()


def test_smoothing_reduces_noise_as_a_gaussian_does() -> None:
    """White noise of deviation one has 1 / (2 sqrt(pi) s) after a Gaussian of deviation s."""
    noise = np.random.default_rng(1).standard_normal((200, 200))
    for deviation in (1.5, 2.5):
        expected = 1 / (2 * np.sqrt(np.pi) * deviation)
        assert np.isclose(smoothed(noise, deviation)[20:-20, 20:-20].std(), expected, rtol=0.1)
