"""What Table 1 measures of SIRFS on one object in one setting: the row of B + M and rows (b).

Both come from one fit in colour to the photograph that our models are built from. Where the fit
leaves pixels of the object unexplained, because the photograph is black there, its albedo is zero.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import distance_transform_edt
from threadpoolctl import threadpool_limits

from datasets.records import Dataset, Photograph
from evaluation.kept_models import KeptModels
from evaluation.model_parts import PAPER_PARTS, ModelParts
from evaluation.object_measurement import build_models
from evaluation.rerendering import RerenderingCell, rerendering_cells
from evaluation.sirfs.result import SirfsFit
from evaluation.sirfs_fits import SirfsFits
from shading_model.arrays import Float, Mask
from shading_model.illumination import LogHarmonics, PointLights
from shading_model.object_model import ModelParameters, ObjectModel, split_by_shading
from shading_model.retinex import IntrinsicImages

RIVAL = "sirfs"
"""The source of the cells of B + M: the fit itself, without detail layers."""
SIRFS_SHADING = "sirfs-shading"
SIRFS_SOURCES = (SIRFS_SHADING, RIVAL)
_NO_LIGHT = PointLights(np.zeros((0, 3)), np.zeros(0))


def measure_sirfs(
    dataset: Dataset,
    name: str,
    setting: str,
    lights: Sequence[LogHarmonics],
    parameters: ModelParameters,
    fits: SirfsFits,
    channels: str = "gray",
    parts: ModelParts = PAPER_PARTS,
    kept: KeptModels | None = None,
    sources: Sequence[str] = SIRFS_SOURCES,
) -> dict[str, tuple[RerenderingCell, ...]]:
    """Fit an object's photograph in one setting and relight what comes of it under every light.

    Parameters
    ----------
    dataset : Dataset
    name, setting : str
    lights : sequence of LogHarmonics
    parameters : ModelParameters
    fits : SirfsFits
    channels : {"gray", "color"}
        What is compared; the fit is in colour.
    parts : ModelParts
        Of the model whose detail comes from the fit's shading.
    kept : KeptModels, optional
    sources : sequence of str
        Of `SIRFS_SOURCES`.

    Returns
    -------
    dict of tuples of RerenderingCell
        By source, one cell for each light.
    """
    with threadpool_limits(limits=1):
        capture = dataset.load(name, setting)
        fit = fits.fit(dataset, name, setting, "color")
        models = {}
        if SIRFS_SHADING in sources:
            images = {SIRFS_SHADING: fitted_parts(fit, capture.photograph)}
            models.update(build_models(capture.photograph, images, parameters, parts, kept))
        if RIVAL in sources:
            models[RIVAL] = fitted_model(fit, capture.photograph.mask)
        return {
            source: rerendering_cells(model, capture.truth, lights, channels)
            for source, model in models.items()
        }


def fitted_model(fit: SirfsFit, mask: Mask) -> ObjectModel:
    """Return a fit as an object model without detail: its albedo, shape and nothing else.

    Parameters
    ----------
    fit : SirfsFit
        In colour.
    mask : (h, w) bool array
        The object; where the fit explains nothing of it, the model is black.

    Returns
    -------
    ObjectModel
    """
    explained = fit.mask[..., None]
    nothing = np.where(mask, 0.0, np.nan)
    return ObjectModel(
        mask,
        np.where(explained, fit.albedo, 0.0),
        np.where(fit.mask, fit.height, 0.0),
        np.where(explained, fit.normals, [0.0, 0.0, 1.0]),
        nothing,
        nothing,
        _NO_LIGHT,
    )


def fitted_parts(fit: SirfsFit, photograph: Photograph) -> IntrinsicImages:
    """Return albedo and shading of a photograph by the shading of a fit, `sirfs-shading`.

    Parameters
    ----------
    fit : SirfsFit
        In colour, of the photograph; pixels that it leaves out get the shading of the nearest.
    photograph : Photograph

    Returns
    -------
    IntrinsicImages

    Raises
    ------
    RelightlabError
        If the photograph is unusable.
    """
    shading = _continued(fit.shading, fit.mask)
    return split_by_shading(photograph.image, photograph.mask, shading)


def _continued(values: Float, known: Mask) -> Float:
    """Give every pixel without a value that of the nearest with one."""
    rows, columns = distance_transform_edt(~known, return_distances=False, return_indices=True)
    continued: Float = values[rows, columns]
    return continued
