"""Spherical-harmonic illuminations converted between conventions, and rotated.

exp(B(N) . L) and max(0, B(N) . L) are different families of shadings, so a conversion is the best
approximation on the normals a viewer sees. A rotation stays inside its family and is exact.
"""

from __future__ import annotations

import math
from functools import cache
from typing import TypeVar

import numpy as np
from scipy.optimize import least_squares

from shading_model.arrays import Float, Normals
from shading_model.errors import RelightlabError
from shading_model.illumination import C4, LinearHarmonics, LogHarmonics, harmonics

Harmonics = TypeVar("Harmonics", LogHarmonics, LinearHarmonics)

_NORMAL_COUNT = 2000
_GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))
# A shading below this share of its maximum counts as this share where a logarithm starts a fit.
_STARTING_FLOOR = 0.02


@cache
def visible_normals(count: int = _NORMAL_COUNT) -> Normals:
    """Return unit normals with z > 0, evenly spread over the picture of a sphere.

    Equal numbers fall on equal areas of the disk the viewer sees (a sunflower spiral), so a fit
    over them weights directions as a photograph does. Deterministic.

    Parameters
    ----------
    count : int
        Number of normals.

    Returns
    -------
    (count, 3) array, read only

    Examples
    --------
    >>> normals = visible_normals(1000)
    >>> bool((normals[:, 2] > 0).all()), (normals[:, :2].mean(axis=0).round(2) + 0.0).tolist()
    (True, [0.0, 0.0])
    """
    index = np.arange(count)
    squared_radius = (index + 0.5) / count
    radius, angle = np.sqrt(squared_radius), index * _GOLDEN_ANGLE
    normals = np.stack(
        [radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1.0 - squared_radius)], axis=-1
    )
    normals.setflags(write=False)
    return normals


def log_to_linear(light: LogHarmonics) -> LinearHarmonics:
    """Return the linear harmonics whose B(N) . L is nearest to the light's shading.

    Linear least squares over `visible_normals`, before the clamp at zero.

    Parameters
    ----------
    light : LogHarmonics
        Coefficients of shape (9,) or (9, 3).

    Returns
    -------
    LinearHarmonics
        Coefficients of the same shape.

    Examples
    --------
    >>> gray = LogHarmonics(np.zeros(9))
    >>> (log_to_linear(gray).coefficients.round(3) + 0.0).tolist()
    [1.128, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    """
    normals = visible_normals()
    coefficients, *_ = np.linalg.lstsq(harmonics(normals), light.shade(normals), rcond=None)
    return LinearHarmonics(np.asarray(coefficients, dtype=np.float64))


def linear_to_log(light: LinearHarmonics) -> LogHarmonics:
    """Return the log harmonics whose shading is nearest to the light's clamped shading.

    Nonlinear least squares of the shading itself over `visible_normals`. Fitting log shading
    would be linear, but where the clamp makes the shading zero it needs a floor, and the darkest,
    least visible directions would then decide the fit. Scaling the light adds a constant to the
    first coefficient and changes nothing else.

    Parameters
    ----------
    light : LinearHarmonics
        Coefficients of shape (9,) or (9, 3).

    Returns
    -------
    LogHarmonics
        Coefficients of the same shape.

    Raises
    ------
    RelightlabError
        If a channel is dark on every visible normal.

    Examples
    --------
    >>> constant = LinearHarmonics(np.array([2.0 / 0.886227, 0, 0, 0, 0, 0, 0, 0, 0]))
    >>> light = linear_to_log(constant)
    >>> light.shade(np.array([[[0.0, 0.6, 0.8]]])).round(6)
    array([[2.]])
    """
    normals = visible_normals()
    shading = light.shade(normals)
    if shading.ndim == 1:
        return LogHarmonics(fit_log_coefficients(normals, shading))
    channels = [fit_log_coefficients(normals, channel) for channel in shading.T]
    return LogHarmonics(np.stack(channels, axis=-1))


