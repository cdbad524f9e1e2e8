"""Shape from contour: normals, then height."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from shading_model.arrays import Mask
from shading_model.contour_shape import (
    ContourShape,
    contour_normals,
    integrate_normals,
    interior_solver,
    interpolate_normals,
    shape_from_contour,
)
from shading_model.errors import RelightlabError
from shading_model.normal_field import TOLERANCE
from shading_model.pixel_grid import PixelGrid, boundary_of
from tests.shading_model.outlines import angles, disk, inverse_stereographic, masks


@pytest.fixture(scope="module", params=[50, 100, 200])
def round_shape(request: pytest.FixtureRequest) -> tuple[int, ContourShape]:
    """A disk of a radius in pixels, and its shape."""
    return request.param, shape_from_contour(disk(request.param)[0])


def test_the_normals_of_a_disk_are_the_inverse_stereographic_projection(
    round_shape: tuple[int, ContourShape],
) -> None:
    """The mean angular error is below one degree at radius 100 and falls as the radius grows."""
    radius, shape = round_shape
    mask, x, y = disk(radius)
    error = angles(shape.interpolated, inverse_stereographic(x, y), mask).mean()
    # Measured: 0.68, 0.35 and 0.22 degrees.
    assert error < 50 / radius


def test_the_height_of_a_disk_is_the_closed_form(round_shape: tuple[int, ContourShape]) -> None:
    """Z = R (ln 2 - ln(1 + r^2)) for a slope limit of one, within one pixel.

    There dZ/dr = -N_r / max(1, N_z) = -2r / (1 + r^2). The boundary pixels, where Z = 0, lie up
    to a pixel inside the circle, so the error in pixels does not shrink with the radius.
    """
    radius, shape = round_shape
    mask, x, y = disk(radius)
    expected = radius * (np.log(2) - np.log1p(x**2 + y**2))
    error = (shape.height - expected)[mask]
    assert np.abs(error).max() < 1.0
    assert np.isclose(np.nanmax(shape.height), radius * np.log(2), atol=1.0)


def test_the_steps_at_full_resolution_do_not_grow(round_shape: tuple[int, ContourShape]) -> None:
    """Eight steps are enough from radius 50 to 200, at the stated tolerance."""
    _, shape = round_shape
    assert 1 <= shape.iterations <= 8
    assert shape.decrement <= TOLERANCE


def lobed(side: int = 60) -> Mask:
    """A lopsided outline with a hole."""
    rows, columns = np.mgrid[:side, :side] - (side - 1) / 2
    angle = np.arctan2(rows, columns)
    outline = np.hypot(rows, columns) < side * (0.34 + 0.1 * np.cos(3 * angle + 0.4))
    hole = np.hypot(rows - 5, columns + 4) < side / 10
    return outline & ~hole


def test_mirrored_and_turned_outlines_have_mirrored_and_turned_shapes() -> None:
    """Left and right, and the four quarters of a turn, are all alike to the solver."""
    shape = shape_from_contour(lobed())
    mirrored = shape_from_contour(lobed()[:, ::-1])
    turned = shape_from_contour(np.rot90(lobed()))
    scale = np.nanmax(shape.height)
    assert np.allclose(mirrored.height[:, ::-1], shape.height, atol=2e-3 * scale, equal_nan=True)
    assert np.allclose(np.rot90(turned.height, -1), shape.height, atol=2e-3 * scale, equal_nan=True)
    flipped = mirrored.interpolated[:, ::-1] * [-1, 1, 1]
    back = np.rot90(turned.interpolated, -1)
    # np.rot90 turns counterclockwise: (x, y) becomes (-y, x), and is turned back here.
    back = np.stack([back[..., 1], -back[..., 0], back[..., 2]], axis=-1)
    assert angles(flipped, shape.interpolated, lobed()).max() < 0.5
    assert angles(back, shape.interpolated, lobed()).max() < 0.5


def test_the_crease_is_at_height_zero_and_all_else_above() -> None:
    """Z = 0 at every boundary pixel, of the hole too, and positive inside."""
    shape, edge = shape_from_contour(lobed()), boundary_of(lobed())
    assert (shape.height[edge] == 0).all()
    assert (shape.height[lobed() & ~edge] > 0).all()
    assert np.isnan(shape.height[~lobed()]).all()
    assert np.isnan(shape.normals[~lobed()]).all()
    assert np.allclose(np.linalg.norm(shape.interpolated[lobed()], axis=-1), 1)
    assert np.allclose(np.linalg.norm(shape.normals[lobed()], axis=-1), 1)


def test_boundary_normals_point_out_of_the_outline() -> None:
    """In-plane at the boundary, outward of the disk and into the hole, within three degrees."""
    mask, x, y = disk(40)
    ring = mask & ~(np.hypot(x, y) < 0.4)
    normals, edge = contour_normals(ring), boundary_of(ring)
    assert np.isnan(normals[~edge]).all()
    assert (normals[edge][:, 2] == 0).all()
    outward = np.stack([x, y, np.zeros_like(x)], axis=-1)
    outward /= np.maximum(np.hypot(x, y), 1e-9)[..., None]
    outer = edge & (np.hypot(x, y) > 0.7)
    inner = edge & (np.hypot(x, y) < 0.7)
    assert angles(normals, outward, outer).mean() < 3
    assert angles(normals, -outward, inner).mean() < 3


def test_the_height_solves_the_discrete_poisson_equation() -> None:
    """Div grad Z equals the divergence of the slopes at every interior pixel."""
    mask = lobed()
    grid = PixelGrid(mask)
    solver = interior_solver(grid)
    normals = interpolate_normals(grid, solver).normals
    height = grid.spread(integrate_normals(grid, normals, solver, 0.5))
    slope = grid.spread(-normals[:, :2] / np.maximum(0.5, normals[:, 2:]))
    worst = 0.0
    largest = 0.0
    for r, c in np.argwhere(mask & ~boundary_of(mask)):
        balance = 0.0
        # Uphill toward a neighbour is the mean of both ends' slopes in its direction.
        for dr, dc in ((0, 1), (0, -1), (1, 0), (-1, 0)):
            uphill = (slope[r, c] + slope[r + dr, c + dc]) / 2 @ np.array([dc, -dr])
            balance += height[r + dr, c + dc] - height[r, c] - uphill
            largest = max(largest, abs(uphill))
        worst = max(worst, abs(balance))
    assert worst < 1e-3 * largest


def test_steeper_slopes_are_allowed_by_a_smaller_limit() -> None:
    """A disk gets higher as epsilon falls, and never steeper than 1 / epsilon over its radius."""
    mask = disk(30)[0]
    tops = [np.nanmax(shape_from_contour(mask, slope_limit=e).height) for e in (2.0, 1.0, 0.3)]
    assert tops == sorted(tops)
    assert tops[0] < 30 / 2
    assert tops[1] > 1.9 * tops[0]


def test_each_component_is_what_it_is_alone() -> None:
    """Components far apart do not know of each other."""
    one, other = disk(20)[0], lobed(50)
    both = np.zeros((60, 120), bool)
    both[4 : 4 + one.shape[0], 3 : 3 + one.shape[1]] = one
    both[6:56, 64:114] = other
    together = shape_from_contour(both)
    alone = shape_from_contour(one), shape_from_contour(other)
    windows = (
        together.height[4 : 4 + one.shape[0], 3 : 3 + one.shape[1]],
        together.height[6:56, 64:114],
    )
    for window, shape in zip(windows, alone, strict=True):
        assert np.allclose(
            window, shape.height, atol=5e-3 * np.nanmax(shape.height), equal_nan=True
        )
    assert np.isclose(together.energy, sum(shape.energy for shape in alone), rtol=1e-4)


@pytest.mark.parametrize("thickness", [1, 2])
def test_a_thin_line_stays_flat(thickness: int) -> None:
    """A part one or two pixels wide is all boundary: height zero, no NaN."""
    mask = np.zeros((9, 30), bool)
    mask[4 : 4 + thickness, 3:27] = True
    shape = shape_from_contour(mask)
    assert (shape.height[mask] == 0).all()
    assert np.isfinite(shape.interpolated[mask]).all()
    assert np.isfinite(shape.normals[mask]).all()


def test_a_thin_handle_does_not_disturb_the_body() -> None:
    """A line one pixel wide tied to a disk stays at zero and leaves the disk's top as it is."""
    mask = np.pad(disk(20)[0], ((0, 0), (0, 20)))
    plain = np.nanmax(shape_from_contour(mask).height)
    mask[22, 40:60] = True
    shape = shape_from_contour(mask)
    assert (shape.height[22, 44:60] == 0).all()
    assert np.isclose(np.nanmax(shape.height), plain, rtol=0.01)


