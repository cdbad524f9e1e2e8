"""Tests of reports.side_view: what is seen of a surface from aside, and what hides what."""

from __future__ import annotations

import numpy as np
import pytest

from reports.side_view import TURN, Surface, clay_pictures
from shading_model.height_field import normals_of_height

SIDES = ("front", "left", "below")


def surface(height: np.ndarray) -> Surface:
    """Return a height map as a surface."""
    return Surface(height, normals_of_height(height))


def hemisphere(radius: int) -> np.ndarray:
    """Return the height of a half ball."""
    y, x = np.mgrid[-radius - 2 : radius + 3, -radius - 2 : radius + 3].astype(float)
    squared = radius**2 - x**2 - y**2
    return np.where(squared > 0, np.sqrt(np.maximum(squared, 0)), np.nan)


def extent(picture: np.ndarray, axis: int) -> int:
    """Return how many columns (axis 0) or rows (axis 1) of a picture show anything."""
    return int((picture[..., 3] > 0).any(axis=axis).sum())


def test_a_flat_sheet_is_foreshortened() -> None:
    """A plane seen from aside is as wide as the cosine of the turn; from the front, whole."""
    sheet = Surface(np.zeros((40, 60)), np.broadcast_to([0.0, 0.0, 1.0], (40, 60, 3)))
    front, left, below = (clay_pictures([sheet], side)[0] for side in SIDES)
    assert (extent(front, 0), extent(front, 1)) == (60, 40)
    assert extent(left, 0) == pytest.approx(60 * np.cos(TURN), abs=1.5)
    assert extent(left, 1) == 40
    assert extent(below, 1) == pytest.approx(40 * np.cos(TURN), abs=1.5)
    assert extent(below, 0) == 60


def test_pictures_have_the_proportions_of_the_maps() -> None:
    """Every side of a deep object keeps the map's proportions, so that panels line up."""
    height = hemisphere(20)[4:-4] * 3
    for side in SIDES:
        (picture,) = clay_pictures([surface(height)], side)
        assert picture.shape[1] / picture.shape[0] == pytest.approx(45 / 37, rel=0.03)


def test_a_ball_has_no_holes_and_its_outline() -> None:
    """Seen from aside, a half ball fills its outline: a half disk and a foreshortened one."""
    radius = 40
    (picture,) = clay_pictures([surface(hemisphere(radius))], "left")
    rows = picture[..., 3] > 0
    gaps = [np.diff(np.nonzero(row)[0]).max(initial=1) for row in rows]
    assert max(gaps) == 1
    middle = rows[rows.shape[0] // 2].sum()
    assert middle == pytest.approx(radius * (1 + np.cos(TURN)), rel=0.12)


def test_what_is_nearer_hides_what_is_behind() -> None:
    """From the left a wall on the left hides the ground to its right, however bright that is."""
    height = np.zeros((6, 60))
    height[:, 10:14] = 30.0
    normals = np.broadcast_to([0.0, 0.0, 1.0], (6, 60, 3)).copy()
    normals[:, 9:15] = [-1.0, 0.0, 0.0]
    normals[:, 14:30] = [0.0, 0.0, -1.0]  # dark: its back
    (whole,) = clay_pictures([Surface(height, normals)], "front")
    (aside,) = clay_pictures([Surface(height, normals)], "left")
    darkest = np.sort(np.unique(whole[..., 0][whole[..., 3] > 0]))[0]
    assert (whole[..., 0][whole[..., 3] > 0] == darkest).mean() > 0.2
    assert (aside[..., 0][aside[..., 3] > 0] <= darkest + 2).mean() < 0.05


def test_left_is_left_and_below_is_below() -> None:
    """A sheet that faces the viewer aside is seen whole, one that leans the other way is not."""
    y, x = np.mgrid[20:-21:-1, -20:21].astype(float)
    for side, slope, axis in (("left", x, 0), ("below", y, 1)):
        toward, away = (surface(sign * np.tan(TURN) * slope) for sign in (1, -1))
        (whole,), (narrow,) = (clay_pictures([one], side) for one in (toward, away))
        length = 40 / np.cos(TURN)
        assert extent(whole, axis) == pytest.approx(length, abs=4)
        assert extent(narrow, axis) == pytest.approx(length * abs(np.cos(2 * TURN)), abs=3)


def test_surfaces_share_a_scale_and_offsets_do_not_matter() -> None:
    """Two heights that differ by a number give the same picture; a flatter one a narrower."""
    ball = np.round(hemisphere(30) * 256) / 256  # so that adding an offset loses no digit
    normals = normals_of_height(ball)
    same, moved = clay_pictures([Surface(ball, normals), Surface(ball + 512, normals)], "left")
    assert np.array_equal(same, moved)
    deep, flat = clay_pictures([surface(ball), surface(ball / 4)], "left")
    assert deep.shape == flat.shape
    assert extent(flat, 0) < extent(deep, 0)
