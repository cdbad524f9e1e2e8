"""Normals of a height field."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from shading_model.height_field import (
    normals_inside_outline,
    normals_of_height,
    normals_of_slopes,
    slopes,
)

slope = st.floats(-5, 5)


@given(slope, slope)
def test_a_plane_has_its_own_slopes(right: float, up: float) -> None:
    """Away from the border the slopes of a plane are exact, x to the right and y up."""
    rows, columns = np.indices((6, 7), dtype=float)
    found = slopes(right * columns - up * rows)
    assert np.allclose(found[0][1:-1, 1:-1], right)
    assert np.allclose(found[1][1:-1, 1:-1], up)


@given(slope, slope)
def test_normals_are_unit_and_across_both_tangents(right: float, up: float) -> None:
    """A normal has length one, faces the viewer and is orthogonal to (1, 0, p) and (0, 1, q)."""
    normal = normals_of_slopes(np.array(right), np.array(up))
    assert np.isclose(np.linalg.norm(normal), 1)
    assert normal[2] > 0
    assert np.allclose(np.array([[1, 0, right], [0, 1, up]]) @ normal, 0)


def test_slopes_of_a_quadratic_are_exact() -> None:
    """Central differences of a parabola are its derivative."""
    columns = np.tile(np.arange(8.0), (5, 1))
    right, up = slopes(columns**2)
    assert np.allclose(right[:, 1:-1], 2 * columns[:, 1:-1])
    assert np.allclose(up, 0)


def test_unknown_heights_spread_to_the_slopes_around_them() -> None:
    """A NaN makes the slopes of its eight neighbours unknown, and no others."""
    height = np.zeros((5, 5))
    height[2, 2] = np.nan
    unknown = np.isnan(slopes(height)[0]) | np.isnan(slopes(height)[1])
    window = np.zeros((5, 5), bool)
    window[1:4, 1:4] = True
    assert (unknown == window).all()


def test_a_shape_stands_on_the_plane_of_its_outline() -> None:
    """Beyond the outline the height counts as zero, so normals at a step lean outward."""
    height = np.full((5, 6), np.nan)
    height[1:4, 1:5] = 2.0
    normals = normals_of_height(height)
    assert np.isnan(normals[np.isnan(height)]).all()
    assert normals[2, 4, 0] > 0 > normals[2, 1, 0]
    assert normals[1, 2, 1] > 0 > normals[3, 2, 1]
    assert np.allclose(normals[2, 2], normals[2, 3] * [-1, 1, 1])


@given(slope, slope)
def test_a_plane_has_its_own_normal_up_to_its_outline(right: float, up: float) -> None:
    """Over a disk, with a hole, every pixel has the normal of the plane."""
    rows, columns = np.mgrid[-7:8, -7:8].astype(float)
    distance = np.hypot(rows, columns)
    height = np.where((distance < 7) & (distance > 2), right * columns - up * rows, np.nan)
    normals = normals_inside_outline(height)
    known = np.isfinite(height)
    expected = normals_of_slopes(np.array(right), np.array(up))
    assert np.allclose(normals[known], expected)
    assert np.isnan(normals[~known]).all()


def test_normals_inside_are_those_of_the_slopes() -> None:
    """Where all eight neighbours are known, both agree."""
    height = np.random.default_rng(5).normal(size=(9, 11))
    height[3, 4] = np.nan
    expected = normals_of_slopes(*slopes(height))[1:-1, 1:-1]
    known = np.isfinite(expected).all(axis=-1)
    assert np.count_nonzero(~known) == 9
    assert np.allclose(normals_inside_outline(height)[1:-1, 1:-1][known], expected[known])


def test_a_lone_pixel_faces_the_viewer() -> None:
    """Without neighbours there is no slope."""
    height = np.full((3, 3), np.nan)
    height[1, 1] = 7
    assert np.array_equal(normals_inside_outline(height)[1, 1], [0, 0, 1])
