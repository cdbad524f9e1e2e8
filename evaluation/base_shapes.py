"""The base shapes of Table 2 (`subsec:shapestudy`), by name.

Each is made of what its owner would have: the outline, a depth sensor, one photograph or several.
`ground-truth` and `flat` are bounds, not rivals.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from scipy.ndimage import distance_transform_edt

from datasets.records import Capture, Dataset
from datasets.time_of_flight import KINECT_II, TimeOfFlightSensor, simulate_time_of_flight
from evaluation.sirfs.fit import FitOptions
from evaluation.sirfs_fits import UNKEPT, SirfsFits
from shading_model.arrays import Float, Image, Map, Mask, Normals
from shading_model.errors import RelightlabError
from shading_model.object_model import CoarseShape, ModelParameters, contour_base
from shading_model.seeds import generator_for
from shading_model.sensor_shape import shape_from_depth

STUDY_EVALUATIONS = (300, 200, 60)
"""Of SIRFS, at quarter, half and full resolution: a fifth of the time of the fits of Table 1.
Measured on four objects, losses end 0.5 to 5 % higher and mean angles of normals within 0.3 degrees
(2.4 degrees better on the fourth)."""


@runtime_checkable
class HasSensor(Protocol):
    """A dataset that comes with the shape of a real depth sensor."""

    def sensor_shape(self, name: str) -> CoarseShape:
        """Return the sensor's shape of an object, on the pixels of its photograph."""
        ...


@dataclass(frozen=True, eq=False)
class ShapeRequest:
    """What a base shape may be made of.

    Parameters
    ----------
    dataset : Dataset
    capture : Capture
        Of the object, in the setting of its photographs under other lights; a shape that is not
        `ground-truth` or `kinect` makes no use of its truth.
    image : (h, w, 3) array
        The photograph that the model is built from.
    photographs : tuple of (h, w, 3) arrays
        Photographs of the object under other lights that may be used.
    parameters : ModelParameters
    fits : SirfsFits
        Where fits of SIRFS are kept.
    sensor : TimeOfFlightSensor
        What is simulated where the dataset has no depth sensor of its own.
    """

    dataset: Dataset
    capture: Capture
    image: Image
    photographs: tuple[Image, ...]
    parameters: ModelParameters
    fits: SirfsFits = UNKEPT
    sensor: TimeOfFlightSensor = KINECT_II

    @property
    def mask(self) -> Mask:
        """The object, (h, w)."""
        return self.capture.photograph.mask


def contour(request: ShapeRequest) -> CoarseShape:
    """Return the paper's base shape, made of the outline alone.

    Parameters
    ----------
    request : ShapeRequest

    Returns
    -------
    CoarseShape
    """
    return contour_base(request.mask, request.parameters)


def flat(request: ShapeRequest) -> CoarseShape:
    """Return the plane that faces the viewer: what a cut-out would be.

    Parameters
    ----------
    request : ShapeRequest

    Returns
    -------
    CoarseShape
    """
    facing = np.where(request.mask[..., None], [0.0, 0.0, 1.0], np.nan)
    return CoarseShape(np.where(request.mask, 0.0, np.nan), facing)


def ground_truth(request: ShapeRequest) -> CoarseShape:
    """Return the true shape; where it is not known, the height and normal of the nearest pixel.

    Parameters
    ----------
    request : ShapeRequest

    Returns
    -------
    CoarseShape

    Raises
    ------
    RelightlabError
        If the true shape is not known.
    """
    height, normals = _true_shape(request)
    return filled_shape(height, normals, request.mask)


def kinect(request: ShapeRequest) -> CoarseShape:
    """Return the shape of a depth sensor: the dataset's own, else a simulated time-of-flight one.

    Parameters
    ----------
    request : ShapeRequest

    Returns
    -------
    CoarseShape

    Raises
    ------
    RelightlabError
        If the set has no sensor and the true shape, which a simulation needs, is not known.
    """
    name = request.capture.photograph.name
    if isinstance(request.dataset, HasSensor):
        return request.dataset.sensor_shape(name)
    true = ground_truth(request)
    generator = generator_for("time of flight", request.dataset.name, name)
    reading = simulate_time_of_flight(
        true.height, request.mask, _albedo(request), generator, request.sensor
    )
    return shape_from_depth(reading, request.mask)


