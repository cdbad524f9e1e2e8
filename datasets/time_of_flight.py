"""A simulated time-of-flight depth sensor, of the kind of the second Kinect.

Simulated: no reading here was measured. The sensor sees a known height field in front of a wall,
with few pixels, each of which averages object and wall where the outline cuts it; the less light
comes back, the noisier it reads, and hollows and dark places read too far.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from datasets.interreflection import path_offset
from shading_model.arrays import Float, Map, Mask, check_map, check_mask
from shading_model.depth_map import DepthMap, Registration
from shading_model.errors import RelightlabError
from shading_model.height_field import normals_inside_outline

LEAST_REFLECTANCE = 1e-3
"""Of the object's mean: black returns next to nothing, but not nothing."""


@dataclass(frozen=True)
class TimeOfFlightSensor:
    """A time-of-flight sensor, the object before it, and the wall behind.

    "Assumed" marks what no published figure was found for. Light is counted in units of what a
    surface of the object's mean albedo returns from a distance of one metre when seen head-on.

    Parameters
    ----------
    rows, columns : int
        424 x 512 pixels [1]_ [2]_.
    focal_length : float, optional
        Pixels. 365.5, the factory's calibration of one sensor that is often copied [3]_; the field
        of view of 70.6 degrees [1]_ means 361.6. None: the grid of the picture, pixel for pixel.
    object_mm : float
        Longer side of the object's bounding box. Assumed.
    distance_mm : float
        Of the object's median height. Assumed: an object on a table, within reach [2]_.
    wall_mm : float
        Distance of the wall behind. Assumed.
    wall_light : float
        Albedo of the wall over the object's mean. Assumed.
    reflectance : float
        The object's mean albedo; scales what hollows add. Assumed.
    noise_mm : float
        Deviation of a reading at one unit of light; it is inversely proportional to the light, so
        it grows with the squared distance, with dark albedo and with slant. From 1.5 mm to tens of
        millimetres were measured [2]_, growing with distance and slant [4]_; that the least belongs
        to the unit is assumed.
    blur : float
        Deviation of the lens's blur in sensor pixels. Assumed.
    interreflection : float
        Of the light that hollows add after one more reflection, the share that counts; 1 is a
        Lambertian surface. Hollows are measured distorted [2]_ and too far [5]_.
    dark_mm : float
        How much farther a surface reads that returns no light; in proportion less up to one unit.
        Offsets that depend on the material are small [2]_, and correlate with reflectivity [6]_;
        the size and the sign are assumed.
    least_light : float
        Units of light below which there is no reading. Assumed.
    steepest_degrees : float
        Angle of incidence beyond which there is no reading. Assumed.
    step_mm : float
        Readings are multiples of this: whole millimetres, as the driver gives them [1]_; 0 is none.
    nearest_mm, farthest_mm : float
        Range outside which there is no reading: 0.5 to 4.5 m [2]_ [3]_.

    Notes
    -----
    Not simulated: perspective within the object, lens distortion, the wiggling error and the drift
    with temperature [2]_, ambient light [4]_, and what the driver itself filters [3]_.

    References
    ----------
    .. [1] Microsoft, specification of Kinect for Windows v2.
    .. [2] Corti, Giancola, Mainetti and Sala, A metrological characterization of the Kinect V2
       time-of-flight camera, Robotics and Autonomous Systems 75 (2016).
    .. [3] libfreenect2, the open driver, and calibrations published with it.
    .. [4] Fankhauser et al., Kinect v2 for mobile robot navigation: evaluation and modeling (2015).
       Only its abstract was at hand: its noise models depend on distance, slant and sunlight.
    .. [5] Nuvoton, manual of a time-of-flight kit, section on multipath interference.
    .. [6] A post-rectification approach of depth images of Kinect v2 for 3D reconstruction of
       indoor scenes, ISPRS International Journal of Geo-Information 6 (2017) 349.

    Examples
    --------
    >>> KINECT_II.noise_mm, IDEAL.noise_mm
    (1.5, 0.0)
    """

    rows: int = 424
    columns: int = 512
    focal_length: float | None = 365.456
    object_mm: float = 200.0
    distance_mm: float = 1000.0
    wall_mm: float = 1500.0
    wall_light: float = 1.0
    reflectance: float = 0.5
    noise_mm: float = 1.5
    blur: float = 0.5
    interreflection: float = 1.0
    dark_mm: float = 3.0
    least_light: float = 0.05
    steepest_degrees: float = 80.0
    step_mm: float = 1.0
    nearest_mm: float = 500.0
    farthest_mm: float = 4500.0


