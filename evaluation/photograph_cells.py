"""Re-rendering error of a model against a real photograph under a known light (`eq:MSEmetric`)."""

from __future__ import annotations

import numpy as np

from evaluation.rerendering import CHANNELS, RerenderingCell
from shading_model.arrays import Float, Image
from shading_model.errors import RelightlabError, unknown_name
from shading_model.illumination import Illumination
from shading_model.object_model import ObjectModel, Weights


def photograph_cell(
    model: ObjectModel,
    photograph: Image,
    light: Illumination,
    channels: str = "gray",
    *,
    match_exposure: bool = True,
) -> RerenderingCell:
    """Return the cell of a model relit as a photograph was taken, over all pixels of its mask.

    The scale of a light is free, as k is, but detail layers have the scale of the photograph that
    the model was built from, so (1, 1) means nothing until the two are brought together: the light
    is scaled so that the coarse shading has the mean of the shading the model was built from.

    Parameters
    ----------
    model : ObjectModel
    photograph : (h, w, 3) array
        Linear; with cast shadows, highlights and all.
    light : Illumination
        Of one colour or of three.
    channels : {"gray", "color"}
        Compare the mean over the colour channels, or all three.
    match_exposure : bool
        False takes the light's own scale.

    Returns
    -------
    RerenderingCell

    Raises
    ------
    RelightlabError
        If sizes differ, the photograph is not finite on the mask, the light leaves the shape
        dark, or the channels are unknown.
    """
    inside = model.mask
    target = _checked(photograph, model)[inside]
    coarse = light.shade(model.normals, model.height)[inside]
    coarse = coarse if coarse.ndim == 2 else coarse[:, None]
    if match_exposure:
        coarse = coarse * _exposure(model, coarse)
    layers = (model.parametric_residual, model.geometric_detail)
    shadings = [coarse, *(layer[inside][:, None] for layer in layers)]
    columns = np.stack([_compared(model.albedo[inside] * s, channels) for s in shadings], axis=-1)
    wanted = _compared(target, channels)
    count = wanted.size
    return RerenderingCell(
        gram=columns.T @ columns / count,
        cross=columns.T @ wanted / count,
        power=float(wanted @ wanted / count),
    )


def relit_as_photographed(
    model: ObjectModel, light: Illumination, weights: Weights, *, match_exposure: bool = True
) -> Image:
    """Return the picture whose error against a photograph `photograph_cell` measures, up to k.

    Parameters
    ----------
    model : ObjectModel
    light : Illumination
    weights : Weights
    match_exposure : bool
        As for `photograph_cell`.

    Returns
    -------
    (h, w, 3) array
        Linear, not clipped, NaN outside the mask.

    Raises
    ------
    RelightlabError
        If the light leaves the shape dark.
    """
    coarse = light.shade(model.normals, model.height)
    coarse = coarse if coarse.ndim == 3 else coarse[..., None]
    factor = _exposure(model, coarse[model.mask]) if match_exposure else 1.0
    detail = (
        weights.parametric * model.parametric_residual + weights.geometric * model.geometric_detail
    )
    return model.albedo * (factor * coarse + detail[..., None])


def _exposure(model: ObjectModel, coarse: Float) -> float:
    """Return what scales a coarse shading to the mean of the shading the model was built from."""
    own = model.illumination.shade(model.normals, model.height) + model.parametric_residual
    mean = float(coarse.mean())
    if not mean > 0:
        raise RelightlabError("the light leaves the whole shape dark: is it behind the object?")
    return float(own[model.mask].mean()) / mean


def _checked(photograph: Image, model: ObjectModel) -> Image:
    if np.shape(photograph) != (*model.mask.shape, 3):
        raise RelightlabError(
            f"expected a photograph of shape {(*model.mask.shape, 3)} as the model's, got"
            f" {np.shape(photograph)}"
        )
    if not np.isfinite(photograph[model.mask]).all():
        raise RelightlabError("the photograph has pixels on the mask that are not finite")
    return photograph


def _compared(values: Float, channels: str) -> Float:
    if channels not in CHANNELS:
        raise unknown_name("channels", channels, CHANNELS)
    compared: Float = values.ravel() if channels == "color" else values.mean(axis=-1)
    return compared
