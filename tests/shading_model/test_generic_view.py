"""Tests of shading_model.generic_view: closed forms, invariances, real shapes and bad input."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from datasets.mit_berkeley import MitBerkeley
from shading_model.arrays import Float, Map, Mask
from shading_model.errors import RelightlabError
from shading_model.generic_view import GenericView, generic_view, outline_shift, self_shadow_share
from shading_model.object_model import contour_base
from shading_model.pixel_grid import boundary_of
from tests.example_objects import disk, parameters

RADIUS = 120.0
AZIMUTHS = [0.0, 45.0, 90.0, 160.0, 225.0, 270.0, 300.0]


def distances(size: int = 250) -> tuple[Float, Mask]:
    """Return the distance to the middle of a picture, and a disk of `RADIUS`."""
    rows, columns = np.mgrid[:size, :size] - (size - 1) / 2
    distance = np.hypot(rows, columns)
    return distance, distance < RADIUS


def hemisphere() -> tuple[Map, Mask]:
    """Return a hemisphere that stands on its outline."""
    distance, mask = distances()
    height = np.sqrt(np.maximum(RADIUS**2 - distance**2, 0.0))
    return np.where(boundary_of(mask), 0.0, height), mask


def plane(rows: int = 60, columns: int = 90) -> tuple[Map, Mask]:
    """Return a plane that fills the picture."""
    return np.zeros((rows, columns)), np.ones((rows, columns), dtype=bool)


def diameter(mask: Mask) -> float:
    """Return the diameter of the disk of a mask's area."""
    return float(2 * np.sqrt(mask.sum() / np.pi))


@given(offset=st.floats(-1e4, 1e4), azimuth=st.floats(-360, 720), size=st.integers(1, 30))
def test_nothing_moves_on_a_flat_shape(offset: float, azimuth: float, size: int) -> None:
    """A flat shape at any distance has no outline shift and no shadow, down to one pixel."""
    mask = disk(size, max(0.4 * size, 1.0))
    view = generic_view(np.full(mask.shape, offset), mask, [0, 15, 60], [azimuth])
    assert view.outline_shift == pytest.approx(0.0, abs=1e-9)
    assert view.shadow_share.max() == 0.0


def test_hemisphere_moves_its_outline_as_its_closed_form() -> None:
    """Half of a hemisphere's outline stays where the sphere's is: pi / 16 (1 - cos t)."""
    height, mask = hemisphere()
    angles = [6.0, 15.0, 30.0]
    expected = np.pi / 16 * (1 - np.cos(np.deg2rad(angles)))
    shift = outline_shift(height, mask, angles, AZIMUTHS)
    assert np.abs(shift - expected[:, None]).max() * 2 * RADIUS < 0.4
    assert np.abs(shift.mean(axis=1) - expected).max() * 2 * RADIUS < 0.15


def test_hemisphere_casts_no_shadow_on_itself() -> None:
    """What a convex surface turns away from the light is not in a cast shadow."""
    height, mask = hemisphere()
    assert self_shadow_share(height, mask, [5, 15, 45, 75], AZIMUTHS).max() < 0.003


def test_hollow_is_shadowed_by_its_rim() -> None:
    """A hemispherical hollow is shadowed by (cos t - cos 2t) / 2 of its area."""
    height, mask = hemisphere()
    angles = np.array([10.0, 20.0, 30.0, 40.0])
    expected = (np.cos(np.deg2rad(angles)) - np.cos(np.deg2rad(2 * angles))) / 2
    share = self_shadow_share(-height, mask, list(angles), AZIMUTHS)
    assert np.abs(share - expected[:, None]).max() < 0.02
    assert np.abs(share[:, 0] - expected).max() < 0.01


@pytest.mark.parametrize("steepness", [3.0, 6.0])
def test_cone_moves_its_outline_where_its_tip_passes_its_rim(steepness: float) -> None:
    """The tip is seen beside the rim from cot t = steepness on, between its two tangents."""
    distance, mask = distances()
    angles = np.array([5.0, 12.0, 15.0, 25.0])
    turns = np.deg2rad(angles)
    reach = np.maximum(steepness * np.tan(turns), 1.0)
    expected = np.cos(turns) * (np.sqrt(reach**2 - 1) - np.arccos(1 / reach)) / 8
    view = generic_view(steepness * (RADIUS - distance), mask, list(angles), AZIMUTHS)
    assert np.abs(view.outline_shift - expected[:, None]).max() < 0.004
    assert view.shadow_share.max() < 0.003


def test_block_at_the_end_moves_its_own_ends() -> None:
    """Where a block stands at the end of the plane, the ends of its rows move by h sin t."""
    height, mask = plane()
    height[10:25, :20] = 30.0
    angles = [0.0, 5.0, 15.0]
    expected = 15 * 30 * np.sin(np.deg2rad(angles)) / (2 * 60) / diameter(mask)
    assert outline_shift(height, mask, angles, [0])[:, 0] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("azimuth", "turns"), [(0, 0), (90, 1), (180, 2), (270, 3), (-90, 3)])
