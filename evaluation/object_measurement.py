"""What Table 1 measures on one object in one setting: the work of one task."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from threadpoolctl import threadpool_limits

from datasets.records import Capture, Dataset, Photograph
from evaluation.intrinsic_metrics import intrinsic_error
from evaluation.kept_models import KeptModels
from evaluation.model_parts import PAPER_PARTS, ModelParts
from evaluation.rerendering import RerenderingCell, rerendering_cells
from evaluation.retinex_thresholds import thresholds_for
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics
from shading_model.illumination_fit import fit_harmonics
from shading_model.object_model import (
    CoarseShape,
    ModelParameters,
    ObjectModel,
    split_by_shading,
)
from shading_model.retinex import IntrinsicImages, retinex

DARKEST_SHADING = 1e-3
"""A true shading is not taken below this when a photograph is divided by it."""


@dataclass(frozen=True, eq=False)
class ObjectResult:
    """What was measured on one object in one setting.

    Parameters
    ----------
    name, setting : str
    cells : dict of tuples of RerenderingCell
        By detail source, and ``flat`` for the Retinex albedo on a flat shape: one per light.
    retinex_error : float
        LMSE of the Retinex albedo and shading (`intrinsic_error`).
    point_light_residual, harmonic_residual : float
        Root mean square of the Retinex shading minus its fit by five point sources and by nine
        harmonics (`fig:SHlight`).
    """

    name: str
    setting: str
    cells: dict[str, tuple[RerenderingCell, ...]]
    retinex_error: float
    point_light_residual: float
    harmonic_residual: float


def measure_object(
    dataset: Dataset,
    name: str,
    setting: str,
    lights: Sequence[LogHarmonics],
    parameters: ModelParameters,
    channels: str = "gray",
    parts: ModelParts = PAPER_PARTS,
    kept: KeptModels | None = None,
) -> ObjectResult:
    """Build an object's models in one setting and relight them under every light.

    Parameters
    ----------
    dataset : Dataset
    name, setting : str
    lights : sequence of LogHarmonics
    parameters : ModelParameters
    channels : {"gray", "color"}
    parts : ModelParts
        Base shape and detail layer of one's own, where given.
    kept : KeptModels, optional
        Where models are looked for before they are built, and kept.

    Returns
    -------
    ObjectResult
    """
    with threadpool_limits(limits=1):
        capture = dataset.load(name, setting)
        photograph, truth = capture.photograph, capture.truth
        thresholds = thresholds_for(dataset.name, setting, name) or parameters.thresholds
        split = retinex(photograph.image, photograph.mask, thresholds)
        sources = {"default": split, "gt-shading": true_parts(capture)}
        models = build_models(photograph, sources, parameters, parts, kept)
        models["flat"] = _flattened(models["default"])
        cells = {
            source: rerendering_cells(model, truth, lights, channels)
            for source, model in models.items()
        }
        return ObjectResult(
            name,
            setting,
            cells,
            _retinex_error(split, capture),
            _point_light_residual(models["default"]),
            fit_harmonics(split.shading, models["default"].normals).root_mean_square,
        )


def build_models(
    photograph: Photograph,
    sources: Mapping[str, IntrinsicImages],
    parameters: ModelParameters,
    parts: ModelParts = PAPER_PARTS,
    kept: KeptModels | None = None,
) -> dict[str, ObjectModel]:
    """Return one model for each source of detail, all on the same base shape.

    Parameters
    ----------
    photograph : Photograph
    sources : mapping of str to IntrinsicImages
        Albedo and shading of the photograph, by the source's name.
    parameters : ModelParameters
    parts : ModelParts
    kept : KeptModels, optional

    Returns
    -------
    dict of ObjectModel
    """

    @cache
    def shape() -> CoarseShape:
        return parts.base(photograph.mask, photograph.image, parameters)

    def model(images: IntrinsicImages) -> ObjectModel:
        def build() -> ObjectModel:
            return parts.assemble(photograph.mask, shape(), images, parameters)

        if kept is None:
            return build()
        return kept.get_or_build(photograph, images, parameters, parts, build)

    return {source: model(images) for source, images in sources.items()}


def true_parts(capture: Capture) -> IntrinsicImages:
    """Return albedo and shading of a photograph by its true shading, the source ``gt-shading``.

    Parameters
    ----------
    capture : Capture

    Returns
    -------
    IntrinsicImages

    Raises
    ------
    RelightlabError
        If the true shading is not known.
    """
    if capture.truth.shading is None:
        raise RelightlabError(f"the true shading of {capture.photograph.name} is not known")
    shading = np.maximum(capture.truth.shading, DARKEST_SHADING)
    return split_by_shading(capture.photograph.image, capture.photograph.mask, shading)


def _flattened(model: ObjectModel) -> ObjectModel:
    inside = model.mask[..., None]
    facing = np.where(inside, [0.0, 0.0, 1.0], np.nan)
    nothing = np.where(model.mask, 0.0, np.nan)
    shape = CoarseShape(nothing, facing)
    return ObjectModel(
        model.mask,
        model.albedo,
        shape.height,
        shape.normals,
        nothing,
        nothing,
        model.illumination,
    )


def _retinex_error(parts: IntrinsicImages, capture: Capture) -> float:
    truth = capture.truth
    if truth.albedo is None or truth.shading is None:
        return float("nan")
    mask = capture.photograph.mask
    return intrinsic_error(parts.albedo, parts.shading, truth.albedo, truth.shading, mask)


def _point_light_residual(model: ObjectModel) -> float:
    return float(np.sqrt(np.nanmean(model.parametric_residual**2)))
