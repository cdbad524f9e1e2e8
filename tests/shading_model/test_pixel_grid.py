"""The graph of a mask's pixels and its Poisson equations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import label
from scipy.sparse.linalg import spsolve

from shading_model.arrays import Mask
from shading_model.contour_shape import interior_solver
from shading_model.pixel_grid import PixelGrid, PoissonSolver, boundary_of
from tests.shading_model.outlines import disk, masks


@given(masks())
def test_edges_join_all_neighbours_once(mask: Mask) -> None:
    """There is one edge for each pair of 4-neighbours, to the right or below."""
    grid = PixelGrid(mask)
    pairs = {
        (grid.index[r, c], grid.index[r + dr, c + dc])
        for r, c in np.argwhere(mask)
        for dr, dc in ((0, 1), (1, 0))
        if r + dr < mask.shape[0] and c + dc < mask.shape[1] and mask[r + dr, c + dc]
    }
    edges = list(zip(grid.start.tolist(), grid.end.tolist(), strict=True))
    assert len(edges) == len(pairs)
    assert set(edges) == pairs
    along_row = np.flatnonzero(mask.ravel())[grid.end] - np.flatnonzero(mask.ravel())[grid.start]
    if mask.shape[1] > 1:
        assert (along_row[: grid.horizontal_edges] == 1).all()
        assert (along_row[grid.horizontal_edges :] == mask.shape[1]).all()


def test_a_rectangle_has_the_counted_edges() -> None:
    """A h by w rectangle has h (w - 1) horizontal and (h - 1) w vertical edges."""
    grid = PixelGrid(np.ones((4, 7), bool))
    assert grid.size == 28
    assert grid.horizontal_edges == 4 * 6
    assert len(grid.start) == 4 * 6 + 3 * 7


@given(masks())
def test_the_laplacian_is_gradient_transposed_times_gradient(mask: Mask) -> None:
    """L = G^T G, so constants on a component are its null space."""
    grid = PixelGrid(mask)
    assert np.allclose(grid.laplacian.toarray(), (grid.gradient.T @ grid.gradient).toarray())
    count, component = grid.components
    for k in range(count):
        assert np.allclose(grid.laplacian @ (component == k).astype(float), 0)


@given(masks())
def test_components_are_those_of_an_image_library(mask: Mask) -> None:
    """4-connected components agree with scipy.ndimage.label."""
    labels, expected = label(mask)
    count, component = PixelGrid(mask).components
    assert count == expected
    assert len({*zip(component.tolist(), labels[mask].tolist(), strict=True)}) == expected


@given(masks())
def test_the_boundary_is_where_a_neighbour_is_missing(mask: Mask) -> None:
    """Outside the picture counts as outside the mask."""
    for r, c in np.argwhere(mask):
        around = [(r - 1, c), (r + 1, c), (r, c - 1), (r, c + 1)]
        missing = any(
            not (0 <= i < mask.shape[0] and 0 <= j < mask.shape[1] and mask[i, j])
            for i, j in around
        )
        assert boundary_of(mask)[r, c] == missing
    assert not boundary_of(mask)[~mask].any()
    assert (PixelGrid(mask).boundary == boundary_of(mask)[mask]).all()


@given(masks())
def test_spread_puts_values_back_in_order(mask: Mask) -> None:
    """Reading a spread map inside the mask gives the values; outside it is NaN."""
    grid = PixelGrid(mask)
    values = np.arange(2.0 * grid.size).reshape(-1, 2)
    full = grid.spread(values)
    assert (full[mask] == values).all()
    assert np.isnan(full[~mask]).all()


def random_mask(seed: int, side: int = 40) -> Mask:
    """A ragged mask with holes and several components."""
    return np.random.default_rng(seed).random((side, side)) > 0.25


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_fixed_boundary_solutions_agree_with_a_direct_solver(seed: int) -> None:
    """With boundary pixels held, multigrid gives what a factorisation gives."""
    grid = PixelGrid(np.pad(random_mask(seed, 30) | disk(14)[0][:30, :30], 3, mode="edge"))
    inside = np.flatnonzero(~grid.boundary)
    matrix = grid.laplacian[inside][:, inside]
    right = np.random.default_rng(seed).normal(size=inside.size)
    solution = interior_solver(grid).solve(right, 1e-10)
    assert np.allclose(solution, spsolve(matrix.tocsc(), right), rtol=0, atol=1e-6)


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_singular_components_get_mean_zero_solutions(seed: int) -> None:
    """Without fixed pixels each component's solution has mean zero and meets the equation."""
    grid = PixelGrid(random_mask(seed))
    count, component = grid.components
    assert count > 1
    right = grid.gradient.T @ np.random.default_rng(seed).normal(size=len(grid.start))
    solution = PoissonSolver(grid.laplacian, component).solve(right, 1e-10)
    sums = np.bincount(component, weights=solution)
    assert np.abs(sums).max() < 1e-9 * np.abs(solution).sum()
    assert np.linalg.norm(grid.laplacian @ solution - right) < 1e-8 * np.linalg.norm(right)