def test_block_casts_a_shadow_of_its_height_times_the_tangent(azimuth: int, turns: int) -> None:
    """A block's shadow away from the light is as wide as the block; its slope takes one pixel."""
    height = np.zeros((120, 120))
    height[40:60, 60:80] = 25.0
    angles = np.array([5.0, 15.0, 30.0, 45.0])
    expected = 20 * (25 * np.tan(np.deg2rad(angles)) - 1)
    turned = np.rot90(height, turns)
    share = self_shadow_share(turned, turned > -1, list(angles), [azimuth])
    assert share[:, 0] * 120**2 == pytest.approx(expected, abs=1e-9)


def test_shadow_of_a_slanting_light_has_the_same_area() -> None:
    """Seen along its diagonal a block is 1.41 times as wide, and so is its shadow."""
    height = np.zeros((400, 400))
    height[150:250, 150:250] = 80.0
    share = self_shadow_share(height, height > -1, [40], [45, 135, 225, 315])
    length = 80 * np.tan(np.deg2rad(40))
    assert share * 400**2 == pytest.approx(100 * np.sqrt(2) * length, rel=0.05)


def test_shadow_crosses_a_gap() -> None:
    """A wall beyond a gap of the mask still shades what lies before the gap."""
    height, mask = plane(4, 60)
    height[:, 40:] = 20.0
    whole = self_shadow_share(height, mask, [45], [0]) * mask.sum()
    mask[:, 30:38] = False
    cut = self_shadow_share(height, mask, [45], [0]) * mask.sum()
    # The shadow of 19 pixels lies from 20 to 39; the gap and its two borders take 9 of them.
    assert (whole / 4, cut / 4) == (pytest.approx(19.0), pytest.approx(19.0 - 9.0))


def test_strips_do_not_shade_one_another() -> None:
    """Every strip along the light is on its own: a wall shades its own rows alone."""
    height, mask = plane(5, 40)
    height[2, 30:] = 8.0
    assert self_shadow_share(height, mask, [45], [0]) * mask.sum() == pytest.approx(7.0)


def hidden_by_search(height: Map, angle: float) -> float:
    """Return the shadowed length per pixel along +x, every point against every other."""
    fine = 50
    places = np.arange((height.shape[1] - 1) * fine) / fine + 0.5 / fine
    total = 0.0
    for row in height:
        heights = np.interp(places, np.arange(row.size), row)
        rises = np.repeat(np.diff(row), fine)
        seen = places * np.cos(angle) - heights * np.sin(angle)
        nearer = np.triu(seen[None, :] < seen[:, None], 1).any(axis=1)
        facing = rises * np.sin(angle) < np.cos(angle)
        total += float((nearer & facing).sum()) / fine
    return total / height.size


@given(seed=st.integers(0, 10**6), angle=st.floats(5, 75))
def test_sweep_agrees_with_a_search_over_all_pairs(seed: int, angle: float) -> None:
    """One sweep finds the shadows that comparing every point with every other finds."""
    height = np.random.default_rng(seed).normal(0.0, 2.0, (2, 12))
    share = self_shadow_share(height, height < np.inf, [angle], [0])[0, 0]
    assert share == pytest.approx(hidden_by_search(height, np.deg2rad(angle)), abs=0.02)


def rough(seed: int = 3) -> tuple[Map, Mask]:
    """Return a rough surface over a disk, which moves its outline and shades itself."""
    mask = disk(40)
    height = np.random.default_rng(seed).normal(0.0, 3.0, mask.shape)
    return np.where(mask, height, np.nan), mask


def same(one: GenericView, other: GenericView, tolerance: float) -> None:
    """Hold two measures to one another."""
    assert one.outline_shift == pytest.approx(other.outline_shift, abs=tolerance)
    assert one.shadow_share == pytest.approx(other.shadow_share, abs=tolerance)


@given(down=st.integers(0, 9), right=st.integers(0, 9), offset=st.floats(-1e3, 1e3))
def test_place_and_distance_do_not_matter(down: int, right: int, offset: float) -> None:
    """A surface moved in the picture or toward the viewer has the same measures."""
    height, mask = rough()
    pads = ((down, 9 - down), (right, 9 - right))
    moved = np.pad(height + offset, pads, constant_values=np.nan)
    before = generic_view(height, mask, [10, 40], [0, 30])
    same(generic_view(moved, np.pad(mask, pads), [10, 40], [0, 30]), before, 1e-9)