KINECT_II = TimeOfFlightSensor()
"""The second Kinect one metre before an object of 20 cm, as far as published figures go."""
IDEAL = replace(
    KINECT_II,
    focal_length=None,
    noise_mm=0.0,
    blur=0.0,
    interreflection=0.0,
    dark_mm=0.0,
    least_light=0.0,
    steepest_degrees=90.0,
    step_mm=0.0,
    nearest_mm=0.0,
    farthest_mm=np.inf,
)
"""Returns the truth, on the pixels of the picture."""


@dataclass(frozen=True, eq=False)
class _Scene:
    """What there is to see: millimetres and albedo over its mean, on the pixels of the picture."""

    mask: Mask
    depth: Map
    albedo: Map
    facing: Map
    pixel_mm: float


@dataclass(frozen=True, eq=False)
class _View:
    """What falls on the sensor's pixels: light, its mean depth, and the object's mean cosine."""

    light: Map
    depth: Map
    facing: Map


def simulate_time_of_flight(
    height: Map,
    mask: Mask,
    albedo: Float,
    generator: np.random.Generator,
    sensor: TimeOfFlightSensor = KINECT_II,
) -> DepthMap:
    """Return what a simulated time-of-flight sensor reads of a known shape.

    Parameters
    ----------
    height : (h, w) array
        Pixels, larger is nearer; pixels of the mask where it is NaN return no light.
    mask : (h, w) bool array
    albedo : (h, w) or (h, w, 3) array
        Up to scale; infrared is taken for the mean of the colours.
    generator : numpy.random.Generator
    sensor : TimeOfFlightSensor

    Returns
    -------
    DepthMap
        Millimetres on the sensor's grid, the object in its middle and the wall around it; 0 where
        there is no reading.

    Raises
    ------
    RelightlabError
        If sizes differ, no height is known, the albedo is negative, unknown or black, or the object
        does not fit into the sensor's view.

    Examples
    --------
    >>> rows, columns = np.mgrid[-9:10, -9:10]
    >>> inside = np.hypot(rows, columns) < 9
    >>> reading = simulate_time_of_flight(np.zeros((19, 19)), inside, np.ones((19, 19)),
    ...                                   np.random.default_rng(0))
    >>> reading.depth.shape, reading.depth[0, 0].round(-2), reading.depth[212, 256].round(-1)
    ((424, 512), np.float64(1500.0), np.float64(1000.0))
    """
    scene = _scene(height, mask, albedo, sensor)
    place, shape = _placement(scene, sensor)
    view = _view(scene, place, shape, sensor)
    depth = view.depth + sensor.dark_mm * np.maximum(1 - view.light, 0)
    if sensor.noise_mm > 0:
        depth += generator.standard_normal(shape) * deviation_mm(view.light, sensor)
    if sensor.step_mm > 0:
        depth = np.round(depth / sensor.step_mm) * sensor.step_mm
    lost = (view.light <= sensor.least_light) | ~(
        view.facing >= np.cos(np.radians(sensor.steepest_degrees))
    )
    lost |= (depth < sensor.nearest_mm) | (depth > sensor.farthest_mm)
    depth[lost] = 0.0
    return DepthMap(depth, sensor.distance_mm / scene.pixel_mm, place)


def deviation_mm(light: Map, sensor: TimeOfFlightSensor) -> Map:
    """Return the standard deviation of readings of so much light.

    Parameters
    ----------
    light : (r, c) array
        In units of what the object's mean albedo returns from one metre, head-on.
    sensor : TimeOfFlightSensor

    Returns
    -------
    (r, c) array
        Millimetres. Below the least light that is read, that of the least.

    Examples
    --------
    >>> deviation_mm(np.array([1.0, 0.25]), KINECT_II)
    array([1.5, 6. ])
    """
    deviation: Map = sensor.noise_mm / np.maximum(light, max(sensor.least_light, LEAST_REFLECTANCE))
    return deviation


