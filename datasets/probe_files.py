"""Pictures of light probes, read for measurement: linear, and known where they saturate."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from datasets.image_files import FilePath, linearised, read_picture
from datasets.openexr_files import read_openexr
from shading_model.arrays import Image
from shading_model.diffuse_probe import SATURATED


@dataclass(frozen=True, eq=False)
class ProbePicture:
    """A picture of a light probe.

    Parameters
    ----------
    image : (h, w, 3) array
        Linear.
    saturated : float
        Values from here on are saturated; infinite for a file whose values have no limit.
    """

    image: Image
    saturated: float


def read_probe_picture(path: FilePath, *, linear: bool = False) -> ProbePicture:
    """Return a picture of a light probe.

    Parameters
    ----------
    path : path
        An 8-bit, 16-bit or ``.exr`` picture; 16 bits and ``.exr`` are linear.
    linear : bool
        Take eight-bit values for linear, not sRGB. Sets for measurement often store them so.

    Returns
    -------
    ProbePicture

    Raises
    ------
    RelightlabError
        If the file is missing, damaged, or not such a picture.
    """
    if Path(path).suffix.lower() == ".exr":
        return ProbePicture(read_openexr(path), np.inf)
    colour = read_picture(path).colour
    if not linear:
        return ProbePicture(linearised(colour), SATURATED)
    stored = colour / np.float64(np.iinfo(colour.dtype).max)
    rgb = stored if stored.ndim == 3 else np.repeat(stored[..., None], 3, axis=-1)
    return ProbePicture(rgb, SATURATED)
