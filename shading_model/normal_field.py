"""The smoothest field of unit normals with given values on the boundary (`eq:normal`).

The energy is a Ginzburg-Landau functional whose minimiser is close to a harmonic map into the
sphere. Two facts make it quick to minimise. The inverse stereographic projection of the harmonic
extension of the boundary normals is the exact harmonic map on a disk and close to it elsewhere, so
it is where we start. And the Hessian is the Laplacian along the sphere and stiff across it, so one
multigrid cycle on the tangential part of the gradient and a division on the radial part make a
preconditioner whose quality does not depend on the number of pixels.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from shading_model.arrays import Float
from shading_model.pixel_grid import Indices, PixelGrid, PoissonSolver

TOLERANCE = 1e-5
"""The solver stops when the estimated relative distance to the minimum is below this."""
MAX_ITERATIONS = 60
START_TOLERANCE = 1e-2
MEMORY = 6


@dataclass(frozen=True, eq=False)
class NormalField:
    """Minimiser of `eq:normal`.

    Parameters
    ----------
    normals : (n, 3) array
        N at the pixels of the grid; its length is 1 up to O(|grad N|^2).
    energy : float
        Value of `eq:normal`.
    iterations : int
        Steps taken.
    decrement : float
        Estimated relative distance of `energy` to the minimum: half the squared gradient in the
        preconditioner's norm, over the energy.
    """

    normals: Float
    energy: float
    iterations: int
    decrement: float


def minimise_normal_energy(
    grid: PixelGrid,
    boundary_normals: Float,
    solver: PoissonSolver,
    start: Float | None = None,
    tolerance: float = TOLERANCE,
) -> NormalField:
    """Minimise ``sum |grad N|^2 + (|N|^2 - 1)^2`` with N held at the boundary pixels.

    Preconditioned limited-memory BFGS; along a step the energy is a quartic polynomial, so each
    line search is exact.

    Parameters
    ----------
    grid : PixelGrid
    boundary_normals : (n, 3) array
        Used at the boundary pixels only.
    solver : PoissonSolver
        Multigrid of the Laplacian on the interior pixels.
    start : (n, 3) array, optional
        First guess, NaN where there is none; by default the inverse stereographic projection of
        the harmonic extension of the boundary normals.
    tolerance : float
        See `NormalField.decrement`.

    Returns
    -------
    NormalField
    """
    inside = np.flatnonzero(~grid.boundary)
    normals = np.where(grid.boundary[:, None], boundary_normals, 0.0)
    problem = _Problem.of(grid, normals, inside)
    if inside.size == 0:
        return NormalField(normals, problem.constant, 0, 0.0)
    guess = None if start is None else start[inside]
    if guess is None or np.isnan(guess).any():
        extended = _inverse_stereographic(_harmonic_extension(problem, solver))
        guess = extended if guess is None else np.where(np.isnan(guess), extended, guess)
    interior, energy, iterations, decrement = _descend(problem, guess, solver, tolerance)
    normals[inside] = interior
    return NormalField(normals, energy, iterations, decrement)


@dataclass(frozen=True, eq=False)
class _Problem:
    """E(N) = N.(A N) - 2 N.b + constant + sum (|N|^2 - 1)^2 over the interior pixels."""

    matrix: sparse.csr_array
    linear: Float
    constant: float

    @classmethod
    def of(cls, grid: PixelGrid, normals: Float, inside: Indices) -> _Problem:
        rows: Any = grid.laplacian[inside]
        gradient = grid.gradient @ normals
        return cls(rows[:, inside], -(rows @ normals), float(np.sum(gradient**2)))

    def gradient(self, normals: Float, image: Float) -> Float:
        """Return dE/dN, given `image` = A N."""
        excess = _dot(normals, normals) - 1
        return 2 * (image - self.linear) + 4 * excess[:, None] * normals

    def energy(self, normals: Float, image: Float) -> float:
        excess = _dot(normals, normals) - 1
        smooth = np.vdot(normals, image - 2 * self.linear)
        return float(smooth + self.constant + excess @ excess)

    def best_step(self, normals: Float, step: Float, image_step: Float, gradient: Float) -> float:
        """Return the minimiser of E(N + t step) over t > 0, a quartic polynomial in t."""
        excess = _dot(normals, normals) - 1
        cross, square = _dot(normals, step), _dot(step, step)
        quartic = square @ square
        cubic = 4 * (cross @ square)
        quadratic = np.vdot(step, image_step) + 4 * (cross @ cross) + 2 * (excess @ square)
        slope = np.vdot(gradient, step)
        polynomial = np.array([quartic, cubic, quadratic, slope, 0.0])
        roots = np.roots(np.polyder(polynomial))
        candidates = roots[np.abs(roots.imag) < 1e-9].real
        candidates = candidates[candidates > 0]
        return float(candidates[np.argmin(np.polyval(polynomial, candidates))])


def _harmonic_extension(problem: _Problem, solver: PoissonSolver) -> Float:
    columns = [solver.solve(b, START_TOLERANCE) for b in problem.linear.T]
    return np.stack(columns, axis=-1)


def _inverse_stereographic(extension: Float) -> Float:
    """Map the in-plane extension onto the sphere: N = (2u, 2v, 1 - u^2 - v^2) / (1 + u^2 + v^2)."""
    squared = np.minimum(_dot(extension[:, :2], extension[:, :2]), 1.0)
    upright = 1 - squared
    sphere: Float = np.column_stack([2 * extension[:, :2], upright]) / (1 + squared)[:, None]
    return sphere


def _descend(
    problem: _Problem, normals: Float, solver: PoissonSolver, tolerance: float
) -> tuple[Float, float, int, float]:
    image = problem.matrix @ normals
    gradient = problem.gradient(normals, image)
    history: deque[tuple[Float, Float, float]] = deque(maxlen=MEMORY)
    decrement = np.inf
    for iteration in range(MAX_ITERATIONS + 1):
        precondition = _preconditioner(normals, solver)
        direction, natural = _two_loops(gradient, history, precondition)
        energy = problem.energy(normals, image)
        decrement = natural / 2 / max(energy, 1e-300)
        if decrement <= tolerance or iteration == MAX_ITERATIONS:
            break
        if np.vdot(direction, gradient) >= 0:
            history.clear()
            direction = -precondition(gradient)
        image_step = problem.matrix @ direction
        length = problem.best_step(normals, direction, image_step, gradient)
        normals = normals + length * direction
        image = image + length * image_step
        new_gradient = problem.gradient(normals, image)
        change = new_gradient - gradient
        curvature = length * float(np.vdot(direction, change))
        if curvature > 0:
            history.append((length * direction, change, 1 / curvature))
        gradient = new_gradient
    return normals, energy, iteration, decrement


def _preconditioner(normals: Float, solver: PoissonSolver) -> Callable[[Float], Float]:
    """Return an approximate inverse Hessian: multigrid along the sphere, a scaling across it."""
    unit = normals / np.linalg.norm(normals, axis=-1, keepdims=True)

    def apply(gradient: Float) -> Float:
        radial = _dot(unit, gradient)[:, None] * unit
        tangential = gradient - radial
        smooth = np.stack([solver.cycle(column) for column in tangential.T], axis=-1) / 2
        smooth -= _dot(unit, smooth)[:, None] * unit
        # The Hessian across the sphere is 2 Laplacian + 8, between 8 and 24.
        result: Float = smooth + radial / 12
        return result

    return apply


def _two_loops(
    gradient: Float,
    history: deque[tuple[Float, Float, float]],
    precondition: Callable[[Float], Float],
) -> tuple[Float, float]:
    """Return the limited-memory BFGS direction and gradient . (approximate inverse) gradient."""
    remaining = gradient.copy()
    weights = []
    for step, change, inverse in reversed(history):
        weights.append(inverse * np.vdot(step, remaining))
        remaining -= weights[-1] * change
    result = precondition(remaining)
    for (step, change, inverse), weight in zip(history, reversed(weights), strict=True):
        result += (weight - inverse * np.vdot(change, result)) * step
    return -result, float(np.vdot(gradient, result))


def _dot(first: Float, second: Float) -> Float:
    product: Float = np.einsum("ij,ij->i", first, second)
    return product
