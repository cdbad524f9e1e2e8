"""Heights from normals: the surface whose slopes are nearest to those of measured normals."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from shading_model.arrays import Float, Map, Mask, Normals, check_map, check_mask
from shading_model.pixel_grid import PixelGrid, PoissonSolver

STEEPEST = 10.0
"""A slope is not taken above this: beyond 84 degrees a normal tells little of it."""
UNKNOWN_WEIGHT = 1e-4
"""Of an edge whose slope is not known: it holds the surface together, flat where it is alone."""
TOLERANCE = 1e-9


def height_of_normals(normals: Normals, mask: Mask) -> Map:
    """Return the heights whose slopes are nearest to those of the normals.

    Least squares over the edges between neighbouring pixels, where an edge's slope is the mean of
    its ends' (exact for quadratic surfaces). An edge weighs ``(N_z N_z')^2``: the slope ``-N_x /
    N_z`` of a normal known to some angle is uncertain as ``1 / N_z^2``, so grazing pixels give way.
    Each 4-connected part of the mask is solved on its own and has mean height zero: normals do not
    tell how far one part lies before another, nor the size of a step inside a part, which comes
    out as a steep slope.

    Parameters
    ----------
    normals : (h, w, 3) array
        Unit normals; NaN where unknown, also inside the mask, where the surface is then
        interpolated.
    mask : (h, w) bool array

    Returns
    -------
    (h, w) array
        Pixels, larger is nearer, NaN outside the mask.

    Raises
    ------
    RelightlabError
        If the mask is empty or of another size than the normals.

    Examples
    --------
    >>> normals = np.tile([-0.6, 0.0, 0.8], (2, 3, 1))  # rises by 3/4 of a pixel per column
    >>> height_of_normals(normals, np.ones((2, 3), bool)).round(6) + 0.0
    array([[-0.75,  0.  ,  0.75],
           [-0.75,  0.  ,  0.75]])
    """
    grid = PixelGrid(check_mask(mask))
    facing = check_map(normals, grid.mask, "normals", channels=3)[grid.mask]
    rise, weight = _edge_slopes(grid, facing)
    weighted = sparse.diags_array(weight) @ grid.gradient
    matrix = sparse.csr_array(grid.gradient.T @ weighted)
    solver = PoissonSolver(matrix, grid.components[1])
    return grid.spread(solver.solve(weighted.T @ rise, TOLERANCE))


def _edge_slopes(grid: PixelGrid, normals: Float) -> tuple[Float, Float]:
    """Return the rise along each edge and its weight."""
    known: Mask = np.asarray(np.isfinite(normals).all(axis=-1))
    upright = np.maximum(np.where(known, normals[:, 2], 1.0), 1e-12)
    across = np.where(known[:, None], -normals[:, :2], 0.0) / upright[:, None]
    steepness = np.linalg.norm(across, axis=-1, keepdims=True)
    slope = across * np.minimum(1.0, STEEPEST / np.maximum(steepness, 1e-12))
    mean = (slope[grid.start] + slope[grid.end]) / 2
    horizontal = np.arange(len(grid.start)) < grid.horizontal_edges
    # The end of a vertical edge lies below its start, so y falls along it.
    rise = np.where(horizontal, mean[:, 0], -mean[:, 1])
    both = known[grid.start] & known[grid.end]
    trust = np.maximum((upright[grid.start] * upright[grid.end]) ** 2, UNKNOWN_WEIGHT)
    return np.where(both, rise, 0.0), np.where(both, trust, UNKNOWN_WEIGHT)
