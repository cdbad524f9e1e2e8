"""Depth as a sensor gives it: millimetres on a grid of its own, and where that grid lies."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from shading_model.arrays import Float, Map, Mask
from shading_model.errors import RelightlabError

NEAREST_MM = 200.0
FARTHEST_MM = 10_000.0
"""Depths outside these are taken for depths in another unit."""


@dataclass(frozen=True)
class Registration:
    """Where the pixels of a sensor lie in a picture; both grids are upright and square.

    Parameters
    ----------
    scale : float
        Pixels of the picture per pixel of the sensor.
    row, column : float
        Position in the picture of the centre of the sensor's pixel (0, 0); centres of pixels have
        whole numbers.

    Examples
    --------
    >>> Registration(2.0, 0.5, 0.5).coverage(np.array([[1, 1, 0, 0]] * 2, bool), (1, 2))
    array([[1., 0.]])
    """

    scale: float = 1.0
    row: float = 0.0
    column: float = 0.0

    @property
    def is_identity(self) -> bool:
        """Return whether both grids are one."""
        return self == Registration()

    def coverage(self, mask: Mask, shape: tuple[int, int]) -> Map:
        """Return the share of each sensor pixel that a mask of the picture covers."""
        return self.average(mask.astype(np.float64), shape)

    def average(self, picture: Map, shape: tuple[int, int]) -> Map:
        """Return the mean of a picture over each of the sensor's (r, c) pixels.

        Pixels are squares without gaps; beyond the picture there are zeros.
        """
        if self.is_identity and picture.shape == shape:
            return picture
        rows = _overlaps(self.scale, self.row, shape[0], picture.shape[0])
        columns = _overlaps(self.scale, self.column, shape[1], picture.shape[1])
        averaged: Map = (columns @ (rows @ picture).T).T / self.scale**2
        return averaged

    def sensor_positions(self, shape: tuple[int, int]) -> tuple[Float, Float]:
        """Return the rows (h,) and the columns (w,) of a picture in pixels of the sensor."""
        rows: Float = (np.arange(float(shape[0])) - self.row) / self.scale
        columns: Float = (np.arange(float(shape[1])) - self.column) / self.scale
        return rows, columns


@dataclass(frozen=True, eq=False)
class DepthMap:
    """Depth measured by a sensor that looks the same way as the camera of a picture.

    Parameters
    ----------
    depth : (r, c) or (k, r, c) array
        Millimetres on the sensor's grid, larger is farther; 0 or NaN is no reading. Several
        frames of the same scene are a stack.
    focal_length : float
        Of the picture's camera in pixels of the picture: a pixel at the distance d is
        ``d / focal_length`` wide.
    registration : Registration, optional
        By default sensor and picture show the same window, each in its own resolution.

    Raises
    ------
    RelightlabError
        If the depth is not two- or three-dimensional, negative, infinite or empty, or if its
        median is not a depth in millimetres; or if the focal length is not positive.

    Examples
    --------
    >>> DepthMap(np.array([[0.0, 546.0]]), focal_length=1216.73).median_mm
    546.0
    >>> DepthMap(np.full((2, 2), 0.546), focal_length=1216.73)
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: expected depth in millimetres, between 200 and 10000, ...
    """

    depth: Float
    focal_length: float
    registration: Registration | None = None

    def __post_init__(self) -> None:
        depth = np.asarray(self.depth, dtype=np.float64)
        object.__setattr__(self, "depth", depth)
        _check_readings(depth)
        _check_unit(float(np.median(depth[depth > 0])))
        if not (np.isfinite(self.focal_length) and self.focal_length > 0):
            raise RelightlabError(
                f"expected a focal length in pixels, above zero, got {self.focal_length:g}"
            )

    @cached_property
    def known_mm(self) -> Map:
        """The median over the frames, (r, c); NaN where no frame has a reading."""
        readings = np.where(self.depth > 0, self.depth, np.nan)
        return readings if readings.ndim == 2 else median_of_known(readings)

    @property
    def median_mm(self) -> float:
        """Median of all readings."""
        return float(np.median(self.depth[self.depth > 0]))

    def registration_to(self, mask: Mask) -> Registration:
        """Return the registration to the picture of a mask.

        Raises
        ------
        RelightlabError
            If there is none and the sizes do not belong to one window.
        """
        return self.registration or same_window(self.known_mm.shape, mask.shape)


def same_window(sensor: tuple[int, ...], picture: tuple[int, ...]) -> Registration:
    """Return the registration of two grids that show the same window.

    Parameters
    ----------
    sensor, picture : (rows, columns)
        One may be a whole number of times finer, less the pixels that halving an odd size loses.

    Returns
    -------
    Registration

    Raises
    ------
    RelightlabError
        If there is no such number.

    Examples
    --------
    >>> same_window((320, 241), (640, 482))
    Registration(scale=2.0, row=0.5, column=0.5)
    >>> same_window((5, 9), (2, 4))
    Registration(scale=0.5, row=-0.25, column=-0.25)
    """
    if _is_multiple(picture, sensor):
        scale = float(round(picture[0] / sensor[0]))
    elif _is_multiple(sensor, picture):
        scale = 1 / round(sensor[0] / picture[0])
    else:
        raise RelightlabError(
            f"the depth map is {sensor[1]}x{sensor[0]} pixels and the mask"
            f" {picture[1]}x{picture[0]}, which is not one window in two resolutions: cut both to"
            " the same window, or say where the sensor's pixels lie"
        )
    middle = (scale - 1) / 2
    return Registration(scale, middle, middle)


def _is_multiple(fine: tuple[int, ...], coarse: tuple[int, ...]) -> bool:
    """Return whether `fine` is `coarse` times a whole number, but for what rounding took."""
    times = round(fine[0] / coarse[0])
    return all(abs(a - times * b) < max(times, 1) for a, b in zip(fine, coarse, strict=True))


def median_of_known(values: Float) -> Float:
    """Return the median over the first axis of what is not NaN; NaN where all is.

    Parameters
    ----------
    values : (k, ...) array

    Returns
    -------
    (...) array

    Examples
    --------
    >>> median_of_known(np.array([[1.0, np.nan], [np.nan, np.nan], [4.0, np.nan]]))
    array([2.5, nan])
    """
    # NaNs are sorted behind all numbers; NumPy's own nanmedian is ten times slower on short axes.
    ordered = np.sort(values, axis=0)
    count = np.isfinite(values).sum(axis=0)
    middle = [np.maximum(count - 1, 0) // 2, count // 2]
    low, high = (
        np.take_along_axis(ordered, np.minimum(place, len(values) - 1)[None], axis=0)[0]
        for place in middle
    )
    median: Float = np.where(count > 0, (low + high) / 2, np.nan)
    return median


def _overlaps(scale: float, origin: float, sensor: int, picture: int) -> sparse.csr_array:
    """Return how much of each picture pixel lies in each sensor pixel, along one axis."""
    centres = origin + scale * np.arange(sensor)[:, None]
    pixels = np.arange(picture)
    ends = np.minimum(centres + scale / 2, pixels + 0.5)
    starts = np.maximum(centres - scale / 2, pixels - 0.5)
    return sparse.csr_array(np.maximum(ends - starts, 0.0))


def _check_readings(depth: Float) -> None:
    if depth.ndim not in {2, 3}:
        raise RelightlabError(
            f"expected depth of shape (r, c), or (k, r, c) for k frames, got {depth.shape}"
        )
    if (depth < 0).any() or np.isinf(depth).any():
        raise RelightlabError("the depth map has negative or infinite values: 0 means no reading")
    if not (depth > 0).any():
        raise RelightlabError("the depth map has no reading at all: every pixel is 0 or NaN")


def _check_unit(median: float) -> None:
    if NEAREST_MM <= median <= FARTHEST_MM:
        return
    hint = ": give it in millimetres"
    for unit, factor in {"metres": 1000, "centimetres": 10}.items():
        if NEAREST_MM <= median * factor <= FARTHEST_MM:
            hint = f", as if it were in {unit}: multiply by {factor}"
            break
    raise RelightlabError(
        f"expected depth in millimetres, between {NEAREST_MM:.0f} and {FARTHEST_MM:.0f}, but the"
        f" median of the readings is {median:.4g}{hint}"
    )
