"""The graph of a mask's pixels, and Poisson equations on it.

Unknowns live on the pixels of a mask; every pair of 4-neighbours inside the mask is an edge. All
problems on it are solved by algebraic multigrid (pyamg), whose cost grows linearly with the pixels.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pyamg
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from shading_model.arrays import Float, Map, Mask

Indices = NDArray[np.intp]
COARSEST_UNKNOWNS = 200
MAX_STEPS = 100
SINGULAR_SHIFT = 1e-8
"""Added to the diagonal of a singular matrix where its multigrid is built, not where it is solved.

The constants of thousands of small components would be zero up to rounding on the coarse grids, and
their inverse anything.
"""


@dataclass(frozen=True, eq=False)
class PixelGrid:
    """Pixels of a mask, numbered in row-major order, and their 4-neighbour edges.

    Parameters
    ----------
    mask : (h, w) bool array

    Examples
    --------
    >>> grid = PixelGrid(np.ones((2, 2), bool))
    >>> grid.size, len(grid.start)
    (4, 4)
    """

    mask: Mask

    @cached_property
    def size(self) -> int:
        """Number of pixels n."""
        return int(np.count_nonzero(self.mask))

    @cached_property
    def index(self) -> Indices:
        """Number of each pixel, shape (h, w); -1 outside the mask."""
        index = np.full(self.mask.shape, -1, dtype=np.intp)
        index[self.mask] = np.arange(self.size)
        return index

    @cached_property
    def _horizontal(self) -> tuple[Indices, Indices]:
        pair = self.mask[:, :-1] & self.mask[:, 1:]
        return self.index[:, :-1][pair], self.index[:, 1:][pair]

    @cached_property
    def _vertical(self) -> tuple[Indices, Indices]:
        pair = self.mask[:-1] & self.mask[1:]
        return self.index[:-1][pair], self.index[1:][pair]

    @cached_property
    def start(self) -> Indices:
        """First pixel of each edge, shape (e,): the horizontal edges, then the vertical ones."""
        return np.concatenate([self._horizontal[0], self._vertical[0]])

    @cached_property
    def end(self) -> Indices:
        """Second pixel of each edge: right of, or below, the first."""
        return np.concatenate([self._horizontal[1], self._vertical[1]])

    @property
    def horizontal_edges(self) -> int:
        """How many of the edges are horizontal (they come first)."""
        return len(self._horizontal[0])

    @cached_property
    def gradient(self) -> sparse.csr_array:
        """Differences end - start along the edges, shape (e, n)."""
        edges = len(self.start)
        values = np.tile([-1.0, 1.0], edges)
        columns = np.stack([self.start, self.end], axis=1).ravel()
        rows = np.arange(0, 2 * edges + 1, 2)
        return sparse.csr_array((values, columns, rows), shape=(edges, self.size))

    @cached_property
    def laplacian(self) -> sparse.csr_array:
        """Graph Laplacian of the mask, shape (n, n), positive semidefinite."""
        both = np.concatenate([self.start, self.end]), np.concatenate([self.end, self.start])
        adjacency = sparse.csr_array((np.ones(len(both[0])), both), shape=(self.size, self.size))
        return sparse.csr_array(sparse.diags_array(adjacency.sum(axis=1)) - adjacency)

    @cached_property
    def boundary(self) -> NDArray[np.bool_]:
        """Which of the n pixels have a 4-neighbour outside the mask (or outside the picture)."""
        return boundary_of(self.mask)[self.mask]

    @cached_property
    def components(self) -> tuple[int, Indices]:
        """Number of 4-connected components and the component of each pixel."""
        count, label = connected_components(self.laplacian, directed=False)
        return int(count), label.astype(np.intp)

    def spread(self, values: Float) -> Map:
        """Return values of shape (n,) or (n, c) as a map over the picture, NaN outside."""
        full = np.full((*self.mask.shape, *values.shape[1:]), np.nan)
        full[self.mask] = values
        return full


def boundary_of(mask: Mask) -> Mask:
    """Return the pixels of `mask` with a 4-neighbour outside it or beyond the picture's edge.

    Examples
    --------
    >>> boundary_of(np.ones((3, 3), bool)).astype(int)
    array([[1, 1, 1],
           [1, 0, 1],
           [1, 1, 1]])
    """
    padded = np.pad(mask, 1)
    surrounded = padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
    result: Mask = mask & ~surrounded
    return result


class PoissonSolver:
    """Multigrid for one symmetric positive semidefinite grid Laplacian.

    The hierarchy is built once and serves any number of right-hand sides. A component of a
    singular system (no fixed pixel) gets the solution of mean zero; its right-hand side is made
    consistent by taking out its mean.

    Parameters
    ----------
    matrix : (n, n) sparse array
    component : (n,) int array, optional
        For a singular matrix: the component of each pixel.
    """

    def __init__(self, matrix: sparse.csr_array, component: Indices | None = None) -> None:
        self._size = matrix.shape[0]
        self._component = component
        if self._size:
            shift = 0.0 if component is None else SINGULAR_SHIFT
            self._matrix = _short_indices(matrix)
            regular = _short_indices(matrix + shift * sparse.eye_array(self._size, format="csr"))
            hierarchy = pyamg.ruge_stuben_solver(regular, max_coarse=COARSEST_UNKNOWNS)
            self._cycle: Any = hierarchy.aspreconditioner(cycle="V")

    def solve(self, right: Float, tolerance: float, start: Float | None = None) -> Float:
        """Return x with ``|A x - right| <= tolerance |right|`` (conjugate gradients).

        Parameters
        ----------
        right : (n,) array
        tolerance : float
            Relative residual.
        start : (n,) array, optional
            First guess; zero if not given.

        Raises
        ------
        ArithmeticError
            If the tolerance is not reached in `MAX_STEPS` steps; ten are usual.
        """
        consistent = self._centred(right)
        if not consistent.any():
            return np.zeros(self._size)
        solution, failed = pyamg.krylov.cg(
            self._matrix, consistent, x0=start, tol=tolerance, maxiter=MAX_STEPS, M=self._cycle
        )
        if failed:
            raise ArithmeticError(
                f"the Poisson equation of {self._size} pixels was not solved to {tolerance:g}"
                f" in {MAX_STEPS} steps"
            )
        return self._centred(solution)

    def cycle(self, right: Float) -> Float:
        """Return one V-cycle applied to `right`: an approximate inverse, symmetric and positive."""
        result: Float = self._cycle @ right if self._size else right
        return result

    def _centred(self, values: Float) -> Float:
        if self._component is None:
            return values
        counts = np.bincount(self._component)
        means = np.bincount(self._component, weights=values) / counts
        centred: Float = values - means[self._component]
        return centred


def _short_indices(matrix: sparse.csr_array) -> sparse.csr_matrix:
    """Return the matrix as pyamg wants it: of SciPy's older kind, with 32-bit indices."""
    legacy = sparse.csr_matrix(matrix)
    legacy.indices = legacy.indices.astype(np.int32)
    legacy.indptr = legacy.indptr.astype(np.int32)
    return legacy
