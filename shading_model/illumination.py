"""Illuminations: spherical harmonics in two conventions and point lights.

A spherical-harmonic illumination has nine coefficients (one light colour, shape (9,)) or nine per
colour channel (shape (9, 3)), in the order and with the constants of Ramamoorthi and Hanrahan
(2001) on normals (x right, y up, z toward the viewer).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from shading_model.arrays import Float, Map, Normals
from shading_model.errors import RelightlabError

C1, C2, C3, C4, C5 = 0.429043, 0.511664, 0.743125, 0.886227, 0.247708


def harmonics(normals: Normals) -> Float:
    """Return the nine irradiance harmonics B(N).

    ``B = [c4, 2 c2 y, 2 c2 z, 2 c2 x, 2 c1 xy, 2 c1 yz, c3 z^2 - c5, 2 c1 xz, c1 (x^2 - y^2)]``
    (Ramamoorthi and Hanrahan 2001, eq. 13). NaN normals give NaN harmonics.

    Parameters
    ----------
    normals : (..., 3) array
        Unit normals.

    Returns
    -------
    (..., 9) array

    Examples
    --------
    >>> harmonics(np.array([0.0, 0.0, 1.0])).round(3)
    array([0.886, 0.   , 1.023, 0.   , 0.   , 0.   , 0.495, 0.   , 0.   ])
    """
    x, y, z = np.moveaxis(np.asarray(normals, dtype=np.float64), -1, 0)
    basis = np.empty((*x.shape, 9))
    basis[..., 0] = np.where(np.isnan(x), np.nan, C4)
    basis[..., 1] = 2 * C2 * y
    basis[..., 2] = 2 * C2 * z
    basis[..., 3] = 2 * C2 * x
    basis[..., 4] = 2 * C1 * x * y
    basis[..., 5] = 2 * C1 * y * z
    basis[..., 6] = C3 * z * z - C5
    basis[..., 7] = 2 * C1 * x * z
    basis[..., 8] = C1 * (x * x - y * y)
    return basis


class Illumination(Protocol):
    """Anything that shades a surface: spherical harmonics, point lights, or a user's own."""

    def shade(self, normals: Normals, height: Map) -> Float:
        """Return the shading, (h, w) for one light colour or (h, w, 3); NaN where normals are."""
        ...


def _check_coefficients(coefficients: Float) -> Float:
    checked = np.array(coefficients, dtype=np.float64)
    if checked.shape not in {(9,), (9, 3)}:
        raise RelightlabError(
            f"expected spherical-harmonic coefficients of shape (9,) or (9, 3), got {checked.shape}"
        )
    if not np.isfinite(checked).all():
        raise RelightlabError("the spherical-harmonic coefficients contain NaN or infinite values")
    checked.setflags(write=False)
    return checked


@dataclass(frozen=True, eq=False)
class LogHarmonics:
    """Log-shading in nine harmonics: ``shade(N) = exp(B(N) . L)``, the MIT-Berkeley convention.

    Parameters
    ----------
    coefficients : (9,) or (9, 3) array

    Examples
    --------
    >>> LogHarmonics(np.zeros(9)).shade(np.array([[[0.0, 0.0, 1.0]]]))
    array([[1.]])
    """

    coefficients: Float

    def __post_init__(self) -> None:
        object.__setattr__(self, "coefficients", _check_coefficients(self.coefficients))

    def shade(self, normals: Normals, height: Map | None = None) -> Float:  # noqa: ARG002
        """Return exp(B(N) . L), of shape (h, w) or (h, w, 3); `height` plays no part."""
        shading: Float = np.exp(harmonics(normals) @ self.coefficients)
        return shading

    def monochrome(self) -> LogHarmonics:
        """Return the light whose coefficients are the mean over the colour channels."""
        c = self.coefficients
        return self if c.ndim == 1 else LogHarmonics(c.mean(axis=-1))


@dataclass(frozen=True, eq=False)
class LinearHarmonics:
    """Irradiance in nine harmonics, clamped: ``shade(N) = max(0, B(N) . L)``.

    Parameters
    ----------
    coefficients : (9,) or (9, 3) array

    Examples
    --------
    >>> light = LinearHarmonics(np.eye(9)[2])
    >>> light.shade(np.array([[[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])).round(3)
    array([[1.023, 0.   ]])
    """

    coefficients: Float

    def __post_init__(self) -> None:
        object.__setattr__(self, "coefficients", _check_coefficients(self.coefficients))

    def shade(self, normals: Normals, height: Map | None = None) -> Float:  # noqa: ARG002
        """Return max(0, B(N) . L), of shape (h, w) or (h, w, 3); `height` plays no part."""
        shading: Float = np.maximum(harmonics(normals) @ self.coefficients, 0.0)
        return shading

    def monochrome(self) -> LinearHarmonics:
        """Return the light whose coefficients are the mean over the colour channels."""
        c = self.coefficients
        return self if c.ndim == 1 else LinearHarmonics(c.mean(axis=-1))


@dataclass(frozen=True, eq=False)
class PointLights:
    """A mixture of point sources with inverse-square falloff, the paper's L(theta).

    ``shade(p) = sum_m I_m max(0, N . d_m) / |p_m - p|^2`` with ``d_m`` the unit direction from
    surface point p to source m (`eq:argminL`). Positions are in pixels: x is the column, y is
    minus the row, z the height.

    Parameters
    ----------
    positions : (m, 3) array
        Pixels.
    intensities : (m,) array
        Shading times square pixels.

    Examples
    --------
    >>> light = PointLights(np.array([[0.0, 0.0, 10.0]]), np.array([100.0]))
    >>> light.shade(np.array([[[0.0, 0.0, 1.0]]]), np.zeros((1, 1)))
    array([[1.]])
    """

    positions: Float
    intensities: Float

    def __post_init__(self) -> None:
        positions = np.array(self.positions, dtype=np.float64)
        intensities = np.array(self.intensities, dtype=np.float64)
        if positions.ndim != 2 or positions.shape != (intensities.size, 3):
            raise RelightlabError(
                "expected positions of shape (m, 3) and intensities of shape (m,), got"
                f" {positions.shape} and {intensities.shape}"
            )
        positions.setflags(write=False)
        intensities.setflags(write=False)
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "intensities", intensities)

    def shade(self, normals: Normals, height: Map) -> Float:
        """Return the shading of shape (h, w); NaN where normals or height are."""
        points = surface_points(height)
        shading = np.zeros(height.shape)
        for position, intensity in zip(self.positions, self.intensities, strict=True):
            to_light = position - points
            squared = np.einsum("...i,...i->...", to_light, to_light)
            cosine = np.einsum("...i,...i->...", normals, to_light)
            shading += intensity * np.maximum(cosine, 0.0) / squared**1.5
        return shading


def surface_points(height: Map) -> Float:
    """Return the surface points (x = column, y = -row, z = height) in pixels.

    Examples
    --------
    >>> surface_points(np.array([[5.0, 6.0]]))[0, 1]
    array([ 1., -0.,  6.])
    """
    rows, columns = np.indices(height.shape, dtype=np.float64)
    return np.stack([columns, -rows, height], axis=-1)