def fit_log_coefficients(normals: Normals, shading: Float) -> Float:
    """Return the nine L that minimise sum (exp(B(N) . L) - shading)^2.

    Parameters
    ----------
    normals : (n, 3) array
        Unit normals, finite.
    shading : (n,) array
        At least zero.

    Returns
    -------
    (9,) array

    Raises
    ------
    RelightlabError
        If the shading is nowhere positive.

    Examples
    --------
    >>> truth = np.array([-1.0, 0.5, 0.3, 0.2, 0.1, 0.0, -0.1, 0.0, 0.2])
    >>> shading = LogHarmonics(truth).shade(visible_normals())
    >>> bool(np.allclose(fit_log_coefficients(visible_normals(), shading), truth, atol=1e-9))
    True
    """
    brightest = shading.max()
    if not brightest > 0:
        raise RelightlabError("the light is dark on every visible normal: give one that shades")
    relative = shading / brightest
    basis = harmonics(normals)
    start, *_ = np.linalg.lstsq(basis, np.log(np.maximum(relative, _STARTING_FLOOR)), rcond=None)

    def residual(coefficients: Float) -> Float:
        difference: Float = np.exp(basis @ coefficients) - relative
        return difference

    def jacobian(coefficients: Float) -> Float:
        derivative: Float = np.exp(basis @ coefficients)[:, None] * basis
        return derivative

    fit = least_squares(residual, start, jac=jacobian, method="lm", xtol=1e-12, ftol=1e-12)
    coefficients: Float = fit.x
    coefficients[0] += math.log(brightest) / C4
    return coefficients


def rotate(illumination: Harmonics, rotation: Float) -> Harmonics:
    """Return the illumination turned by `rotation`, exactly.

    ``rotate(light, R).shade(R n) == light.shade(n)`` for every normal n. The nine harmonics span
    all quadratic polynomials on the sphere, a space every rotation maps onto itself.

    Parameters
    ----------
    illumination : LogHarmonics or LinearHarmonics
        Coefficients of shape (9,) or (9, 3).
    rotation : (3, 3) array
        Rotation matrix acting on column vectors (x right, y up, z toward the viewer).

    Returns
    -------
    LogHarmonics or LinearHarmonics
        Of the type given.

    Raises
    ------
    RelightlabError
        If `rotation` is not a rotation matrix.

    Examples
    --------
    >>> quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # right to up
    >>> from_the_right = LinearHarmonics(np.eye(9)[3])
    >>> (rotate(from_the_right, quarter).coefficients.round(9) + 0.0).tolist()
    [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    """
    matrix = _rotation_of_coefficients(_check_rotation(rotation))
    return type(illumination)(matrix @ illumination.coefficients)


def rotation_about_vertical(angle: float) -> Float:
    """Return the rotation about the y axis that turns the viewer's direction z toward x.

    Parameters
    ----------
    angle : float
        Radians.

    Returns
    -------
    (3, 3) array

    Examples
    --------
    >>> (rotation_about_vertical(np.pi / 2) @ [0.0, 0.0, 1.0]).round(9) + 0.0
    array([1., 0., 0.])
    """
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])


def _rotation_of_coefficients(rotation: Float) -> Float:
    """Return M with B(R^T n) = B(n) M, found on both halves of a spread of normals."""
    front = visible_normals(64)
    normals = np.concatenate([front, -front])
    matrix, *_ = np.linalg.lstsq(harmonics(normals), harmonics(normals @ rotation), rcond=None)
    return np.asarray(matrix, dtype=np.float64)


def _check_rotation(rotation: Float) -> Float:
    checked = np.asarray(rotation, dtype=np.float64)
    if checked.shape != (3, 3):
        raise RelightlabError(f"expected a rotation of shape (3, 3), got {checked.shape}")
    orthonormal = np.allclose(checked @ checked.T, np.eye(3), rtol=0, atol=1e-9)
    if not orthonormal or np.linalg.det(checked) < 0:
        raise RelightlabError("expected a rotation matrix (orthonormal, determinant +1)")
    return checked
