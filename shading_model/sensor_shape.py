"""The base shape of a depth sensor: its readings cleaned, filled, smoothed and set on the picture.

What a user of such a sensor does before relighting: throw away readings that mix object and
background, fill what is missing, smooth the noise, and bring the sensor's few pixels to those of
the photograph. A sensor's view is taken for a parallel one at the object's median distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage, sparse
from scipy.interpolate import RectBivariateSpline

from shading_model.arrays import Float, Map, Mask, check_mask
from shading_model.depth_map import DepthMap, Registration, median_of_known
from shading_model.errors import RelightlabError
from shading_model.height_field import normals_inside_outline
from shading_model.object_model import CoarseShape
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
    training objects of MIT-Berkeley: 13.2 degrees, for 15.3 without the ring, and 13.3 for a
    deviation of 2 pixels.
    """

    least_coverage: float = 0.9
    rim: int = 1
    outlier_mm: float = 8.0
    smoothing: float = 1.5


AS_MEASURED = Cleaning(least_coverage=0.5, rim=0, outlier_mm=np.inf, smoothing=0.0)
"""Believes every reading, and fills only where there is none."""


def shape_from_depth(depth: DepthMap, mask: Mask, cleaning: Cleaning = Cleaning()) -> CoarseShape:
    """Return the base shape that a depth sensor gives of the object in a picture.

    Heights are minus the depth, in pixels of the picture, zero at their median. Holes get the
    harmonic function that continues the readings around them, after a quadratic fitted to all
    readings has been taken out; so holes in a plane or a quadratic are filled exactly, and
    smoothing does not flatten them.

    Parameters
    ----------
    depth : DepthMap
        Of one frame or several, whose median is taken.
    mask : (h, w) bool array
        The object in the picture.
    cleaning : Cleaning

    Returns
    -------
    CoarseShape
        Known all over the mask.

    Raises
    ------
    RelightlabError
        If the mask is empty, more than 60 per cent of it has no reading (or lies outside the
        sensor's view), or the sizes do not belong together.

    Examples
    --------
    >>> readings = np.tile(500.0 + np.arange(8), (8, 1))
    >>> readings[3, 3:6] = 0.0
    >>> shape = shape_from_depth(DepthMap(readings, focal_length=500.0), np.ones((8, 8), bool))
    >>> shape.height[3].round(2)
    array([ 3.48,  2.48,  1.49,  0.5 , -0.5 , -1.49, -2.48, -3.48])
    """
    inside = check_mask(mask)
    place = depth.registration_to(inside)
    readings = depth.known_mm
    coverage = place.coverage(inside, readings.shape)
    check_holes(readings, coverage, np.count_nonzero(inside) / place.scale**2)
    kept = accepted(readings, coverage, cleaning)
    trend = _Quadratic.fitted(readings, kept)
    residual = fill(np.where(kept, readings - trend.on_grid(readings.shape), np.nan), coverage > 0)
    smooth = smoothed(residual, cleaning.smoothing)
    rows, columns = place.sensor_positions(inside.shape)
    aligned = resampled(smooth, inside, place) + trend(rows[:, None], columns)
    return _shape_of(aligned, inside, depth.focal_length)


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


def resampled(values: Map, mask: Mask, place: Registration) -> Map:
    """Return values of a sensor's grid at the pixels of a picture, by cubic splines.

    Parameters
    ----------
    values : (r, c) array
        NaN where unknown; there, the nearest known value is taken.
    mask : (h, w) bool array
    place : Registration

    Returns
    -------
    (h, w) array
        NaN outside the mask.
    """
    if place.is_identity:
        return values
    window = ndimage.find_objects(np.isfinite(values).astype(np.int8))[0]
    cut = np.pad(values[window], REACH, constant_values=np.nan)
    nearest = ndimage.distance_transform_edt(
        np.isnan(cut), return_distances=False, return_indices=True
    )
    down, across = (
        np.arange(size) - REACH + part.start for size, part in zip(cut.shape, window, strict=True)
    )
    spline = RectBivariateSpline(down, across, cut[tuple(nearest)])
    found: Map = np.where(mask, spline(*place.sensor_positions(mask.shape)), np.nan)
    return found


@dataclass(frozen=True, eq=False)
class _Quadratic:
    """A quadratic in the row and the column, its coordinates scaled to about one."""

    coefficients: Float
    centre: Float
    size: float

    @classmethod
    def fitted(cls, values: Map, known: Mask) -> _Quadratic:
        places = np.argwhere(known)
        centre: Float = places.mean(axis=0, dtype=np.float64)
        size = max(float(np.abs(places - centre).max()), 1.0)
        terms = _terms(*((places - centre) / size).T)
        coefficients = np.asarray(
            np.linalg.lstsq(terms.T, values[known], rcond=1e-9)[0], np.float64
        )
        return cls(coefficients, centre, size)

    def __call__(self, rows: Float, columns: Float) -> Float:
        y, x = (rows - self.centre[0]) / self.size, (columns - self.centre[1]) / self.size
        value: Float = np.tensordot(self.coefficients, _terms(y, x), 1)
        return value

    def on_grid(self, shape: tuple[int, ...]) -> Map:
        return self(np.arange(float(shape[0]))[:, None], np.arange(float(shape[1])))


def _terms(y: Float, x: Float) -> Float:
    return np.stack(np.broadcast_arrays(np.ones_like(y * x), y, x, y * y, y * x, x * x))


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


def _shape_of(depth: Map, mask: Mask, focal_length: float) -> CoarseShape:
    """Return heights in pixels of the picture: the one distance makes the view a parallel one."""
    median = float(np.median(depth[mask]))
    height = np.where(mask, (median - depth) * (focal_length / median), np.nan)
    return CoarseShape(height, normals_inside_outline(height))