def waves(factor: int) -> GenericView:
    """Return the measures of a wavy surface given at a scale."""
    y, x = (np.arange(factor * size) / factor for size in (60, 80))
    height = factor * np.add.outer(6 * np.sin(y / 5), 8 * np.cos(x / 6) + 0.1 * x)
    return generic_view(height, np.isfinite(height), [15, 45], AZIMUTHS)


def test_scale_does_not_matter() -> None:
    """A surface three times as large in all directions has the same measures."""
    small = waves(2)
    assert small.shadow_share.max() > 0.05
    same(small, waves(6), 0.006)


def test_quarter_turns_of_the_object_turn_the_azimuths() -> None:
    """An object turned a quarter counter-clockwise is seen from the right as before from below."""
    height, mask = rough()
    before = generic_view(height, mask, [15, 50], [0, 90, 180, 270])
    after = generic_view(np.rot90(height), np.rot90(mask), [15, 50], [90, 180, 270, 360])
    same(before, after, 1e-12)


def test_measures_are_the_same_alone_and_together() -> None:
    """Each measure asked for alone has the bits it has beside the other."""
    height, mask = rough()
    together = generic_view(height, mask, [10, 30], AZIMUTHS)
    assert np.array_equal(outline_shift(height, mask, [10, 30], AZIMUTHS), together.outline_shift)
    assert np.array_equal(
        self_shadow_share(height, mask, [10, 30], AZIMUTHS), together.shadow_share
    )


def test_unknown_heights_take_the_nearest_and_outside_does_not_count() -> None:
    """A hole of NaN in a level part changes nothing, and heights outside the mask are ignored."""
    height, mask = plane()
    height[20:40, 60:] = 12.0
    mask[:5] = False
    expected = generic_view(height, mask, [15, 45], AZIMUTHS)
    height[25:30, 70:80] = np.nan
    height[50, 10] = np.inf
    height[:5] = 1e6
    same(generic_view(height, mask, [15, 45], AZIMUTHS), expected, 1e-12)


def test_input_is_left_as_it_was() -> None:
    """The height and the mask given are not written to."""
    height, mask = rough()
    before = height.copy(), mask.copy()
    generic_view(height, mask, [15], [45])
    assert np.array_equal(height, before[0], equal_nan=True)
    assert np.array_equal(mask, before[1])


@pytest.mark.parametrize(
    ("height", "angles", "sentence"),
    [
        (np.full((4, 4), np.nan), [15], "none of the 16 pixels of the mask has a finite height"),
        (np.zeros((3, 4)), [15], r"expected heights of shape \(h, w\) = \(4, 4\), got \(3, 4\)"),
        (np.zeros((4, 4)), [90], r"expected angles from 0 to below 90 degrees, got \[90\]"),
        (np.zeros((4, 4)), [-1], "expected angles from 0 to below 90"),
        (np.zeros((4, 4)), [np.nan], "expected angles from 0 to below 90"),
    ],
)
def test_bad_input_is_told_in_a_sentence(height: Map, angles: list[float], sentence: str) -> None:
    """Unknown heights, another size and impossible angles are refused."""
    with pytest.raises(RelightlabError, match=sentence):
        generic_view(height, np.ones((4, 4), dtype=bool), angles, [0])


def test_empty_mask_and_endless_azimuth_are_refused() -> None:
    """An object without pixels and a direction that is no number are refused."""
    height, mask = plane(4, 4)
    with pytest.raises(RelightlabError, match="the mask is empty"):
        generic_view(height, ~mask, [15], [0])
    with pytest.raises(RelightlabError, match="expected azimuths in degrees"):
        generic_view(height, mask, [15], [np.inf])


@pytest.mark.parametrize("size", [24, 80])
def test_contour_shape_keeps_its_outline(size: int) -> None:
    """The paper's shape, whose crease is 45 degrees, moves no outline and casts no shadow."""
    mask = disk(size)
    view = generic_view(contour_base(mask, parameters()).height, mask, [5, 15], AZIMUTHS)
    assert view.outline_shift.max() < 2e-3
    assert view.shadow_share.max() == 0.0


@pytest.mark.real_data
@pytest.mark.parametrize("name", ["raccoon", "potato"])
def test_true_shapes_move_their_outlines_more(mit_berkeley_root: Path, name: str) -> None:
    """Real objects, whose outlines are not level, move more than their shapes from contour."""
    capture = MitBerkeley(mit_berkeley_root).load(name, "laboratory")
    mask, true = capture.photograph.mask, capture.truth.height
    assert true is not None
    ours = generic_view(contour_base(mask, parameters()).height, mask, [15, 45], [0, 45])
    theirs = generic_view(true, mask, [15, 45], [0, 45])
    assert ours.outline_shift[0].max() < 5e-4
    assert theirs.outline_shift[0].min() > 5e-3
    assert ours.shadow_share[0].max() == 0.0
    assert ours.shadow_share[1].mean() < theirs.shadow_share[1].mean()
