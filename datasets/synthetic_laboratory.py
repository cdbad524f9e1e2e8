"""Laboratory photographs of the procedural objects: path tracing with small lamps.

Cast shadows, penumbrae and interreflection are those of the height field standing before a dark
room. The renderer is Mitsuba's `scalar_rgb` with a fixed block size and the box filter: the same
samples whatever the number of threads.
"""

from __future__ import annotations

from typing import Any

import mitsuba
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shading_model.arrays import Float, Image, Map, Mask

LAMP_DIRECTIONS: tuple[tuple[float, float, float], ...] = (
    (-0.39, -0.13, 0.84),
    (-0.70, 0.10, 0.62),
    (-0.75, 0.28, 0.52),
    (-0.40, 0.56, 0.62),
    (-0.22, -0.46, 0.80),
    (0.26, -0.30, 0.86),
    (0.52, 0.40, 0.66),
    (0.36, 0.66, 0.55),
    (0.03, 0.30, 0.90),
    (0.34, -0.50, 0.72),
    (-0.62, 0.42, 0.66),
    (0.45, 0.05, 0.89),
)
"""Where the lamps stand: ten as in the measured laboratory, then the key and the weak fill."""

PHOTOGRAPHS: tuple[dict[int, float], ...] = (
    {10: 0.92, 11: 0.12},
    *({lamp: 1.0} for lamp in range(10)),
)
"""Lamps and their strengths: first the photograph models are built from, then ten others."""

LAMP_DISTANCE = 6.0
"""Of a lamp from the middle of the picture, in halves of its longer side."""
_LAMP_RADIUS = 0.35
_LONGEST_PATH = 3  # camera, surface, surface, lamp
_STRAY_LIGHT = 0.03  # of a dark room that is never quite dark: no pixel of the object is black
_BLOCK = 32


def render_laboratory(height: Map, albedo: Image, samples: int, seed: int) -> Float:
    """Return the object's photographs under each of `PHOTOGRAPHS`.

    Parameters
    ----------
    height : (h, w) array
        Pixels, NaN off the object.
    albedo : (h, w, 3) array
        Finite on the object.
    samples : int
        Light paths per pixel.
    seed : int
        Of the renderer's sampler.

    Returns
    -------
    (11, h, w, 3) array
        Linear; a white surface that faces a lamp of strength 1 has about 1. Zero off the object.
    """
    mitsuba.set_variant("scalar_rgb")
    mask = np.isfinite(height)
    scene = mitsuba.load_dict(_scene(height, albedo, samples))
    parameters = mitsuba.traverse(scene)
    images = []
    for number, strengths in enumerate(PHOTOGRAPHS):
        _switch(parameters, strengths)
        image = np.array(
            mitsuba.render(scene, seed=mitsuba.UInt32(seed + number)), dtype=np.float64
        )
        images.append(np.where(mask[..., None], image, 0.0))
    return np.stack(images)


def extended(values: Float, mask: Mask) -> Float:
    """Return the map with every pixel off the object given its nearest object pixel's value.

    Examples
    --------
    >>> extended(np.array([[np.nan, 2.0]]), np.array([[False, True]]))
    array([[2., 2.]])
    """
    nearest = ndimage.distance_transform_edt(
        np.logical_not(mask), return_distances=False, return_indices=True
    )
    filled: Float = values[tuple(nearest)]
    return filled


def _switch(parameters: Any, strengths: dict[int, float]) -> None:
    # Dark lamps stay in the scene but are never sampled: the geometry is built only once.
    radiance = (LAMP_DISTANCE / _LAMP_RADIUS) ** 2
    for lamp in range(len(LAMP_DIRECTIONS)):
        strength = strengths.get(lamp, 0.0)
        parameters[f"lamp{lamp}.emitter.radiance.value"] = [radiance * strength] * 3
        parameters[f"lamp{lamp}.emitter.sampling_weight"] = 1.0 if strength else 0.0
    parameters.update()


