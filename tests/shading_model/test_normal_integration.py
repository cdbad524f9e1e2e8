"""Heights integrated from normals, against surfaces whose heights are known."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shading_model.arrays import Map, Mask
from shading_model.errors import RelightlabError
from shading_model.height_field import normals_of_slopes
from shading_model.normal_integration import STEEPEST, height_of_normals


def coordinates(rows: int, columns: int) -> tuple[Map, Map]:
    """Places about the picture's middle in pixels, x to the right and y up."""
    down, right = np.mgrid[:rows, :columns].astype(np.float64)
    return right - (columns - 1) / 2, (rows - 1) / 2 - down


def centred(height: Map, mask: Mask) -> Map:
    """The height about its mean over the mask, NaN outside."""
    return np.where(mask, height - height[mask].mean(), np.nan)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_quadratic_surfaces_come_back_exactly(seed: int) -> None:
    """Planes, paraboloids and saddles over a ragged mask, to the solver's tolerance."""
    generator = np.random.default_rng(seed)
    a, b = generator.uniform(-1, 1, 2)
    c, d, e = generator.uniform(-0.02, 0.02, 3)
    x, y = coordinates(24, 31)
    height = a * x + b * y + c * x**2 + d * y**2 + e * x * y
    mask = np.hypot(x / 15, y / 12) < 1
    mask[5:9, 10:14] = False
    found = height_of_normals(normals_of_slopes(a + 2 * c * x + e * y, b + 2 * d * y + e * x), mask)
    assert np.allclose(found, centred(height, mask), atol=1e-5, equal_nan=True)


def test_a_sphere_is_recovered_to_a_fraction_of_a_pixel() -> None:
    """Up to the ring of its outline, where slopes grow without bound."""
    x, y = coordinates(101, 101)
    radius = 50.0
    height = np.sqrt(np.maximum(0, radius**2 - x**2 - y**2))
    normals = np.stack([x, y, height], axis=-1) / radius
    mask = np.hypot(x, y) < 0.97 * radius
    error = height_of_normals(normals, mask) - centred(height, mask)
    assert np.sqrt(np.mean(error[mask] ** 2)) < 0.1


def test_parts_are_solved_on_their_own() -> None:
    """Two planes that do not touch each have mean zero, whatever the other does."""
    x, _ = coordinates(12, 20)
    mask = np.ones((12, 20), bool)
    mask[:, 10] = False
    slope = np.where(x < 0, 0.5, -0.25)
    found = height_of_normals(normals_of_slopes(slope, np.zeros_like(x)), mask)
    for part, rise in ((np.s_[:, :10], 0.5), (np.s_[:, 11:], -0.25)):
        assert abs(found[part].mean()) < 1e-8
        assert np.allclose(np.diff(found[part], axis=1), rise, atol=1e-6)
    assert np.isnan(found[:, 10]).all()


def test_single_pixels_are_parts_of_height_zero() -> None:
    """A pixel without neighbours has nothing to be compared with."""
    mask = np.zeros((3, 5), bool)
    mask[1, 1] = mask[1, 3] = True
    found = height_of_normals(np.tile([0.6, 0.0, 0.8], (3, 5, 1)), mask)
    assert (found[mask] == 0).all()


def test_unknown_normals_are_bridged() -> None:
    """A hole of NaN normals in a plane's middle leaves the plane around it as it is."""
    x, y = coordinates(21, 21)
    mask = np.ones((21, 21), bool)
    normals = normals_of_slopes(np.full_like(x, 0.5), np.full_like(y, -0.3))
    normals[9:12, 9:12] = np.nan
    found = height_of_normals(normals, mask)
    expected = centred(0.5 * x - 0.3 * y, mask)
    around = np.isfinite(normals).all(axis=-1)
    assert np.isfinite(found).all()
    assert np.abs(found - expected)[around].max() < 1e-2
    assert np.abs(found - expected).max() < 1


def test_slopes_have_a_limit() -> None:
    """Normals at right angles to the view, or beyond, give steep slopes, not infinite ones."""
    normals = np.tile([-1.0, 0.0, 0.0], (3, 4, 1))
    normals[:, 2] = [-0.8, 0.0, -0.6]
    found = height_of_normals(normals, np.ones((3, 4), bool))
    assert np.allclose(np.diff(found, axis=1), STEEPEST)


def test_grazing_pixels_give_way() -> None:
    """A wrong normal seen at a grazing angle moves the rest less than one that faces the viewer."""
    x, _ = coordinates(15, 15)
    mask = np.ones((15, 15), bool)
    moved = []
    for upright in (0.9, 0.2):
        normals = np.tile([0.0, 0.0, 1.0], (15, 15, 1))
        normals[7, 7] = [-np.sqrt(1 - upright**2), 0, upright]
        found = height_of_normals(normals, mask)
        slope = np.sqrt(1 - upright**2) / upright
        moved.append(np.abs(found[np.abs(x) > 2]).max() / slope)
    assert moved[1] < 0.1 * moved[0]


def test_a_photograph_takes_less_than_a_second() -> None:
    """Sixty thousand pixels."""
    x, y = coordinates(280, 280)
    mask = np.hypot(x, y) < 139
    normals = np.stack([x, y, np.sqrt(np.maximum(1.0, 140**2 - x**2 - y**2))], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    started = time.process_time()
    height_of_normals(normals, mask)
    assert mask.sum() > 60_000
    assert time.process_time() - started < 1


def test_sizes_that_differ_are_refused() -> None:
    """And so is an empty mask."""
    normals = np.tile([0.0, 0.0, 1.0], (3, 4, 1))
    with pytest.raises(RelightlabError, match="expected normals of shape"):
        height_of_normals(normals, np.ones((4, 3), bool))
    with pytest.raises(RelightlabError, match="the mask is empty"):
        height_of_normals(normals, np.zeros((3, 4), bool))