def test_the_pictures_edge_is_outline() -> None:
    """A mask that fills its picture has the shape it has with room around it."""
    full = shape_from_contour(np.ones((30, 41), bool))
    padded = shape_from_contour(np.pad(np.ones((30, 41), bool), 7))
    assert np.allclose(full.height, padded.height[7:-7, 7:-7], atol=1e-3 * full.height.max())
    assert full.height[0].max() == full.height[:, -1].max() == 0


@settings(max_examples=40)
@given(masks(12))
def test_any_mask_has_a_shape(mask: Mask) -> None:
    """Every nonempty mask gives finite maps inside it, NaN outside, and Z = 0 on its boundary."""
    shape = shape_from_contour(mask)
    assert np.isfinite(shape.height[mask]).all()
    assert np.isfinite(shape.normals[mask]).all()
    assert np.isfinite(shape.interpolated[mask]).all()
    assert np.isnan(shape.height[~mask]).all()
    assert (shape.height[boundary_of(mask)] == 0).all()


def test_the_same_mask_gives_the_same_bytes() -> None:
    """Two runs agree to the last bit."""
    one, other = shape_from_contour(lobed(90)), shape_from_contour(lobed(90))
    assert one.height.tobytes() == other.height.tobytes()
    assert one.interpolated.tobytes() == other.interpolated.tobytes()


def test_an_empty_mask_is_refused() -> None:
    """With no pixel there is no shape."""
    with pytest.raises(RelightlabError, match="the mask is empty"):
        shape_from_contour(np.zeros((5, 5), bool))
