"""A dataset of one's own, as a user would lay it out."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from shading_model.arrays import Float
from shading_model.height_field import normals_of_slopes, slopes
from shading_model.illumination import LogHarmonics
from tests.example_objects import disk, write_picture

LIGHT = LogHarmonics(np.array([-0.9, 0.3, 0.1, 0.4, 0, 0, 0, 0, 0]))
SIDE = 40


def sixteen_bit(linear: Float) -> np.ndarray:
    """Return linear values as 16-bit levels."""
    return np.round(65535 * np.clip(np.nan_to_num(linear), 0, 1)).astype(np.uint16)


def write_object(folder: Path, *, lit: int = 2) -> Path:
    """Write a painted ball with all that is known of it."""
    folder.mkdir(parents=True)
    mask = disk(SIDE)
    rows, columns = np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2
    height = np.sqrt(np.maximum(18.0**2 - rows**2 - columns**2, 0))
    normals = normals_of_slopes(*slopes(height))
    albedo = np.where((rows > 0)[..., None], [0.8, 0.5, 0.3], [0.2, 0.3, 0.6])
    write_picture(folder / "mask.png", np.uint8(255) * mask.astype(np.uint8))
    write_picture(folder / "albedo.png", sixteen_bit(albedo))
    np.save(folder / "depth.npy", height)
    lights = {f"lit_{k:02d}": 0.5 * k * LIGHT.coefficients for k in range(1, lit + 1)}
    for name, coefficients in {"photograph": LIGHT.coefficients, **lights}.items():
        shading = LogHarmonics(coefficients - 1).shade(normals)
        write_picture(folder / f"{name}.png", sixteen_bit(albedo * shading[..., None]))
    listed = {name: values.tolist() for name, values in lights.items()}
    document = {"convention": "log", "lights": listed}
    (folder / "lights.json").write_text(json.dumps(document), encoding="utf-8")
    return folder