def sirfs(request: ShapeRequest) -> CoarseShape:
    """Return the shape of SIRFS on the photograph that the model is built from.

    Parameters
    ----------
    request : ShapeRequest

    Returns
    -------
    CoarseShape
    """
    return _shape_of_fit(request, (request.image,))


def sirfs_stereo(request: ShapeRequest) -> CoarseShape:
    """Return the shape that SIRFS finds common to the photographs under other lights.

    Parameters
    ----------
    request : ShapeRequest

    Returns
    -------
    CoarseShape
    """
    return _shape_of_fit(request, request.photographs)


BASE_SHAPES: dict[str, Callable[[ShapeRequest], CoarseShape]] = {
    "contour": contour,
    "kinect": kinect,
    "sirfs": sirfs,
    "sirfs-stereo": sirfs_stereo,
    "ground-truth": ground_truth,
    "flat": flat,
}
"""Every base shape of Table 2; a new one is a line here."""
FITTED_SHAPES = ("sirfs", "sirfs-stereo")
"""Those that take a fit of SIRFS."""
RIVAL_SHAPES = ("contour", "kinect", "sirfs", "sirfs-stereo")
"""Those of the published table."""


def filled_shape(height: Map, normals: Normals, mask: Mask) -> CoarseShape:
    """Return a shape that is known all over the mask, from the nearest pixels where it was not.

    Parameters
    ----------
    height : (h, w) array
        NaN where unknown.
    normals : (h, w, 3) array
        NaN where unknown.
    mask : (h, w) bool array

    Returns
    -------
    CoarseShape

    Raises
    ------
    RelightlabError
        If nothing is known on the mask.

    Examples
    --------
    >>> height = np.array([[1.0, 2.0, np.nan]])
    >>> facing = np.tile([0.0, 0.0, 1.0], (1, 3, 1))
    >>> filled_shape(height, facing, np.ones((1, 3), bool)).height
    array([[1., 2., 2.]])
    """
    return CoarseShape(_filled(height, mask), _filled(normals, mask))


def steepened(shape: CoarseShape, factor: float) -> CoarseShape:
    """Return a shape of `factor` times the height.

    Parameters
    ----------
    shape : CoarseShape
    factor : float
        Above zero.

    Returns
    -------
    CoarseShape

    Examples
    --------
    >>> slope = CoarseShape(np.array([[1.0]]), np.array([[[-0.6, 0.0, 0.8]]]))
    >>> steepened(slope, 0.5).normals.round(3)
    array([[[-0.351,  0.   ,  0.936]]])
    """
    scaled = shape.normals * [factor, factor, 1.0]
    length = np.linalg.norm(scaled, axis=-1, keepdims=True)
    return CoarseShape(shape.height * factor, scaled / length)


def _true_shape(request: ShapeRequest) -> tuple[Map, Normals]:
    truth = request.capture.truth
    if truth.height is None or truth.normals is None:
        raise RelightlabError(
            f"the true shape of {request.capture.photograph.name} in {request.dataset.name} is not"
            " known: leave out the shapes that need it"
        )
    return truth.height, truth.normals


def _albedo(request: ShapeRequest) -> Float:
    """Return what the sensor's light is reflected by: the true albedo where it is known.

    Else the photograph of the object, and not the image that a model is built from: what a sensor
    reads does not depend on which photograph is left out.
    """
    albedo = request.capture.truth.albedo
    return request.capture.photograph.image if albedo is None else albedo


def _shape_of_fit(request: ShapeRequest, images: Sequence[Image]) -> CoarseShape:
    options = FitOptions("laboratory", "color", evaluations=STUDY_EVALUATIONS)
    fit = request.fits.fit_images(images, request.mask, options)
    return filled_shape(fit.height, fit.normals, request.mask)


def _filled(values: Float, mask: Mask) -> Float:
    known = np.isfinite(values) & mask if values.ndim == 2 else np.isfinite(values).all(-1) & mask
    if not known.any():
        raise RelightlabError("the shape is not known anywhere on the mask")
    rows, columns = distance_transform_edt(~known, return_distances=False, return_indices=True)
    inside = mask if values.ndim == 2 else mask[..., None]
    filled: Float = np.where(inside, values[rows, columns], np.nan)
    return filled
