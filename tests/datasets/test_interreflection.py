"""Longer paths of light in hollows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from datasets.interreflection import path_offset
from shading_model.arrays import Float, Map, Mask


def cap(side: int, opening_degrees: float, concave: bool) -> tuple[Map, Mask, float]:
    """Return depth in millimetres and mask of a spherical cap, and the radius of its sphere."""
    rows, columns = np.mgrid[:side, :side] - (side - 1) / 2
    from_axis = np.hypot(rows, columns)
    mask = from_axis <= side / 2
    radius = side / 2 / np.sin(np.radians(opening_degrees))
    rise = np.sqrt(radius**2 - np.minimum(from_axis, side / 2) ** 2)
    return 1000 + (rise if concave else -rise), mask, radius


def offset_at_bottom(radius: float, opening_degrees: float, reflectance: float) -> float:
    """Return the offset at the bottom of a concave cap, by integrals over its sphere.

    Between any two points of a sphere the form factor is area / (4 pi R^2); light reaches the point
    at the angle t from the bottom in proportion to cos t.
    """

    def light(t: float) -> float:
        return float(reflectance * np.cos(t) * np.sin(t) / 2)

    def longer(t: float) -> float:
        return float(radius * (2 * np.sin(t / 2) - (1 - np.cos(t))) / 2)

    end = np.radians(opening_degrees)
    added = quad(light, 0, end)[0]
    return float(quad(lambda t: light(t) * longer(t), 0, end)[0] / (1 + added))


@pytest.mark.parametrize("opening_degrees", [35.0, 50.0, 65.0])
def test_a_spherical_hollow_has_the_offset_of_theory(opening_degrees: float) -> None:
    """At the bottom of a cap, where the integrals are known, within eight per cent."""
    depth, mask, radius = cap(121, opening_degrees, concave=True)
    offset = path_offset(depth, np.full(depth.shape, 0.6), mask, 1.0)
    assert offset[60, 60] == pytest.approx(offset_at_bottom(radius, opening_degrees, 0.6), rel=0.08)


@settings(max_examples=10)
@given(st.floats(-2, 2), st.floats(-2, 2))
def test_planes_and_convex_shapes_get_none(right: float, down: float) -> None:
    """No patch lies in front of another's tangent plane; those cut by the mask by a hair."""
    rows, columns = np.indices((40, 50), dtype=float)
    everywhere = np.ones(rows.shape, bool)
    plane = 900 + right * columns + down * rows
    assert np.allclose(path_offset(plane, everywhere * 0.5, everywhere, 1.0), 0, atol=1e-3)
    depth, mask, _ = cap(51, 60, concave=False)
    assert np.allclose(path_offset(depth, mask * 0.5, mask, 1.0)[mask], 0, atol=1e-3)


def corner(side: int) -> tuple[Map, Mask]:
    """Return the depth of two planes that meet in a valley at right angles."""
    columns: Float = np.abs(np.arange(side) - (side - 1) / 2)
    return np.tile(900 - columns, (side, 1)), np.ones((side, side), bool)


def test_a_corner_reads_farther_by_its_size_and_albedo() -> None:
    """The offset is never negative, scales with the corner, and grows with its reflectance."""
    depth, mask = corner(60)
    offset = path_offset(depth, mask * 0.5, mask, 1.0)
    assert offset.min() >= 0
    assert offset.max() > 0.5
    assert np.allclose(path_offset(depth * 2, mask * 0.5, mask, 2.0), 2 * offset)
    brighter = path_offset(depth, mask * 0.9, mask, 1.0)
    assert (brighter >= offset).all()
    assert brighter.max() > 1.3 * offset.max()


def test_nothing_is_said_outside_the_mask() -> None:
    """The offset is known on the mask alone, whatever the depth holds elsewhere."""
    depth, mask, _ = cap(41, 50, concave=True)
    wild = np.where(mask, depth, np.nan)
    offset = path_offset(wild, np.where(mask, 0.5, np.nan), mask, 1.0)
    assert (np.isfinite(offset) == mask).all()
    assert np.allclose(offset[mask], path_offset(depth, mask * 0.5, mask, 1.0)[mask])
