"""A miniature of the MIT-Berkeley layout, made from arrays, for tests without the set."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from scipy.io import savemat
from scipy.ndimage import correlate

from shading_model.arrays import Float, Mask
from tests.datasets.test_mit_axes import mit_harmonics

SHAPE = (40, 52)
CROP = (slice(5, 36), slice(8, 49))


@dataclass(frozen=True)
class Miniature:
    """What the files of one object were made from, full size, in the files' own axes."""

    root: Path
    name: str
    depth: Float
    mask: Mask
    reflectance: Float
    natural_light: Float
    laboratory_lights: tuple[Float, ...]
    natural_shading: Float
    corrected_shading: Float


def mit_normals(depth: Float) -> Float:
    """The set's normals (row down, column right, to the viewer), as its format describes them."""
    sobel = np.array([[-1.0, -2, -1], [0, 0, 0], [1, 2, 1]]) / 8
    known = ~np.isnan(depth)
    filled = np.where(known, depth, 0.0)
    down, right = (correlate(filled, kernel, mode="nearest") for kernel in (sobel, sobel.T))
    around = correlate((~known).astype(float), np.ones((3, 3)), mode="nearest") > 0
    normals = np.stack([-down, -right, np.ones_like(down)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    normals[around] = np.nan
    return normals


def write_miniature(root: Path, name: str = "apple") -> Miniature:
    """Write one object's files in both settings and return what they hold."""
    generator = np.random.default_rng(5)
    rows, columns = np.indices(SHAPE)
    down, right = (rows - 20) / 14, (columns - 28) / 19
    mask = down**2 + right**2 < 1
    valid = (down**2 + right**2 < 0.9) & ~((np.abs(down) < 0.1) & (np.abs(right + 0.5) < 0.1))
    depth = np.where(
        valid, 8 * np.sqrt(np.maximum(1 - down**2 - right**2, 0)) + 1.5 * right, np.nan
    )
    reflectance = np.where(
        mask[..., None], np.where((right > 0)[..., None], [0.7, 0.3, 0.2], [0.3, 0.5, 0.6]), 0
    )
    light = generator.normal(size=(9, 3)) * 0.15 - np.eye(9)[0][:, None]
    normals = mit_normals(depth)
    shading = np.exp(mit_harmonics(normals.reshape(-1, 3)) @ light).reshape(*SHAPE, 3)
    shading = np.where(valid[..., None], np.where(np.isnan(shading), 0.4, shading), 0)
    corrected = np.where(mask[..., None], 0.3 + 0.5 * np.maximum(1 - down - right, 0)[..., None], 0)
    corrected = corrected * [1.0, 0.9, 0.8]
    lamps = tuple(generator.normal(size=(9, 3)) * 0.2 for _ in range(11))
    made = Miniature(root, name, depth, mask, reflectance, light, lamps, shading, corrected)
    _write_laboratory(made)
    _write_natural(made)
    return made


def _write_laboratory(made: Miniature) -> None:
    folder = made.root / "MIT-Berkeley-Laboratory" / made.name
    folder.mkdir(parents=True)
    image = made.reflectance * made.corrected_shading
    write_png(folder / "diffuse.png", image)
    write_png(folder / "reflectance.png", made.reflectance)
    write_png(folder / "mask.png", np.where(made.mask, 65025, 0) / 65535)
    for k in range(1, 11):
        write_png(folder / f"light{k:02d}.png", image * k / 11)
    cells = np.empty((1, 10), dtype=object)
    cells[0] = [*made.laboratory_lights[:10]]
    lights: dict[str, Any] = {"light": cells, "diffuse": made.laboratory_lights[10]}
    savemat(folder / "L.mat", {"color_lights": lights})
    savemat(folder / "Z.mat", {"depth": made.depth})
    savemat(
        folder / "crop_idx.mat",
        {
            "crop_idx1": np.arange(CROP[0].start + 1, CROP[0].stop + 1, dtype=np.uint8)[None],
            "crop_idx2": np.arange(CROP[1].start + 1, CROP[1].stop + 1, dtype=np.uint8)[None],
        },
    )
    savemat(folder / "shading_corrected_color.mat", {"shading_correct": made.corrected_shading})


def _write_natural(made: Miniature) -> None:
    folder = made.root / "MIT-Berkeley-Natural" / made.name
    folder.mkdir(parents=True)
    write_png(folder / "diffuse.png", made.reflectance * made.natural_shading)
    write_png(folder / "shading_color.png", made.natural_shading)
    savemat(folder / "L.mat", {"L": made.natural_light})


def write_png(path: Path, values: Float) -> None:
    """Write values in [0, 1] as a linear sixteen-bit PNG, gray or colour."""
    encoded = np.round(np.clip(values, 0, 1) * 65535).astype(np.uint16)
    cv2.imwrite(str(path), encoded[..., ::-1] if encoded.ndim == 3 else encoded)
