"""What is done to a depth sensor's readings before they are a shape.

Readings that mix object and background, or stand alone, are thrown away; what is missing is filled;
noise is smoothed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage, sparse

from shading_model.arrays import Map, Mask
from shading_model.depth_map import median_of_known
from shading_model.errors import RelightlabError
from shading_model.pixel_grid import Indices, PixelGrid, PoissonSolver, boundary_of

LARGEST_HOLE_SHARE = 0.6
"""Largest share of the object without a reading that is filled."""
FILL_TOLERANCE = 1e-8
PULL = 1e-9
"""Pull of filled pixels to the trend: it alone decides where no reading is in reach."""
REACH = 2
"""Readings are compared to those at most this many sensor pixels away."""


@dataclass(frozen=True)
class Cleaning:
    """What is done to a sensor's readings before they are a shape.

    Parameters
    ----------
    least_coverage : float
        Readings of sensor pixels that the mask covers less than this share of are thrown away:
        they mix object and background.
    rim : int
        So are those of this many rings of sensor pixels beside them: a lens mixes neighbours.
    outlier_mm : float
        Readings that differ by more than this from the median of their 5 x 5 neighbours, and by
        more than four deviations (estimated from the median absolute one), are thrown away.
        Infinity keeps all.
    smoothing : float
        Deviation of a Gaussian in sensor pixels; 0 for none.

    Notes
    -----
    Rim and smoothing have the least error of normals of the simulated `KINECT_II` on the ten
    training objects of MIT-Berkeley: 13.1 degrees, for 15.5 without the ring, and 13.2 for a
    deviation of 2 pixels.
    """

    least_coverage: float = 0.9
    rim: int = 1
    outlier_mm: float = 8.0
    smoothing: float = 1.5


USUAL = Cleaning()
"""What a user of one frame of such a sensor does."""
AS_MEASURED = Cleaning(least_coverage=0.5, rim=0, outlier_mm=np.inf, smoothing=0.0)
"""Believes every reading, and fills only where there is none."""


def check_holes(readings: Map, coverage: Map, area: float) -> None:
    """Check that an object has enough readings to fill in the others.

    Parameters
    ----------
    readings : (r, c) array
        NaN where there is none.
    coverage : (r, c) array
        Share of each pixel that the object covers.
    area : float
        Of the object in the sensor's pixels, whether the sensor sees it or not.

    Raises
    ------
    RelightlabError
        If more than `LARGEST_HOLE_SHARE` of the object has no reading.

    Examples
    --------
    >>> check_holes(np.array([[500.0, np.nan, np.nan]]), np.ones((1, 3)), 3)
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: the depth map has no reading on 67 per cent of the ...
    """
    share = 1 - float(coverage[np.isfinite(readings)].sum()) / area
    # The sum of shares is rounded; a share of just the limit is still filled.
    if share > LARGEST_HOLE_SHARE + 1e-9:
        raise RelightlabError(
            f"the depth map has no reading on {100 * share:.0f} per cent of the object, and at most"
            f" {100 * LARGEST_HOLE_SHARE:.0f} can be filled: merge several frames, or check where"
            " the sensor's pixels lie in the picture"
        )


def accepted(readings: Map, coverage: Map, cleaning: Cleaning) -> Mask:
    """Return which readings are of the object alone and agree with their neighbours.

    Parameters
    ----------
    readings : (r, c) array
        Millimetres, NaN where there is none.
    coverage : (r, c) array
        Share of each pixel that the object covers.
    cleaning : Cleaning

    Returns
    -------
    (r, c) bool array
        Of an object too thin for any pixel to be covered well, the best covered ones.
    """
    known = np.isfinite(readings)
    covered = coverage >= cleaning.least_coverage
    if cleaning.rim:
        covered = ndimage.binary_erosion(covered, iterations=cleaning.rim, border_value=1)
    trusted = known & covered
    if not trusted.any():
        trusted = known & (coverage == coverage[known].max())
    if np.isinf(cleaning.outlier_mm):
        return trusted
    values = np.where(trusted, readings, np.nan)
    suspects = np.argwhere(_suspects(values, trusted, cleaning.outlier_mm))
    trusted[tuple(suspects[_disagrees(values, suspects, cleaning.outlier_mm)].T)] = False
    return trusted


def fill(values: Map, domain: Mask) -> Map:
    """Return values known all over a domain: harmonic where they were not.

    Parameters
    ----------
    values : (h, w) array
        NaN where unknown.
    domain : (h, w) bool array
        Parts of it that hold no known value get zero.

    Returns
    -------
    (h, w) array
        NaN outside the domain.

    Examples
    --------
    >>> fill(np.array([[1.0, np.nan, 3.0, 7.0]]), np.array([[1, 1, 1, 0]], bool)).round(6)
    array([[ 1.,  2.,  3., nan]])
    """
    inside = np.where(domain, values, np.nan)
    unknown = domain & np.isnan(values)
    if not unknown.any():
        return inside
    # Known pixels farther away than one step cannot enter the equations.
    around = ndimage.binary_dilation(unknown) & domain
    grid = PixelGrid(around)
    free = unknown[around]
    rows = grid.laplacian[np.flatnonzero(free)]
    matrix = rows[:, np.flatnonzero(free)]
    right = -(rows[:, np.flatnonzero(~free)] @ inside[around][~free])
    pulled = matrix + PULL * sparse.eye_array(matrix.shape[0], format="csr")
    inside[unknown] = PoissonSolver(sparse.csr_array(pulled)).solve(right, FILL_TOLERANCE)
    return inside


def smoothed(values: Map, deviation: float) -> Map:
    """Return values blurred by a Gaussian that leaves out what is unknown.

    Parameters
    ----------
    values : (h, w) array
        NaN where unknown.
    deviation : float
        Pixels; 0 for none.

    Returns
    -------
    (h, w) array
        NaN where `values` is.

    Examples
    --------
    >>> smoothed(np.array([[1.0, 1.0, np.nan]]), 2.0)
    array([[ 1.,  1., nan]])
    """
    if deviation == 0:
        return values
    known = np.isfinite(values)
    total = ndimage.gaussian_filter(np.where(known, values, 0.0), deviation, mode="constant")
    weight = ndimage.gaussian_filter(known.astype(np.float64), deviation, mode="constant")
    blurred: Map = np.divide(total, weight, out=np.full_like(total, np.nan), where=known)
    return blurred


def _suspects(values: Map, known: Mask, outlier_mm: float) -> Mask:
    """Return the readings at the rim, or far from their neighbours' mean; others are not tested."""
    window = 2 * REACH + 1
    total = ndimage.uniform_filter(np.where(known, values, 0.0), window, mode="constant")
    weight = ndimage.uniform_filter(known.astype(np.float64), window, mode="constant")
    mean = np.divide(total, weight, out=np.zeros_like(total), where=known)
    far = np.abs(values - mean) > outlier_mm / 2
    return known & (far | boundary_of(known))


def _disagrees(values: Map, places: Indices, outlier_mm: float) -> Mask:
    padded = np.pad(values, REACH, constant_values=np.nan)
    steps = np.indices((2 * REACH + 1,) * 2).reshape(2, -1, 1)
    around = padded[tuple(steps + places.T[:, None])]
    median = median_of_known(around)
    deviation = 1.4826 * median_of_known(np.abs(around - median))
    off = np.abs(values[tuple(places.T)] - median)
    result: Mask = off > np.maximum(outlier_mm, 4 * deviation)
    return result
