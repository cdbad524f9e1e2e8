"""Errors of a fit against the truth: those that SIRFS was published with.

All are invariant to what one photograph cannot tell: the offset of the height, and one scale of
shading, of albedo and of the light.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields

import numpy as np

from datasets.records import GroundTruth
from evaluation.intrinsic_metrics import local_mean_squared_error
from evaluation.sirfs.result import SirfsFit
from shading_model.arrays import Float, Map, Mask, Normals
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics, harmonics

NOTHING = 1e-10
"""Errors not above this are left out of geometric means."""
SPHERE = 256
"""Side in pixels of the picture of a sphere that lights are compared on."""


@dataclass(frozen=True)
class SirfsErrors:
    """The six errors of a fit; NaN where the truth is not known.

    Parameters
    ----------
    z_mae : float
        Mean absolute error of the height in pixels, after the best shift.
    n_mae : float
        Mean angle between the normals in radians.
    s_mse, r_mse : float
        Mean squared error of shading and of albedo (reflectance), after the best scale.
    rs_mse : float
        Mean of the LMSE of both (`local_mean_squared_error`).
    l_mse : float
        Mean squared error of a sphere's shading under the light, after the best scale.
    """

    z_mae: float
    n_mae: float
    s_mse: float
    r_mse: float
    rs_mse: float
    l_mse: float

    @property
    def mean(self) -> float:
        """Geometric mean of the six; NaN if one is not known.

        Examples
        --------
        >>> SirfsErrors(1.0, 1.0, 1.0, 1.0, 1.0, 64.0).mean
        2.0
        """
        return _geometric_mean(astuple(self))


ERROR_NAMES = tuple(field.name for field in fields(SirfsErrors))
"""The six errors, in the order they are reported."""


def sirfs_errors(fit: SirfsFit, truth: GroundTruth) -> SirfsErrors:
    """Return the errors of a fit.

    A gray fit is compared with the mean over the channels of the true albedo, shading and light.

    Parameters
    ----------
    fit : SirfsFit
    truth : GroundTruth
        Of the same size; a part that is None leaves its errors NaN.

    Returns
    -------
    SirfsErrors

    Raises
    ------
    RelightlabError
        If the sizes differ, or fit and truth have no pixel in common.

    Examples
    --------
    >>> flat = np.zeros((9, 9))
    >>> facing = np.broadcast_to([0.0, 0.0, 1.0], (9, 9, 3))
    >>> gray, light = np.full((9, 9, 1), 0.5), LogHarmonics(np.zeros(9))
    >>> fit = SirfsFit(flat == 0, flat, facing, gray, gray, light, 0.0, {}, 0.0, "")
    >>> ramp = flat + np.arange(9.0)
    >>> truth = GroundTruth(ramp, facing, np.ones((9, 9, 3)), np.ones((9, 9, 3)), light)
    >>> round(sirfs_errors(fit, truth).z_mae, 3)
    2.222
    """
    albedo, shading = (_like(fit, values) for values in (truth.albedo, truth.shading))
    frame = _without_rim(_known_everywhere(fit, truth, albedo, shading))
    parts = [(fit.shading, shading), (fit.albedo, albedo)]
    squared = [_scaled_error(ours, true, frame) for ours, true in parts]
    local = [_local_error(ours, true, frame) for ours, true in parts]
    return SirfsErrors(
        z_mae=_height_error(fit.height, truth.height),
        n_mae=_normal_error(fit.normals, truth.normals),
        s_mse=squared[0],
        r_mse=squared[1],
        rs_mse=float(np.mean(local)),
        l_mse=_light_error(fit.illumination, truth.illumination),
    )


def geometric_mean_errors(errors: Sequence[SirfsErrors]) -> SirfsErrors:
    """Return the geometric mean of each error over a set of objects.

    Parameters
    ----------
    errors : sequence of SirfsErrors
        At least one.

    Returns
    -------
    SirfsErrors
        Its own `mean` is that of the objects' means, where no error is left out as zero.

    Raises
    ------
    RelightlabError
        If there are none.

    Examples
    --------
    >>> one, four = SirfsErrors(*[1.0] * 6), SirfsErrors(*[4.0] * 6)
    >>> geometric_mean_errors([one, four]).n_mae
    2.0
    """
    if not errors:
        raise RelightlabError("expected the errors of at least one object, got none")
    columns = zip(*map(astuple, errors), strict=True)
    return SirfsErrors(*map(_geometric_mean, columns))


def _geometric_mean(values: Sequence[float]) -> float:
    given = np.asarray(values, dtype=np.float64)
    counted = given[~(given <= NOTHING)]
    return float(np.exp(np.log(counted).mean())) if counted.size else 0.0


def _like(fit: SirfsFit, values: Float | None) -> Float | None:
    """Return a true colour map with as many channels as the fit has."""
    if values is None:
        return None
    return values if fit.albedo.shape[-1] == 3 else values.mean(axis=-1, keepdims=True)


def _known_everywhere(
    fit: SirfsFit, truth: GroundTruth, albedo: Float | None, shading: Float | None
) -> Mask:
    """Return where all maps of the fit and all that are known of the truth are finite."""
    ours: tuple[Float, ...] = (fit.height, fit.normals, fit.albedo, fit.shading)
    known = [map_ for map_ in (truth.height, truth.normals, albedo, shading) if map_ is not None]
    if any(map_.shape[:2] != fit.mask.shape for map_ in known):
        sizes = next(map_.shape[:2] for map_ in known if map_.shape[:2] != fit.mask.shape)
        raise RelightlabError(f"the fit is of shape {fit.mask.shape} but its truth of {sizes}")
    finite = [np.isfinite(np.atleast_3d(map_)).all(axis=-1) for map_ in (*ours, *known)]
    everywhere: Mask = fit.mask & np.logical_and.reduce(finite)
    return everywhere


def _without_rim(inside: Mask) -> Mask:
    """Leave out the outermost rows and columns of the picture, and refuse an empty rest."""
    rest = np.zeros_like(inside)
    rest[1:-1, 1:-1] = inside[1:-1, 1:-1]
    if not rest.any():
        raise RelightlabError("the fit and its truth have no pixel in common")
    return rest


def _height_error(ours: Map, true: Map | None) -> float:
    if true is None:
        return float("nan")
    differences = (ours - true)[np.isfinite(ours) & np.isfinite(true)]
    return float(np.abs(differences - np.median(differences)).mean())


def _normal_error(ours: Normals, true: Normals | None) -> float:
    if true is None:
        return float("nan")
    cosines = np.einsum("...i,...i->...", ours, true)
    return float(np.arccos(np.clip(cosines[np.isfinite(cosines)], -1.0, 1.0)).mean())


def _scaled_error(ours: Float, true: Float | None, inside: Mask) -> float:
    return float("nan") if true is None else _squared_error(ours[inside], true[inside])


def _squared_error(ours: Float, true: Float) -> float:
    """Return the mean squared error after one best scale of all channels together."""
    power = float(np.sum(ours**2))
    scale = float(np.sum(ours * true)) / power if power > 0 else 0.0
    return float(np.mean((scale * ours - true) ** 2))


def _local_error(ours: Float, true: Float | None, inside: Mask) -> float:
    return float("nan") if true is None else local_mean_squared_error(ours, true, inside)


def _light_error(ours: LogHarmonics, true: LogHarmonics | None) -> float:
    if true is None:
        return float("nan")
    light = true if ours.coefficients.ndim == 2 else true.monochrome()
    basis = _sphere_harmonics()
    return _squared_error(*(np.exp(basis @ one.coefficients) for one in (ours, light)))


def _sphere_harmonics() -> Float:
    """Return the harmonics of a sphere's visible normals, on the published grid of its picture."""
    steps = (np.arange(1, SPHERE + 1) - SPHERE / 2) / (SPHERE / 2)
    down, right = np.meshgrid(steps, steps, indexing="ij")
    squared = 1 - down**2 - right**2
    seen = squared > 0
    normals = np.stack([right[seen], -down[seen], np.sqrt(squared[seen])], axis=-1)
    return harmonics(normals)
