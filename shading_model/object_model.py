"""The object model: albedo times shading of a coarse shape plus two detail layers (`eq:model`)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shading_model.arrays import (
    Float,
    Image,
    Map,
    Mask,
    Normals,
    check_image,
    check_map,
    check_mask,
)
from shading_model.contour_shape import SLOPE_LIMIT, shape_from_contour
from shading_model.errors import RelightlabError
from shading_model.geometric_detail import SPARSITY, PatchDictionary, geometric_detail
from shading_model.illumination import Illumination, PointLights
from shading_model.illumination_fit import fit_point_lights
from shading_model.retinex import (
    DEFAULT_THRESHOLDS,
    MEAN_SHADING,
    IntrinsicImages,
    RetinexThresholds,
    retinex,
)


@dataclass(frozen=True)
class Weights:
    """Weights of the detail layers, w = (1, w_p, w_g).

    Parameters
    ----------
    parametric : float
        w_p, of the parametric residual.
    geometric : float
        w_g, of the geometric detail.
    """

    parametric: float = 1.0
    geometric: float = 1.0


@dataclass(frozen=True, eq=False)
class CoarseShape:
    """A base shape Z, wherever it came from.

    Parameters
    ----------
    height : (h, w) array
        Pixels, larger is nearer; NaN outside the mask.
    normals : (h, w, 3) array
        Unit normals (x right, y up, z toward the viewer); NaN outside the mask.
    """

    height: Map
    normals: Normals


@dataclass(frozen=True, eq=False)
class ModelParameters:
    """What building a model depends on besides the photograph.

    Parameters
    ----------
    dictionary : PatchDictionary
        Smooth shading patches, for the geometric detail.
    thresholds : RetinexThresholds
    slope_limit : float
        epsilon of the height equation.
    sparsity : float
        L1 weight of the geometric detail.
    """

    dictionary: PatchDictionary
    thresholds: RetinexThresholds = DEFAULT_THRESHOLDS
    slope_limit: float = SLOPE_LIMIT
    sparsity: float = SPARSITY


@dataclass(frozen=True, eq=False)
class ObjectModel:
    """An object cut from one photograph, ready to be relit.

    Every map is NaN outside the mask; in-mask arrays of the photograph itself are reproduced by
    ``albedo * (fitted shading + S_p)``.

    Parameters
    ----------
    mask : (h, w) bool array
    albedo : (h, w, 3) array
        A.
    height : (h, w) array
        Z in pixels.
    normals : (h, w, 3) array
        Unit normals the coarse shading is computed from.
    parametric_residual : (h, w) array
        S_p.
    geometric_detail : (h, w) array
        S_g.
    illumination : PointLights
        The fitted light of the photograph, L(theta).

    Raises
    ------
    RelightlabError
        If a map has another size than the mask.
    """

    mask: Mask
    albedo: Image
    height: Map
    normals: Normals
    parametric_residual: Map
    geometric_detail: Map
    illumination: PointLights

    def __post_init__(self) -> None:
        mask = check_mask(self.mask)
        object.__setattr__(self, "mask", mask)
        for name, channels in _MAPS.items():
            words = name.replace("_", " ")
            object.__setattr__(self, name, check_map(getattr(self, name), mask, words, channels))

    def shade(self, illumination: Illumination, weights: Weights = Weights()) -> Float:
        """Return ``shade(Z, L) + w_p S_p + w_g S_g`` (`eq:model`), NaN outside the mask.

        Parameters
        ----------
        illumination : Illumination
        weights : Weights

        Returns
        -------
        (h, w) or (h, w, 3) array
            As many channels as the illumination has; it may be negative where a detail layer
            outweighs a dark coarse shading.
        """
        coarse = illumination.shade(self.normals, self.height)
        detail = (
            weights.parametric * self.parametric_residual
            + weights.geometric * self.geometric_detail
        )
        shading: Float = coarse + (detail if coarse.ndim == 2 else detail[..., None])
        return shading

    def relight(self, illumination: Illumination, weights: Weights = Weights()) -> Image:
        """Return the object under another light, ``A S`` (`eq:detail_composite`).

        Parameters
        ----------
        illumination : Illumination
        weights : Weights

        Returns
        -------
        (h, w, 3) array
            Linear, not clipped, NaN outside the mask.
        """
        shading = self.shade(illumination, weights)
        return self.albedo * (shading if shading.ndim == 3 else shading[..., None])


_MAPS: dict[str, int | None] = {
    "albedo": 3,
    "height": None,
    "normals": 3,
    "parametric_residual": None,
    "geometric_detail": None,
}


def build_model(
    image: Image,
    mask: Mask,
    parameters: ModelParameters,
    *,
    shape: CoarseShape | None = None,
    shading: Float | None = None,
) -> ObjectModel:
    """Build the model of an object from one photograph.

    Parameters
    ----------
    image : (h, w, 3) array
        Linear intensities; outside the mask they play no part.
    mask : (h, w) bool array
    parameters : ModelParameters
    shape : CoarseShape, optional
        Base shape; by default the shape from contour.
    shading : (h, w) or (h, w, 3) array, optional
        Shading of the photograph, positive, any scale; by default that of colour Retinex.

    Returns
    -------
    ObjectModel

    Raises
    ------
    RelightlabError
        For an empty mask, sizes that differ, NaN, negative or all-black pixels, or a shading that
        is not positive.

    Examples
    --------
    >>> rows, columns = np.mgrid[-9:10, -9:10]
    >>> atoms = PatchDictionary(np.eye(16).reshape(16, 4, 4))
    >>> model = build_model(np.full((19, 19, 3), 0.3), np.hypot(rows, columns) < 9,
    ...                     ModelParameters(atoms))
    >>> bool(np.allclose(model.shade(model.illumination)[9, 9]
    ...                  - model.geometric_detail[9, 9], 0.5))
    True
    """
    inside = check_mask(mask)
    base = shape or contour_base(inside, parameters)
    parts = (
        retinex(image, inside, parameters.thresholds)
        if shading is None
        else split_by_shading(image, inside, shading)
    )
    return assemble_model(inside, base, parts, parameters)


def contour_base(mask: Mask, parameters: ModelParameters) -> CoarseShape:
    """Return the paper's base shape of a mask, `shape_from_contour`.

    Parameters
    ----------
    mask : (h, w) bool array
    parameters : ModelParameters

    Returns
    -------
    CoarseShape
    """
    shape = shape_from_contour(mask, slope_limit=parameters.slope_limit)
    return CoarseShape(shape.height, shape.normals)


def split_by_shading(image: Image, mask: Mask, shading: Float) -> IntrinsicImages:
    """Return albedo and shading of a photograph whose shading is known up to scale.

    Parameters
    ----------
    image : (h, w, 3) array
    mask : (h, w) bool array
    shading : (h, w) or (h, w, 3) array
        Each channel of the photograph is divided by its own shading; the shading of the model is
        the mean over the channels.

    Returns
    -------
    IntrinsicImages

    Raises
    ------
    RelightlabError
        If the shading is not positive all over the mask, or the photograph is unusable.
    """
    checked = check_map(shading, mask, "shading", 3 if np.ndim(shading) == 3 else None)
    if not (checked[mask] > 0).all():
        raise RelightlabError("expected a shading above zero all over the mask: clip it first")
    colour = checked if checked.ndim == 3 else checked[..., None]
    gray = colour.mean(axis=-1)
    scale = MEAN_SHADING / np.nanmean(gray)
    return IntrinsicImages(check_image(image, mask) / (scale * colour), scale * gray)


def assemble_model(
    mask: Mask,
    shape: CoarseShape,
    parts: IntrinsicImages,
    parameters: ModelParameters,
    detail: Map | None = None,
) -> ObjectModel:
    """Derive both detail layers from a base shape and a photograph's parts.

    ``S_p = S - shade(Z, L(theta))`` (`eq:computePS`) with L fitted by `fit_point_lights`.

    Parameters
    ----------
    mask : (h, w) bool array
    shape : CoarseShape
    parts : IntrinsicImages
    parameters : ModelParameters
    detail : (h, w) array, optional
        S_g of these parts, if it is known already: it does not depend on the shape.

    Returns
    -------
    ObjectModel
    """
    light = fit_point_lights(parts.shading, shape.normals, shape.height).illumination
    fitted = light.shade(shape.normals, shape.height)
    if detail is None:
        detail = geometric_detail(
            parts.shading, mask, parameters.dictionary, sparsity=parameters.sparsity
        )
    return ObjectModel(
        mask, parts.albedo, shape.height, shape.normals, parts.shading - fitted, detail, light
    )
