"""Parts of the paper's model that a user may replace: base shape and detail layer."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from evaluation.part_registries import Part
from shading_model.arrays import Float, Image, Map, Mask, check_map
from shading_model.errors import RelightlabError
from shading_model.height_field import normals_of_height
from shading_model.object_model import (
    CoarseShape,
    ModelParameters,
    ObjectModel,
    assemble_model,
    contour_base,
)
from shading_model.retinex import IntrinsicImages


@dataclass(frozen=True)
class ModelParts:
    """What takes the place of a part of the model; None keeps the paper's own.

    Parameters
    ----------
    shape : Part, optional
        (mask, image) -> height in pixels, larger is nearer.
    detail_layer : Part, optional
        (shading, mask) -> map in place of S_g.
    """

    shape: Part | None = None
    detail_layer: Part | None = None

    @property
    def method(self) -> str:
        """What tables call a model with these parts.

        Examples
        --------
        >>> ModelParts().method
        'ours'
        """
        given = [part.name for part in (self.shape, self.detail_layer) if part is not None]
        return " + ".join(["ours", *given])

    @property
    def identity(self) -> str:
        """What results depend on; empty where nothing was replaced."""
        given = (("shape", self.shape), ("detail layer", self.detail_layer))
        return " ".join(f"{kind} {part.identity}" for kind, part in given if part is not None)

    def base(self, mask: Mask, image: Image, parameters: ModelParameters) -> CoarseShape:
        """Return the base shape of an object.

        Raises
        ------
        RelightlabError
            If the user's height has another size or is not finite on the mask.
        """
        if self.shape is None:
            return contour_base(mask, parameters)
        height = self.shape.load()(mask.copy(), image.copy())
        checked = _finite_map(height, mask, f"heights by {self.shape.name}")
        return CoarseShape(checked, normals_of_height(checked))

    def assemble(
        self, mask: Mask, shape: CoarseShape, images: IntrinsicImages, parameters: ModelParameters
    ) -> ObjectModel:
        """Return the model on a base shape and a photograph's parts.

        Raises
        ------
        RelightlabError
            If the user's layer has another size or is not finite on the mask.
        """
        model = assemble_model(mask, shape, images, parameters)
        if self.detail_layer is None:
            return model
        detail = self.detail_layer.load()(images.shading.copy(), mask.copy())
        words = f"detail by {self.detail_layer.name}"
        return replace(model, geometric_detail=_finite_map(detail, mask, words))


PAPER_PARTS = ModelParts()


def _finite_map(values: Float, mask: Mask, words: str) -> Map:
    checked = check_map(values, mask, words)
    wrong = int((~np.isfinite(checked[mask])).sum())
    if wrong:
        raise RelightlabError(f"expected {words} to be finite on the mask, got {wrong} that is not")
    return checked
