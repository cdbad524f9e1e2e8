"""What a fit by SIRFS yields."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from shading_model.arrays import Float, Map, Mask, Normals
from shading_model.illumination import LogHarmonics


@dataclass(frozen=True, eq=False)
class SirfsFit:
    """Shape, albedo, shading and light of one photograph; all maps are NaN outside the mask.

    ``image = albedo * shading`` exactly, wherever the photograph is above zero.

    Parameters
    ----------
    mask : (h, w) bool array
        Pixels of the object that were explained.
    height : (h, w) array
        Z in pixels, larger is nearer; its offset is arbitrary.
    normals : (h, w, 3) array
        Unit normals (x right, y up, z toward the viewer).
    albedo, shading : (h, w, c) arrays
        Of as many channels c, 1 or 3, as were fitted.
    illumination : LogHarmonics
        Coefficients of shape (9,) or (9, 3).
    final_loss : float
    terms : mapping of str to float
        The weighted terms whose sum the loss is.
    evaluations : int
        Of the loss and its gradient, in full resolutions: one at half resolution is a quarter.
    stopped : str
        Why the fit ended, in words.
    """

    mask: Mask
    height: Map
    normals: Normals
    albedo: Float
    shading: Float
    illumination: LogHarmonics
    final_loss: float
    terms: Mapping[str, float]
    evaluations: float
    stopped: str
