"""The energy of the normal field (`eq:normal`) and its minimiser."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shading_model.arrays import Float, Mask
from shading_model.contour_shape import contour_normals, interior_solver
from shading_model.normal_field import _Problem, minimise_normal_energy
from shading_model.pixel_grid import PixelGrid
from tests.shading_model.outlines import disk

OUTLINE = disk(9)[0] & ~np.pad(disk(2)[0], 7)


def outline_problem(mask: Mask) -> tuple[PixelGrid, Float, _Problem]:
    """The grid of a mask, its boundary normals (n, 3) and the energy's pieces."""
    grid = PixelGrid(mask)
    normals = np.where(grid.boundary[:, None], contour_normals(mask)[mask], 0.0)
    return grid, normals, _Problem.of(grid, normals, np.flatnonzero(~grid.boundary))


def direct_energy(mask: Mask, field: Float) -> float:
    """The energy summed over neighbours and pixels one at a time."""
    total = 0.0
    for row, column in np.argwhere(mask):
        own = field[row, column]
        total += (own @ own - 1) ** 2
        for other in ((row + 1, column), (row, column + 1)):
            if other[0] < mask.shape[0] and other[1] < mask.shape[1] and mask[other]:
                total += np.sum((field[other] - own) ** 2)
    return float(total)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_the_energy_is_the_sum_over_edges_and_pixels(seed: int) -> None:
    """The matrix form agrees with the double loop for any normals inside."""
    generator = np.random.default_rng(seed)
    mask = np.pad(disk(5)[0], 1) | (generator.random((17, 17)) > 0.6)
    grid, normals, problem = outline_problem(mask)
    interior = generator.normal(size=(int((~grid.boundary).sum()), 3))
    normals[~grid.boundary] = interior
    energy = problem.energy(interior, problem.matrix @ interior)
    assert np.isclose(energy, direct_energy(mask, grid.spread(normals)), rtol=1e-10)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_the_gradient_agrees_with_finite_differences(seed: int) -> None:
    """Along random directions, to the accuracy of central differences."""
    generator = np.random.default_rng(seed)
    _, _, problem = outline_problem(OUTLINE)
    normals, direction = generator.normal(size=(2, *problem.linear.shape))
    step = 1e-5

    def energy(offset: float) -> float:
        moved = normals + offset * direction
        return problem.energy(moved, problem.matrix @ moved)

    slope = np.vdot(problem.gradient(normals, problem.matrix @ normals), direction)
    assert np.isclose((energy(step) - energy(-step)) / (2 * step), slope, rtol=1e-6, atol=1e-3)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_the_best_step_minimises_along_the_line(seed: int) -> None:
    """No point of a dense sweep of the line lies lower than the chosen step."""
    generator = np.random.default_rng(seed)
    _, _, problem = outline_problem(OUTLINE)
    normals = generator.normal(size=problem.linear.shape)
    image = problem.matrix @ normals
    gradient = problem.gradient(normals, image)
    direction = -gradient * generator.uniform(0.5, 1.5, size=gradient.shape)
    image_step = problem.matrix @ direction
    best = problem.best_step(normals, direction, image_step, gradient)
    assert best > 0
    lowest = problem.energy(normals + best * direction, image + best * image_step)
    for factor in np.linspace(0, 3, 61):
        length = factor * best
        along = problem.energy(normals + length * direction, image + length * image_step)
        assert along >= lowest - 1e-9 * abs(lowest)


def solved(mask: Mask, start: Float | None = None, tolerance: float = 1e-5) -> tuple[Float, float]:
    """The minimiser (n, 3) and its energy, from a start of one's own."""
    grid = PixelGrid(mask)
    boundary_normals = contour_normals(mask)[mask]
    field = minimise_normal_energy(
        grid, boundary_normals, interior_solver(grid), start, tolerance=tolerance
    )
    assert field.decrement <= tolerance
    return field.normals, field.energy


def test_the_energy_decreases_with_the_tolerance() -> None:
    """A tighter tolerance never ends higher; the stated distance is right within a factor five."""
    mask = np.pad(np.ones((40, 60), bool), 2)
    mask[20:, 30:] = False
    start = np.tile([0.0, 0.0, 1.0], (int(mask.sum()), 1))
    tolerances = [1e-1, 1e-2, 1e-3, 1e-5, 1e-9]
    energies = [solved(mask, start, tolerance)[1] for tolerance in tolerances]
    assert energies == sorted(energies, reverse=True)
    assert energies[0] > energies[-1]
    for tolerance, energy in zip(tolerances[:-1], energies[:-1], strict=True):
        assert energy / energies[-1] - 1 < 5 * tolerance


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_converged_energy_does_not_depend_on_the_start(seed: int) -> None:
    """Random starts in the upper half space end where the default start does."""
    mask = disk(14)[0]
    reference_normals, reference = solved(mask, tolerance=1e-9)
    start = np.random.default_rng(seed).normal(size=(int(mask.sum()), 3))
    start[:, 2] = np.abs(start[:, 2])
    normals, energy = solved(mask, start, tolerance=1e-9)
    assert np.isclose(energy, reference, rtol=1e-7)
    assert np.allclose(normals, reference_normals, atol=1e-3)


def test_missing_parts_of_a_start_are_filled() -> None:
    """NaN in the start stands for the default start, and the end is the same."""
    mask = disk(14)[0]
    start = np.tile([0.0, 0.0, 1.0], (int(mask.sum()), 1))
    start[::3] = np.nan
    assert np.isclose(solved(mask, start, 1e-8)[1], solved(mask, tolerance=1e-8)[1], rtol=1e-6)


def test_boundary_normals_are_held() -> None:
    """The minimiser keeps the given normals at boundary pixels to the bit."""
    grid = PixelGrid(OUTLINE)
    given = contour_normals(OUTLINE)[OUTLINE]
    field = minimise_normal_energy(grid, given, interior_solver(grid))
    assert (field.normals[grid.boundary] == given[grid.boundary]).all()
    assert np.isclose(field.energy, direct_energy(OUTLINE, grid.spread(field.normals)))


def test_a_mask_that_is_all_boundary_needs_no_step() -> None:
    """The field of a thin line is its boundary normals."""
    grid = PixelGrid(np.ones((2, 9), bool))
    given = contour_normals(grid.mask)[grid.mask]
    field = minimise_normal_energy(grid, given, interior_solver(grid))
    assert field.iterations == 0
    assert (field.normals == given).all()
    assert np.isclose(field.energy, direct_energy(grid.mask, grid.spread(given)))
