"""Distance functions and the heights seen of them."""

from __future__ import annotations

import numpy as np
import pytest

from datasets.synthetic_shapes import picture_coordinates
from datasets.synthetic_solids import (
    Solid,
    blend,
    box,
    capsule,
    ellipsoid,
    placed,
    ring,
    seen_height,
    vessel,
)


def test_a_ball_is_seen_at_its_closed_form() -> None:
    """The height of a ball is sqrt(r^2 - x^2 - y^2), to a thousandth where it is not grazed."""
    x, y = picture_coordinates(60)
    height = seen_height(ellipsoid((0, 0, 0), (0.8, 0.8, 0.8)), x, y)
    squared = 0.64 - x**2 - y**2
    np.testing.assert_array_equal(np.isfinite(height), squared > 0)
    inside = squared > 0.1
    np.testing.assert_allclose(height[inside], np.sqrt(squared[inside]), atol=1e-3)


def test_a_turned_ellipsoid_is_seen_at_its_closed_form() -> None:
    """Half a turn to the left lays the long axis upright."""
    x, y = picture_coordinates(60)
    turned = seen_height(ellipsoid((0, 0, 0), (0.8, 0.4, 0.5), 90.0), x, y)
    upright = seen_height(ellipsoid((0, 0, 0), (0.4, 0.8, 0.5)), x, y)
    np.testing.assert_allclose(turned, upright, atol=1e-6)


@pytest.mark.parametrize(
    "solid",
    [
        capsule((0, -0.4, 0), (0.3, 0.4, 0.2), 0.2),
        ring(0.6, 0.15),
        vessel(0.4, 0.5, 0.5, 0.06),
        box((0.5, 0.4, 0.3), 0.05),
        blend(ellipsoid((-0.3, 0, 0), (0.4,) * 3), ellipsoid((0.3, 0, 0), (0.3,) * 3)),
        placed(box((0.5, 0.4, 0.3), 0.05), tilt=30.0, turn=20.0),
    ],
)
def test_no_point_is_nearer_than_its_distance(solid: Solid) -> None:
    """Distances change no faster than the way walked, so a line of sight cannot pass through."""
    generator = np.random.default_rng(0)
    start = generator.uniform(-1.2, 1.2, (4000, 3))
    step = generator.normal(size=(4000, 3)) * 0.02
    change = np.abs(solid(start + step) - solid(start))
    assert (change <= 1.001 * np.linalg.norm(step, axis=-1) + 1e-12).all()


def test_a_blend_holds_its_parts_and_fills_the_crease() -> None:
    """Where two balls meet, the blend is outside neither and thicker than both."""
    left, right = (ellipsoid((s * 0.35, 0, 0), (0.4,) * 3) for s in (-1, 1))
    both = blend(left, right, reach=0.1)
    points = np.random.default_rng(0).uniform(-1, 1, (2000, 3))
    assert (both(points) <= np.minimum(left(points), right(points)) + 1e-12).all()
    crease = np.array([[0.0, 0.2, 0.0]])
    assert both(crease)[0] < min(left(crease)[0], right(crease)[0])


def test_tilting_shows_the_inside_of_a_cup() -> None:
    """A cup tilted to the viewer shows its far inner wall above its rim."""
    x, y = picture_coordinates(80)
    level = seen_height(vessel(0.4, 0.4, 0.5, 0.05), x, y)
    tilted = seen_height(placed(vessel(0.4, 0.4, 0.5, 0.05), tilt=35.0), x, y)
    middle = np.abs(x) < 0.1
    assert np.abs(np.diff(level[middle & np.isfinite(level)])).max() < 0.1
    column = tilted[:, 40][np.isfinite(tilted[:, 40])]
    assert np.abs(np.diff(column)).max() > 0.3