def test_an_inconsistent_right_hand_side_is_made_consistent() -> None:
    """What a component's mean adds to the right-hand side changes nothing."""
    grid = PixelGrid(np.array([[True] * 5 + [False] + [True] * 4] * 4))
    solver = PoissonSolver(grid.laplacian, grid.components[1])
    right = grid.gradient.T @ np.linspace(-1, 1, len(grid.start))
    shifted = right + np.where(grid.components[1] == 0, 3.0, -2.0)
    assert np.allclose(solver.solve(right, 1e-12), solver.solve(shifted, 1e-12))


def test_nothing_to_solve_gives_zeros() -> None:
    """A zero right-hand side, and a system of no unknowns, need no multigrid."""
    grid = PixelGrid(np.ones((6, 6), bool))
    assert (interior_solver(grid).solve(np.zeros(16), 1e-8) == 0).all()
    thin = interior_solver(PixelGrid(np.ones((1, 6), bool)))
    assert thin.solve(np.zeros(0), 1e-8).shape == (0,)
    assert thin.cycle(np.zeros(0)).shape == (0,)


def test_a_solution_and_a_cycle_are_the_same_bytes_twice() -> None:
    """Two solvers built from the same mask agree to the last bit."""
    grid = PixelGrid(disk(30)[0])
    right = np.random.default_rng(0).normal(size=grid.size)
    one, other = (PoissonSolver(grid.laplacian, grid.components[1]) for _ in range(2))
    assert one.solve(right, 1e-8).tobytes() == other.solve(right, 1e-8).tobytes()
    assert one.cycle(right).tobytes() == other.cycle(right).tobytes()


def test_a_cycle_is_symmetric_and_positive() -> None:
    """As a preconditioner of conjugate gradients must be."""
    grid = PixelGrid(disk(20)[0])
    solver = interior_solver(grid)
    first, second = np.random.default_rng(1).normal(size=(2, int((~grid.boundary).sum())))
    one, other = solver.cycle(first), solver.cycle(second)
    assert np.isclose(one @ second, first @ other, rtol=1e-8)
    assert one @ first > 0


@pytest.mark.parametrize("tolerance", [1e-2, 1e-5, 1e-8])
def test_the_residual_is_below_the_tolerance(tolerance: float) -> None:
    """The stated tolerance is met, whatever it is."""
    grid = PixelGrid(disk(40)[0])
    inside = np.flatnonzero(~grid.boundary)
    right = np.random.default_rng(2).normal(size=inside.size)
    solution = interior_solver(grid).solve(right, tolerance)
    residual = grid.laplacian[inside][:, inside] @ solution - right
    assert np.linalg.norm(residual) <= tolerance * np.linalg.norm(right)


@pytest.mark.parametrize("share", [0.3, 0.5, 0.62])
def test_thousands_of_components_are_solved_to_the_tolerance(share: float) -> None:
    """Dust, islands and threads of pixels meet the tolerance, and the library does not warn."""
    generator = np.random.default_rng(7)
    grid = PixelGrid(generator.random((400, 400)) < share)
    right = grid.gradient.T @ generator.normal(size=len(grid.start))
    solution = PoissonSolver(grid.laplacian, grid.components[1]).solve(right, 1e-8)
    residual = grid.laplacian @ solution - right
    assert np.linalg.norm(residual) <= 1e-8 * np.linalg.norm(right)
