"""Re-rendering error of one object model under many lights (`eq:MSEmetric`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from datasets.records import GroundTruth
from shading_model.arrays import Float, Image, Mask
from shading_model.errors import RelightlabError, unknown_name
from shading_model.illumination import LogHarmonics, harmonics
from shading_model.object_model import ObjectModel, Weights

CHANNELS = ("gray", "color")
SMALLEST_SHARE = 1e-12
"""Weights of a layer with less than this share of the coarse shading's power are left at zero."""
SMALLEST_SCALE = 1e-6
"""The least k of an oracle, in units in which coarse shading and target have equal power."""


@dataclass(frozen=True, eq=False)
class RerenderingCell:
    """All that the error of one object under one light depends on, for any weights.

    With columns ``X = [A S_c, A S_p, A S_g]`` over the n compared values (pixels times channels)
    and the target I, the error at weights w = (1, w_p, w_g) is
    ``min_k |I - k X w|^2 / n``, a function of the inner products kept here.

    Parameters
    ----------
    gram : (3, 3) array
        ``X^T X / n``.
    cross : (3,) array
        ``X^T I / n``.
    power : float
        Mean of I^2.
    """

    gram: Float
    cross: Float
    power: float

    def error(self, weights: Weights) -> float:
        """Return IMSE' (`eq:MSEmetric`) at these weights, with the best k >= 0; NaN for NaN.

        Parameters
        ----------
        weights : Weights
        """
        return self._error_along(np.array([1.0, weights.parametric, weights.geometric]))

    def oracle(self) -> Weights:
        """Return the weights of least error: joint least squares over k, k w_p and k w_g.

        Where the best k is not positive (the coarse shading opposes what the detail layers leave
        of the target) the least error is only approached as the weights grow without limit; then
        k is held at `SMALLEST_SCALE`, so that still no other weights do better. Layers that are
        zero get weight zero; a cell that was not measured (NaN) has NaN weights.

        Returns
        -------
        Weights
        """
        strength = np.sqrt(np.maximum(np.diag(self.gram), 0.0))
        used = strength**2 > SMALLEST_SHARE * strength[0] ** 2
        scale = np.where(used, strength, 1.0)
        gram = np.where(np.outer(used, used), self.gram / np.outer(scale, scale), 0.0)
        cross = np.where(used, self.cross / scale, 0.0)
        if np.isnan(self.power):
            return Weights(float("nan"), float("nan"))
        if not used[0]:
            return Weights(0.0, 0.0)
        solution: Float = _least_squares(gram, cross, SMALLEST_SCALE * self.power**0.5) / scale
        return Weights(float(solution[1] / solution[0]), float(solution[2] / solution[0]))

    def _error_along(self, direction: Float) -> float:
        length = float(direction @ self.gram @ direction)
        along = max(float(direction @ self.cross), 0.0)
        explained = 0.0 if length <= 0 else along**2 / length
        return max(self.power - explained, 0.0)


def _least_squares(gram: Float, cross: Float, smallest: float) -> Float:
    """Return the minimiser of ``x.gram x - 2 x.cross`` with ``x[0] >= smallest``."""
    solution: Float = np.asarray(np.linalg.lstsq(gram, cross, rcond=1e-10)[0], dtype=np.float64)
    if solution[0] >= smallest:
        return solution
    rest = cross[1:] - smallest * gram[1:, 0]
    return np.array([smallest, *np.linalg.lstsq(gram[1:, 1:], rest, rcond=1e-10)[0]])


def rerendering_cells(
    model: ObjectModel,
    truth: GroundTruth,
    lights: Sequence[LogHarmonics],
    channels: str = "gray",
) -> tuple[RerenderingCell, ...]:
    """Return one cell per light for a model against ``I = A* exp(B(N*) . L)``.

    Compared are the pixels of the model's mask where the true normal and albedo are known.

    Parameters
    ----------
    model : ObjectModel
    truth : GroundTruth
        Normals and albedo are needed.
    lights : sequence of LogHarmonics
        One colour each, coefficients of shape (9,).
    channels : {"gray", "color"}
        Compare the mean over the colour channels, or all three.

    Raises
    ------
    RelightlabError
        If normals or albedo are not known anywhere on the mask, sizes differ, or a light is
        coloured.
    """
    inside = _compared_pixels(model.mask, truth)
    ours, true = (_channels(a, inside, channels) for a in (model.albedo, truth.albedo))
    coefficients = monochrome_coefficients(lights)
    targets = np.exp(harmonics(_known(truth.normals)[inside]) @ coefficients)
    coarse = np.exp(harmonics(model.normals[inside]) @ coefficients)
    details = model.parametric_residual[inside], model.geometric_detail[inside]
    own_power, shared, true_power = (
        np.einsum("nc,nc->n", first, second) / ours.size
        for first, second in ((ours, ours), (ours, true), (true, true))
    )
    cells = []
    for target, shading in zip(targets.T, coarse.T, strict=True):
        columns = np.stack([shading, *details], axis=-1)
        cells.append(
            RerenderingCell(
                gram=columns.T @ (own_power[:, None] * columns),
                cross=columns.T @ (shared * target),
                power=float(true_power @ target**2),
            )
        )
    return tuple(cells)