def _scene(height: Map, mask: Mask, albedo: Float, sensor: TimeOfFlightSensor) -> _Scene:
    inside = check_mask(mask)
    known = check_map(height, inside, "heights")
    if not np.isfinite(known).any():
        raise RelightlabError("no height of the object is known: there is nothing to simulate")
    rows, columns = ndimage.find_objects(inside.astype(np.int8))[0]
    pixel_mm = sensor.object_mm / max(rows.stop - rows.start, columns.stop - columns.start)
    depth = sensor.distance_mm - (known - np.nanmedian(known)) * pixel_mm
    facing = normals_inside_outline(known)[..., 2]
    return _Scene(inside, depth, _relative_albedo(albedo, inside), facing, pixel_mm)


def _relative_albedo(albedo: Float, mask: Mask) -> Map:
    gray = np.mean(albedo, axis=-1) if np.ndim(albedo) == 3 else np.asarray(albedo)
    checked = check_map(gray, mask, "albedos")
    values = checked[mask]
    if not (np.isfinite(values).all() and (values >= 0).all() and values.any()):
        raise RelightlabError(
            "expected an albedo that is known, not negative and not black all over the mask"
        )
    relative: Map = np.maximum(checked / values.mean(), LEAST_REFLECTANCE)
    return relative


def _placement(scene: _Scene, sensor: TimeOfFlightSensor) -> tuple[Registration, tuple[int, int]]:
    """Return where the sensor's pixels lie and how many they are: the object in the middle."""
    if sensor.focal_length is None:
        return Registration(), (scene.mask.shape[0], scene.mask.shape[1])
    scale = sensor.distance_mm / (sensor.focal_length * scene.pixel_mm)
    spans = ndimage.find_objects(scene.mask.astype(np.int8))[0]
    firsts = []
    for span, count in zip(spans, (sensor.rows, sensor.columns), strict=True):
        if span.stop - span.start > scale * count:
            raise RelightlabError(
                f"an object of {sensor.object_mm:g} mm at {sensor.distance_mm:g} mm does not fit"
                f" into a view of {sensor.columns}x{sensor.rows} pixels: put it farther away"
            )
        firsts.append((span.start + span.stop - 1) / 2 - scale * (count - 1) / 2)
    return Registration(scale, *firsts), (sensor.rows, sensor.columns)


def _view(
    scene: _Scene, place: Registration, shape: tuple[int, int], sensor: TimeOfFlightSensor
) -> _View:
    known = np.isfinite(scene.depth)
    share = place.average(known.astype(np.float64), shape)
    facing = place.average(np.where(known, scene.facing, 0.0), shape)
    depth = np.where(known, scene.depth, 1.0)
    light = np.where(known, scene.albedo * scene.facing * (1000.0 / depth) ** 2, 0.0)
    if sensor.interreflection > 0:
        reflectance = np.clip(scene.albedo * sensor.reflectance, 0.0, 1.0)
        offset = path_offset(depth, reflectance, known, scene.pixel_mm)
        depth = depth + sensor.interreflection * np.where(known, offset, 0.0)
    wall = 1 - place.coverage(scene.mask, shape)
    wall_light = wall * sensor.wall_light * (1000.0 / sensor.wall_mm) ** 2
    total = place.average(light, shape) + wall_light
    weighted = place.average(light * depth, shape) + wall_light * sensor.wall_mm
    if sensor.blur > 0:
        total, weighted = (ndimage.gaussian_filter(x, sensor.blur) for x in (total, weighted))
    mean = np.divide(weighted, total, out=np.zeros(shape), where=total > 0)
    # The wall is seen head-on.
    mean_facing = np.divide(facing, share, out=np.ones(shape), where=share > 0)
    return _View(total, mean, mean_facing)
