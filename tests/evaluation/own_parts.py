"""Methods and parts as a user would bring them; tests name them as ``module:callable``."""
# ruff: noqa: ARG001, ARG005  what is given to a part need not be used by it

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from datasets.model_parameters import shipped_parameters
from evaluation.weight_rules import CellGrid
from shading_model.arrays import Float, Image, Map, Mask
from shading_model.height_field import normals_of_height
from shading_model.object_model import build_model

_CALLS = {"built": 0}


def ball(image: Image, mask: Mask) -> Any:
    """Return the photograph's own colours on a dome, a method of few lines."""
    dome = np.where(mask, np.sqrt(mask.sum()) * np.ones(mask.shape) / 4, np.nan)
    normals = normals_of_height(dome)
    return SimpleNamespace(relight=lambda light: image * light.shade(normals, dome)[..., None])


def ours_again(image: Image, mask: Mask) -> Any:
    """Return the paper's model at weights (1, 1), with a name and a version of its own."""
    return build_model(image, mask, shipped_parameters())


ours_again.name = "again"  # type: ignore[attr-defined]
ours_again.version = "2"  # type: ignore[attr-defined]


def _relights(relight: Any) -> Any:
    return SimpleNamespace(relight=relight)


def gray_shape(image: Image, mask: Mask) -> Any:
    """Return one channel instead of three."""
    return _relights(lambda _: image[..., 0])


def not_finite(image: Image, mask: Mask) -> Any:
    """Return NaN everywhere."""
    return _relights(lambda _: np.full(image.shape, np.nan))


def constant(image: Image, mask: Mask) -> Any:
    """Return the photograph under every light."""
    return _relights(lambda _: image)


def forgetful(image: Image, mask: Mask) -> Any:
    """Return something else each time."""
    _CALLS["built"] += 1
    made = _CALLS["built"]
    return _relights(lambda light: image * (made + light.coefficients[1]))


def careless(image: Image, mask: Mask) -> Any:
    """Write on what was given."""
    image[:] = image * 0.5
    return _relights(lambda light: 0 * image + light.coefficients[1])


def needs_whole(image: Image, mask: Mask) -> Any:
    """Refuse a mask with a hole."""
    middle = mask.shape[0] // 2, mask.shape[1] // 2
    if not mask[middle]:
        raise ValueError("a hole")
    return _relights(lambda light: image * light.coefficients[1])


def raising(image: Image, mask: Mask) -> Any:
    """Raise while building."""
    raise KeyError("weights.bin")


def without_relight(image: Image, mask: Mask) -> Any:
    """Return something that cannot relight."""
    return image


def complex_values(image: Image, mask: Mask) -> Any:
    """Return complex numbers."""
    return _relights(lambda light: image * 1j)


def cone(mask: Mask, image: Image) -> Map:
    """Return a height that falls off from the middle."""
    rows, columns = np.indices(mask.shape)
    away = np.hypot(rows - rows[mask].mean(), columns - columns[mask].mean())
    return np.maximum(away[mask].max() - away, 0.0)


def short_shape(mask: Mask, image: Image) -> Map:
    """Return a height that is too small."""
    return np.zeros((3, 3))


def doubled_detail(shading: Map, mask: Mask) -> Map:
    """Return the shading minus its mean, in place of S_g."""
    return shading - np.nanmean(shading)


def quarter(grid: CellGrid) -> Float:
    """Return weights of one quarter."""
    return np.full((len(grid.cells), len(grid.coefficients), 2), 0.25)


def flat_weights(grid: CellGrid) -> Float:
    """Return weights of the wrong shape."""
    return np.zeros(2)


def unknown_detail(shading: Map, mask: Mask) -> Map:
    """Return a layer that is known nowhere."""
    return np.full(mask.shape, np.nan)


def built_nothing() -> None:
    """Take no argument, as no part may."""


NOT_CALLABLE = 3