def image_cell(
    image: Image, mask: Mask, truth: GroundTruth, light: LogHarmonics, channels: str = "gray"
) -> RerenderingCell:
    """Return the cell of a finished relit image, compared as a model's is; it has no layers.

    Parameters
    ----------
    image : (h, w, 3) array
        Linear, at any scale.
    mask : (h, w) bool array
    truth : GroundTruth
    light : LogHarmonics
        Of one colour.
    channels : {"gray", "color"}

    Returns
    -------
    RerenderingCell
        Its error at weights (0, 0) is that of the image.

    Raises
    ------
    RelightlabError
        If the image has another size than the mask or is not finite where it is compared, or as
        `rerendering_cells`.
    """
    if np.shape(image) != (*mask.shape, 3):
        raise RelightlabError(
            f"relight returned shape {np.shape(image)}, expected {(*mask.shape, 3)}"
        )
    inside = _compared_pixels(mask, truth)
    monochrome_coefficients([light])
    given = _channels(np.asarray(image, dtype=np.float64), inside, channels)
    if not np.isfinite(given).all():
        count = int((~np.isfinite(given)).any(axis=-1).sum())
        raise RelightlabError(f"relight returned {count} pixels in the mask that are not finite")
    target = _channels(target_image(truth, light), inside, channels)
    gram, cross = np.zeros((3, 3)), np.zeros(3)
    gram[0, 0], cross[0] = np.mean(given**2), np.mean(given * target)
    return RerenderingCell(gram, cross, float(np.mean(target**2)))


def target_image(truth: GroundTruth, light: LogHarmonics) -> Image:
    """Return ``I = A* exp(B(N*) . L)``, NaN where albedo or normals are unknown.

    Parameters
    ----------
    truth : GroundTruth
    light : LogHarmonics

    Returns
    -------
    (h, w, 3) array

    Raises
    ------
    RelightlabError
        If the truth lacks albedo or normals.
    """
    shading = light.shade(_known(truth.normals))
    return _known(truth.albedo) * (shading if shading.ndim == 3 else shading[..., None])


def _compared_pixels(mask: Mask, truth: GroundTruth) -> Mask:
    normals, albedo = _known(truth.normals), _known(truth.albedo)
    if normals.shape[:2] != mask.shape:
        raise RelightlabError(
            f"the model is of shape {mask.shape} but its truth of {normals.shape[:2]}"
        )
    inside: Mask = mask & np.isfinite(normals).all(axis=-1) & np.isfinite(albedo).all(axis=-1)
    if not inside.any():
        raise RelightlabError("the true normals and albedo are known nowhere on the mask")
    return inside


def _known(values: Float | None) -> Float:
    if values is None:
        raise RelightlabError("re-rendering needs the true normals and the true albedo")
    return values


def _channels(image: Image | None, inside: Mask, channels: str) -> Float:
    if channels not in CHANNELS:
        raise unknown_name("channels", channels, CHANNELS)
    values = _known(image)[inside]
    return values if channels == "color" else values.mean(axis=-1, keepdims=True)


def monochrome_coefficients(lights: Sequence[LogHarmonics]) -> Float:
    """Return the coefficients of lights of one colour.

    Parameters
    ----------
    lights : sequence of LogHarmonics

    Returns
    -------
    (9, l) array

    Raises
    ------
    RelightlabError
        If there is no light, or one is coloured.
    """
    if not lights:
        raise RelightlabError("expected at least one light to relight by, got none")
    if any(light.coefficients.ndim != 1 for light in lights):
        raise RelightlabError(
            "expected lights of one colour, coefficients of shape (9,): use `monochrome()`"
        )
    return np.stack([light.coefficients for light in lights], axis=-1)
