"""The light a photographed diffuse sphere was under, in nine harmonics of each colour.

The irradiance of any light on a matt sphere is within about one per cent of its first nine
harmonics on average (Ramamoorthi and Hanrahan 2001, "An efficient representation for irradiance
environment maps"). A single distant light is the worst case: it leaves half the sphere in shadow,
and that edge is what nine harmonics cannot follow, so a few per cent stay. For such a light the fit
of one `DistantLight` is the better direction, because a picture shows half the sphere, where the
linear and the quadratic harmonics are far from orthogonal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shading_model.arrays import Float, Image, Mask, Normals, check_image
from shading_model.distant_light import DistantLight, fit_distant_light, relative_difference
from shading_model.errors import RelightlabError, unknown_name
from shading_model.harmonic_conversion import fit_log_coefficients
from shading_model.illumination import LinearHarmonics, LogHarmonics, harmonics
from shading_model.probe_sphere import BORDER, ProbeSphere, fit_sphere

LEAST_SQUARES, MINIMUM_NORM, RIDGE = "least-squares", "minimum-norm", "ridge"
FITS = (LEAST_SQUARES, MINIMUM_NORM, RIDGE)
"""What is done where the pixels do not determine nine coefficients: see `fit_diffuse_probe`."""
RIDGE_STRENGTH = 1e-3
SATURATED = 0.999
LARGEST_SATURATED_SHARE = 0.05

_RANK_TOLERANCE = 1e-6
_NO_DIRECTION = 1e-6
# The log fit is iterated; its nine numbers do not need each of a hundred thousand pixels.
_LOG_PIXELS = 3000


@dataclass(frozen=True, eq=False)
class DiffuseProbe:
    """What a photographed diffuse sphere says of its light.

    Parameters
    ----------
    linear : LinearHarmonics
        Nine irradiance coefficients of each colour, shape (9, 3).
    log : LogHarmonics or None
        The log coefficients that explain the same pixels best; None where the rank is below nine
        or a colour is dark all over the sphere.
    residual, log_residual : float
        Root mean square difference between the shading and the picture over the fitted pixels and
        the colours, relative to that of the picture; `log_residual` is NaN without a log fit.
    rank : int
        How many of the nine coefficients the pixels determine.
    condition : float
        Ratio of the largest to the smallest singular value within the rank.
    direction : (3,) array or None
        Unit vector along the three linear coefficients, mean over the colours (x right, y up, z
        toward the viewer); None for a light without any.
    distant : DistantLight or None
        The single distant light that explains the mean of the colours best; None where there is
        none.
    pixels : int
        Number of pixels fitted.
    saturated_share : float
        Share of the sphere's inner pixels left out as saturated.
    sphere : ProbeSphere
    """

    linear: LinearHarmonics
    log: LogHarmonics | None
    residual: float
    log_residual: float
    rank: int
    condition: float
    direction: Float | None
    distant: DistantLight | None
    pixels: int
    saturated_share: float
    sphere: ProbeSphere


def fit_diffuse_probe(
    image: Image,
    mask: Mask,
    *,
    albedo: float | Float = 1.0,
    method: str = LEAST_SQUARES,
    ridge: float = RIDGE_STRENGTH,
    border: float = BORDER,
    saturated: float = SATURATED,
    sphere: ProbeSphere | None = None,
) -> DiffuseProbe:
    """Return the light that explains the picture of a diffuse sphere.

    Pixels with a saturated colour are left out, and so is a ring at the outline, where pixels are
    mixed with the background. The clamp at zero plays no part in the fit, but in the residual.

    Parameters
    ----------
    image : (h, w, 3) or (h, w) array
        Linear picture; finite and at least zero on the sphere.
    mask : (h, w) bool array
        True on the sphere.
    albedo : float or (3,) array
        Of the sphere, above 0 and at most 1.
    method : {"least-squares", "minimum-norm", "ridge"}
        Least squares, refused where the pixels determine fewer than nine coefficients; the least
        squares solution of least norm, whatever the rank; or that of the mean squared difference
        plus `ridge` times the squared norm.
    ridge : float
        Above zero; plays a part in "ridge" only.
    border : float
        Width of the ring in radii; it is never narrower than 1.5 pixels.
    saturated : float
        Values from here on are saturated; infinite where the picture has no such limit.
    sphere : ProbeSphere, optional
        The circle, where it is known; by default that of the mask.

    Returns
    -------
    DiffuseProbe

    Raises
    ------
    RelightlabError
        If the mask is not the picture of a sphere, sizes differ, pixels are NaN, infinite or
        negative, the sphere is dark or saturated, or too few pixels are left.

    Examples
    --------
    >>> rows, columns = np.mgrid[:64, :64]
    >>> mask = np.hypot(rows - 31.5, columns - 31.5) < 30
    >>> normals = fit_sphere(mask).normals((64, 64))
    >>> picture = LinearHarmonics(np.array([0.5, 0.1, 0, 0, 0, 0, 0, 0, 0])).shade(normals)
    >>> probe = fit_diffuse_probe(picture, mask)
    >>> probe.rank, probe.direction.round(6) + 0.0
    (9, array([0., 1., 0.]))
    """
    if method not in FITS:
        raise unknown_name("fit", method, FITS)
    if not 0 < ridge < np.inf:
        raise RelightlabError(f"expected a ridge above zero, got {ridge}")
    sphere = sphere or fit_sphere(mask)
    inner = sphere.inner_pixels(np.asarray(mask, dtype=bool), border)
    _check_any(inner)
    colours = _checked(image, inner)[inner]
    bright = (colours >= saturated).any(axis=-1)
    _check_saturation(float(bright.mean()))
    normals = sphere.normals(inner.shape)[inner][~bright]
    shading = colours[~bright] / _checked_albedo(albedo)
    _check_lit(shading)
    design = _Design.of(normals)
    _check_rank(design, method)
    linear = LinearHarmonics(design.solve(shading, ridge if method == RIDGE else 0.0))
    log = _log_fit(normals, shading) if design.rank == 9 else None
    return DiffuseProbe(
        linear=linear,
        log=log,
        residual=relative_difference(linear.shade(normals), shading),
        log_residual=np.nan if log is None else relative_difference(log.shade(normals), shading),
        rank=design.rank,
        condition=design.condition,
        direction=dominant_direction(linear),
        distant=fit_distant_light(normals, shading.mean(axis=-1)),
        pixels=len(shading),
        saturated_share=float(bright.mean()),
        sphere=sphere,
    )


def dominant_direction(light: LinearHarmonics) -> Float | None:
    """Return the unit vector along the three linear coefficients of a light.

    Parameters
    ----------
    light : LinearHarmonics
        Of coefficients (9,) or (9, 3); colours are averaged.

    Returns
    -------
    (3,) array or None
        (x right, y up, z toward the viewer); None where the three are zero up to rounding.

    Examples
    --------
    >>> dominant_direction(LinearHarmonics(np.array([1.0, 0, 0.2, 0, 0, 0, 0, 0, 0])))
    array([0., 0., 1.])
    >>> dominant_direction(LinearHarmonics(np.eye(9)[0])) is None
    True
    """
    coefficients = light.monochrome().coefficients
    toward = coefficients[[3, 1, 2]]
    length = float(np.linalg.norm(toward))
    if length <= _NO_DIRECTION * float(np.linalg.norm(coefficients)):
        return None
    unit: Float = toward / length
    return unit


@dataclass(frozen=True, eq=False)
class _Design:
    """Singular values of the harmonics over the pixels: Q (n, 9), s (9,), V^T (9, 9)."""

    left: Float
    singular: Float
    right: Float

    @classmethod
    def of(cls, normals: Normals) -> _Design:
        # A thin QR first: the singular values of the small factor are those of the tall matrix.
        orthogonal, triangular = np.linalg.qr(harmonics(normals))
        left, singular, right = np.linalg.svd(triangular, full_matrices=False)
        return cls(orthogonal @ left, singular, right)

    @property
    def rank(self) -> int:
        return int((self.singular > _RANK_TOLERANCE * self.singular[0]).sum())

    @property
    def condition(self) -> float:
        return float(self.singular[0] / self.singular[self.rank - 1])

    def solve(self, shading: Float, ridge: float) -> Float:
        kept = self.singular[: self.rank]
        gain = kept / (kept**2 + ridge * len(shading))
        projected = gain[:, None] * (self.left[:, : self.rank].T @ shading)
        coefficients: Float = self.right[: self.rank].T @ projected
        return coefficients


def _log_fit(normals: Normals, shading: Float) -> LogHarmonics | None:
    chosen = np.arange(0, len(shading), max(1, len(shading) // _LOG_PIXELS))
    sample = shading[chosen]
    if not (sample > 0).any(axis=0).all():
        return None
    fits = [fit_log_coefficients(normals[chosen], colour) for colour in sample.T]
    return LogHarmonics(np.stack(fits, axis=-1))


def _checked(image: Image, inner: Mask) -> Image:
    given = np.asarray(image)
    if given.shape[:2] == inner.shape:
        _check_lit(given[inner])
    return check_image(image, inner)


def _check_lit(colours: Float) -> None:
    if not colours.any():
        raise RelightlabError("the light probe is dark: its sphere shows no light to measure")


def _checked_albedo(albedo: float | Float) -> Float:
    checked = np.asarray(albedo, dtype=np.float64)
    if checked.shape not in {(), (3,)} or not ((checked > 0) & (checked <= 1)).all():
        raise RelightlabError(
            f"expected an albedo above 0 and at most 1, one or three of it, got {albedo}"
        )
    return checked


def _check_any(inner: Mask) -> None:
    if not inner.any():
        raise RelightlabError(
            "the sphere is too small: no pixel is left off the ring at its outline, so the rank is"
            " 0 of 9"
        )


def _check_saturation(share: float) -> None:
    if share > LARGEST_SATURATED_SHARE:
        raise RelightlabError(
            f"the light probe is saturated on {100 * share:.0f} % of the sphere, at most"
            f" {100 * LARGEST_SATURATED_SHARE:.0f} % is left out: expose it less, or give an .exr"
        )


def _check_rank(design: _Design, method: str) -> None:
    if method == LEAST_SQUARES and design.rank < 9:
        raise RelightlabError(
            f"the sphere's {len(design.left)} pixels determine {design.rank} of the 9 coefficients:"
            f" take a larger picture, or fit with '{MINIMUM_NORM}' or '{RIDGE}'"
        )