def _scene(height: Map, albedo: Image, samples: int) -> dict[str, Any]:
    rows, columns = height.shape
    mask = np.isfinite(height)
    reach = 0.5 * max(rows, columns)
    scene: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": _LONGEST_PATH, "block_size": _BLOCK},
        # Never sampled as a lamp: the paths that leave the object find it, at no further cost.
        "room": {
            "type": "constant",
            "radiance": {"type": "rgb", "value": [_STRAY_LIGHT] * 3},
            "sampling_weight": 0.0,
        },
        "sensor": _camera(rows, columns, reach, samples),
        "object": _mesh(height, mask, reach, extended(albedo, mask)),
    }
    for lamp, direction in enumerate(LAMP_DIRECTIONS):
        position = LAMP_DISTANCE * np.array(direction) / np.linalg.norm(direction)
        scene[f"lamp{lamp}"] = _lamp(position)
    return scene


def _lamp(position: Float) -> dict[str, Any]:
    radiance = {"type": "rgb", "value": [1.0, 1.0, 1.0]}
    return {
        "type": "sphere",
        "center": position.tolist(),
        "radius": _LAMP_RADIUS,
        "emitter": {"type": "area", "radiance": radiance},
    }


def _camera(rows: int, columns: int, reach: float, samples: int) -> dict[str, Any]:
    """Return an orthographic camera whose pixels are the height map's."""
    transform = mitsuba.ScalarTransform4f()
    # Mitsuba's orthographic film is two units wide; the picture's half width is columns / 2.
    to_world = transform.look_at(origin=[0, 0, 3.0], target=[0, 0, 0], up=[0, 1, 0])
    half_width = 0.5 * columns / reach
    return {
        "type": "orthographic",
        "to_world": to_world @ transform.scale([half_width, half_width, 1.0]),
        "film": {
            "type": "hdrfilm",
            "width": columns,
            "height": rows,
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
            "component_format": "float32",
        },
        "sampler": {"type": "multijitter", "sample_count": samples},
    }


def _mesh(height: Map, mask: Mask, reach: float, albedo: Image) -> Any:
    """Return the height field as triangles between pixel centres, one pixel beyond the mask."""
    rows, columns = height.shape
    row, column = np.indices(height.shape)
    filled = extended(height, mask)
    depth = (filled - filled.mean()) / reach
    x = (column + 0.5 - 0.5 * columns) / reach
    y = (0.5 * rows - row - 0.5) / reach
    vertices = np.stack([x, y, depth], axis=-1).reshape(-1, 3)
    coordinates = np.stack([(column + 0.5) / columns, (row + 0.5) / rows], axis=-1)
    texture = {
        "type": "bitmap",
        "bitmap": mitsuba.Bitmap(np.ascontiguousarray(albedo, dtype=np.float32)),
        "filter_type": "nearest",
        "raw": True,
    }
    properties = mitsuba.Properties()
    properties["bsdf"] = mitsuba.load_dict({"type": "diffuse", "reflectance": texture})
    faces = _triangles(mask)
    mesh = mitsuba.Mesh(
        "object", len(vertices), len(faces), props=properties, has_vertex_texcoords=True
    )
    arrays = mitsuba.traverse(mesh)
    arrays["vertex_positions"] = vertices.astype(np.float32).ravel()
    arrays["vertex_texcoords"] = coordinates.astype(np.float32).reshape(-1)
    arrays["faces"] = faces.astype(np.uint32).ravel()
    arrays.update()
    return mesh


def _triangles(mask: Mask) -> NDArray[np.intp]:
    """Return vertex numbers of the triangles, anticlockwise as the viewer sees them."""
    grown = ndimage.binary_dilation(mask, np.ones((3, 3), dtype=np.bool_))
    number = np.arange(mask.size).reshape(mask.shape)
    whole = grown[:-1, :-1] & grown[:-1, 1:] & grown[1:, :-1] & grown[1:, 1:]
    top_left, top_right = number[:-1, :-1][whole], number[:-1, 1:][whole]
    low_left, low_right = number[1:, :-1][whole], number[1:, 1:][whole]
    upper = np.stack([top_left, low_left, top_right], axis=-1)
    lower = np.stack([top_right, low_left, low_right], axis=-1)
    return np.concatenate([upper, lower])
