"""The procedural objects' heights."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from datasets.synthetic_shapes import SHAPES, picture_coordinates, shape_height


def test_there_are_twenty_objects() -> None:
    """As many as MIT-Berkeley has."""
    assert len(SHAPES) == 20


@pytest.mark.parametrize("name", SHAPES)
def test_every_object_is_one_piece_inside_the_picture(name: str) -> None:
    """One connected mask of at least a sixth of the picture, clear of its border, with relief."""
    height = shape_height(name, 72, np.random.default_rng(0))
    mask = np.isfinite(height)
    assert ndimage.label(mask)[1] == 1
    assert mask.mean() > 1 / 6
    assert not np.concatenate([mask[0], mask[-1], mask[:, 0], mask[:, -1]]).any()
    assert np.nanmax(height) - np.nanmin(height) > 0.05 * 72


@pytest.mark.parametrize("name", ["apple", "carton", "cup", "bear", "duck"])
def test_solid_objects_are_nearest_inside(name: str) -> None:
    """Larger is nearer: the inside of the mask stands out before its border."""
    height = shape_height(name, 72, np.random.default_rng(0))
    mask = np.isfinite(height)
    inner = ndimage.binary_erosion(mask, iterations=6)
    border = mask & ~ndimage.binary_erosion(mask, iterations=2)
    assert height[inner].mean() > height[border].mean()


def test_heights_scale_with_the_picture() -> None:
    """Twice the pixels are twice the height, so slopes do not depend on the size."""
    small = shape_height("pear", 60, np.random.default_rng(0))
    large = shape_height("pear", 120, np.random.default_rng(0))
    assert np.nanmax(large) == pytest.approx(2 * np.nanmax(small), rel=0.03)


def test_the_mug_has_a_hole_behind_its_handle() -> None:
    """Background shut in by the mask: a mask with a hole is part of the set."""
    mask = np.isfinite(shape_height("mug", 96, np.random.default_rng(0)))
    assert ndimage.label(~mask)[1] == 2


def test_the_generator_decides_the_meso_structure() -> None:
    """One seed gives one shape, another another."""
    first, same, other = (shape_height("frog", 48, np.random.default_rng(s)) for s in (1, 1, 2))
    np.testing.assert_array_equal(first, same)
    both = np.isfinite(first) & np.isfinite(other)
    assert np.abs(first - other)[both].max() > 0.01


def test_coordinates_run_right_and_up() -> None:
    """The first column is left, the first row is up."""
    x, y = picture_coordinates(10)
    assert (np.diff(x, axis=1) > 0).all()
    assert (np.diff(y, axis=0) < 0).all()
