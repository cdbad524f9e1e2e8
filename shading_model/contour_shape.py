"""Shape from contour: normals interpolated from the outline, then a height field with a crease."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates

from shading_model.arrays import Float, Map, Mask, Normals, check_mask
from shading_model.height_field import normals_of_height
from shading_model.normal_field import NormalField, minimise_normal_energy
from shading_model.pixel_grid import PixelGrid, PoissonSolver, boundary_of

OUTLINE_BLUR = 2.0
"""Deviation in pixels of the blur that contour normals are taken from."""
SLOPE_LIMIT = 1.0
"""The paper's epsilon, whose value it leaves open: the steepest slope is 1 / SLOPE_LIMIT.

At one a disk becomes a dome of 0.69 of its radius with a crease of 45 degrees. Chosen among 0.1,
0.3, 0.6 and 1 by the re-rendering error of the ten training objects of MIT-Berkeley: steeper shapes
relight worse in every setting and with every detail source, and the same holds on its test objects.
"""
HEIGHT_TOLERANCE = 1e-6
COARSEST_START = 4000
"""Objects with fewer pixels are solved without a coarser start."""


@dataclass(frozen=True, eq=False)
class ContourShape:
    """A coarse shape built from an outline alone.

    Parameters
    ----------
    height : (h, w) array
        Z in pixels, zero on the boundary, NaN outside the mask.
    normals : (h, w, 3) array
        Unit normals of `height`, NaN outside the mask; what the coarse shading is computed from.
    interpolated : (h, w, 3) array
        N of `eq:normal`, scaled to unit length: in-plane on the boundary, NaN outside the mask.
    energy : float
        Final value of `eq:normal`.
    iterations : int
        Steps taken to reach it.
    decrement : float
        Estimated relative distance of `energy` to the minimum.
    """

    height: Map
    normals: Normals
    interpolated: Normals
    energy: float
    iterations: int
    decrement: float


def shape_from_contour(mask: Mask, *, slope_limit: float = SLOPE_LIMIT) -> ContourShape:
    """Return the paper's coarse shape of a mask (`eq:normal` and the equation after it).

    Holes are outline too; every component is solved on its own; a part one or two pixels wide is
    all boundary and stays flat. Cost grows linearly with the number of pixels.

    Parameters
    ----------
    mask : (h, w) bool array
        May touch the picture's edge, which then is outline.
    slope_limit : float
        epsilon of the height equation: N_z is not taken below it.

    Raises
    ------
    RelightlabError
        If the mask is empty.

    Examples
    --------
    >>> shape = shape_from_contour(np.ones((9, 9), bool))
    >>> bool(shape.height[4, 4] > shape.height[4, 1] > shape.height[4, 0] == 0)
    True
    """
    grid = PixelGrid(check_mask(mask))
    solver = interior_solver(grid)
    field = interpolate_normals(grid, solver)
    height = grid.spread(integrate_normals(grid, field.normals, solver, slope_limit))
    unit = field.normals / np.linalg.norm(field.normals, axis=-1, keepdims=True)
    return ContourShape(
        height=height,
        normals=normals_of_height(height),
        interpolated=grid.spread(unit),
        energy=field.energy,
        iterations=field.iterations,
        decrement=field.decrement,
    )


def interpolate_normals(grid: PixelGrid, solver: PoissonSolver) -> NormalField:
    """Return the minimiser of `eq:normal`, started from the solution at half the resolution.

    A start that has the coarse structure right leaves only errors near the outline, so the number
    of steps at full resolution does not grow with the object.

    Parameters
    ----------
    grid : PixelGrid
    solver : PoissonSolver
        As `interior_solver` makes it for `grid`.

    Returns
    -------
    NormalField
    """
    boundary_normals = contour_normals(grid.mask)[grid.mask]
    return minimise_normal_energy(grid, boundary_normals, solver, _coarse_start(grid))


def _coarse_start(grid: PixelGrid) -> Float | None:
    if grid.size < COARSEST_START:
        return None
    rows, columns = (size + size % 2 for size in grid.mask.shape)
    even = np.zeros((rows, columns))
    even[: grid.mask.shape[0], : grid.mask.shape[1]] = grid.mask
    coarse_mask = even.reshape(rows // 2, 2, columns // 2, 2).mean(axis=(1, 3)) >= 0.5
    if not coarse_mask.any():
        return None
    coarse = PixelGrid(coarse_mask)
    field = interpolate_normals(coarse, interior_solver(coarse))
    return _sample(coarse, field.normals, (np.argwhere(grid.mask).T - 0.5) / 2)


def _sample(grid: PixelGrid, values: Float, positions: Float) -> Float:
    """Interpolate values (n, c) of the grid at positions (2, m), NaN where the grid is far."""
    layers = grid.spread(np.column_stack([values, np.ones(grid.size)]))
    maps = np.nan_to_num(np.moveaxis(layers, -1, 0))
    *sums, weight = [
        np.asarray(map_coordinates(layer, positions, order=1, mode="constant")) for layer in maps
    ]
    near = weight > 0
    interpolated: Float = np.where(near, np.stack(sums) / np.where(near, weight, 1), np.nan).T
    return interpolated


def contour_normals(mask: Mask) -> Normals:
    """Return the outward normal of the outline at its boundary pixels, NaN elsewhere.

    It is minus the gradient of the blurred mask, with N_z = 0. Where the outline has no outward
    side (a line one pixel wide) the normal faces the viewer.

    Examples
    --------
    >>> contour_normals(np.ones((5, 9), bool))[2, 8].round(3) + 0.0
    array([1., 0., 0.])
    """
    padding = int(np.ceil(4 * OUTLINE_BLUR)) + 1
    blurred = gaussian_filter(np.pad(mask.astype(np.float64), padding), OUTLINE_BLUR)
    gradient = np.asarray(np.gradient(blurred))
    down, right = gradient[:, padding:-padding, padding:-padding]
    steepness = np.hypot(down, right)
    defined = steepness > 1e-6
    safe = np.where(defined, steepness, 1.0)
    normals = np.stack([-right / safe, down / safe, np.zeros_like(safe)], axis=-1)
    normals[~defined] = (0.0, 0.0, 1.0)
    normals[~boundary_of(mask)] = np.nan
    return normals


def interior_solver(grid: PixelGrid) -> PoissonSolver:
    """Return the multigrid of the Laplacian on interior pixels, boundary pixels held fixed.

    Parameters
    ----------
    grid : PixelGrid

    Returns
    -------
    PoissonSolver
    """
    inside = np.flatnonzero(~grid.boundary)
    rows: Any = grid.laplacian[inside]
    return PoissonSolver(rows[:, inside])


def integrate_normals(
    grid: PixelGrid, normals: Float, solver: PoissonSolver, slope_limit: float
) -> Float:
    """Return the heights (n,) whose slopes are nearest to those of the normals (n, 3).

    Minimises ``sum |dZ/dx + N_x / max(eps, N_z)|^2 + |dZ/dy + N_y / max(eps, N_z)|^2`` over the
    edges of the mask, with Z = 0 on boundary pixels; an edge's slope is the mean of its ends'.

    Parameters
    ----------
    grid : PixelGrid
    normals : (n, 3) array
    solver : PoissonSolver
        As `interior_solver` makes it for `grid`.
    slope_limit : float
        epsilon.

    Returns
    -------
    (n,) array
        Pixels.
    """
    slope = -normals[:, :2] / np.maximum(slope_limit, normals[:, 2:])
    horizontal = slice(None, grid.horizontal_edges)
    vertical = slice(grid.horizontal_edges, None)
    along = np.empty(len(grid.start))
    along[horizontal] = (slope[grid.start[horizontal], 0] + slope[grid.end[horizontal], 0]) / 2
    # The end of a vertical edge lies below its start, so y falls along it.
    along[vertical] = -(slope[grid.start[vertical], 1] + slope[grid.end[vertical], 1]) / 2
    inside = ~grid.boundary
    height = np.zeros(grid.size)
    height[inside] = solver.solve((grid.gradient.T @ along)[inside], HEIGHT_TOLERANCE)
    return height
