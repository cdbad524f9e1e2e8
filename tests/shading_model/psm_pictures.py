"""The spheres of the measured set psm-uw, read for tests of light probes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from datasets.image_files import read_mask
from datasets.probe_files import read_probe_picture
from shading_model.arrays import Float, Image, Mask


def psm_uw(data_root: Path) -> Path:
    """Return the folder of the set; skips where the data root has others only."""
    folder = data_root / "psm-uw"
    if not folder.is_dir():
        pytest.skip(f"{data_root} holds no psm-uw/")
    return folder


def light_directions(folder: Path) -> Float:
    """Return the directions of lights.txt as they stand there."""
    return np.loadtxt(folder / "lights.txt", skiprows=1)


def mask_of(folder: Path, name: str) -> Mask:
    """Return the mask of a sphere."""
    return read_mask(folder / name / f"{name}.mask.png")


def picture_of(folder: Path, name: str, index: int) -> Image:
    """Return a picture of a sphere, whose eight-bit values are linear."""
    return read_probe_picture(folder / name / f"{name}.{index}.png", linear=True).image
