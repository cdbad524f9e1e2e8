"""The base shape of a depth sensor: its readings cleaned, filled, smoothed and set on the picture.

What a user of such a sensor does before relighting: throw away readings that mix object and
background, fill what is missing, smooth the noise, and bring the sensor's few pixels to those of
the photograph. A sensor's view is taken for a parallel one at the object's median distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.interpolate import RectBivariateSpline

from shading_model.arrays import Float, Map, Mask, check_mask
from shading_model.depth_cleaning import USUAL, Cleaning, accepted, check_holes, fill, smoothed
from shading_model.depth_map import DepthMap, Registration
from shading_model.height_field import normals_inside_outline
from shading_model.object_model import CoarseShape

MARGIN = 2
"""Sensor pixels beyond the object that the spline reaches for at its outline."""


def shape_from_depth(depth: DepthMap, mask: Mask, cleaning: Cleaning = USUAL) -> CoarseShape:
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
    cut = np.pad(values[window], MARGIN, constant_values=np.nan)
    nearest = ndimage.distance_transform_edt(
        np.isnan(cut), return_distances=False, return_indices=True
    )
    down, across = (
        np.arange(size) - MARGIN + part.start for size, part in zip(cut.shape, window, strict=True)
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


def _shape_of(depth: Map, mask: Mask, focal_length: float) -> CoarseShape:
    """Return heights in pixels of the picture: the one distance makes the view a parallel one."""
    median = float(np.median(depth[mask]))
    height = np.where(mask, (median - depth) * (focal_length / median), np.nan)
    return CoarseShape(height, normals_inside_outline(height))
