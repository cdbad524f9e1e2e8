"""Illumination fitted to a shading on a known shape (`eq:argminL`)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares, nnls

from shading_model.arrays import Float, Map, Mask, Normals, check_map
from shading_model.errors import RelightlabError
from shading_model.illumination import LinearHarmonics, PointLights, harmonics, surface_points

START_DIRECTIONS = np.array(
    [[0.0, 0.0, 1.0], [1.0, 0.0, 0.5], [-1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.0, -1.0, 0.5]]
)
"""The paper starts its five sources in front of the object and on its four sides."""
START_DISTANCE = 3.0
CLEARANCE = 1.2
"""Sources stay outside this many radii of the object's bounding sphere."""
SAMPLED_PIXELS = 3000
MAX_EVALUATIONS = 60
TOLERANCE = 1e-5


@dataclass(frozen=True, eq=False)
class PointLightFit:
    """Five point sources fitted to a shading.

    Parameters
    ----------
    illumination : PointLights
    root_mean_square : float
        Of the residual over all pixels.
    evaluations : int
        Evaluations of the Jacobian.
    """

    illumination: PointLights
    root_mean_square: float
    evaluations: int


def fit_point_lights(shading: Map, normals: Normals, height: Map) -> PointLightFit:
    """Return the five point sources that best explain a shading (`eq:argminL`, 20 parameters).

    A trust-region Gauss-Newton search with the analytic Jacobian on a regular sample of about
    `SAMPLED_PIXELS` pixels; the intensities, in which the shading is linear, are then set by
    non-negative least squares on all of them. Cost beyond that last step does not grow with the
    number of pixels.

    Parameters
    ----------
    shading : (h, w) array
        NaN outside the mask.
    normals : (h, w, 3) array
    height : (h, w) array
        Pixels.

    Raises
    ------
    RelightlabError
        If the maps differ in size or no pixel has both a shading and a normal.
    """
    inside = _common_pixels(shading, normals, height)
    frame = _Frame.of(surface_points(height)[inside])
    points, facing, target = frame.points, normals[inside], shading[inside]
    chosen = np.arange(0, len(target), max(1, len(target) // SAMPLED_PIXELS))
    sample = PointLightProblem(points[chosen], facing[chosen], target[chosen], frame.clearance)
    solution = least_squares(
        sample.residual,
        sample.start(),
        sample.jacobian,
        # MINPACK ("lm") depends in its last bits on where its arrays happen to lie in memory.
        method="trf",
        x_scale="jac",
        max_nfev=MAX_EVALUATIONS,
        xtol=TOLERANCE,
        ftol=TOLERANCE,
        gtol=1e-12,
    )
    positions, _ = sample.lights(solution.x)
    columns = np.stack([unit_shading(points, facing, p)[0] for p in positions], axis=-1)
    strengths, residual_norm = nonnegative_least_squares(columns, target)
    return PointLightFit(
        frame.to_pixels(positions, strengths),
        residual_norm / np.sqrt(len(target)),
        int(solution.njev or 0),
    )


@dataclass(frozen=True, eq=False)
class HarmonicFit:
    """Nine linear spherical harmonics fitted to a shading.

    Parameters
    ----------
    illumination : LinearHarmonics
    root_mean_square : float
        Of the residual over all pixels.
    """

    illumination: LinearHarmonics
    root_mean_square: float


def fit_harmonics(shading: Map, normals: Normals) -> HarmonicFit:
    """Return the nine linear harmonics that best explain a shading, by least squares.

    The clamp at zero plays no part in the fit; coefficients that the visible normals leave
    undetermined are those of minimum norm.

    Parameters
    ----------
    shading : (h, w) array
        NaN outside the mask.
    normals : (h, w, 3) array

    Raises
    ------
    RelightlabError
        As `fit_point_lights`.
    """
    inside = _common_pixels(shading, normals, shading)
    basis = harmonics(normals[inside])
    target = shading[inside]
    # The normal equations need one pass over the pixels; their rank cut keeps them stable.
    gram = basis.T @ basis
    coefficients = np.linalg.pinv(gram, rcond=1e-10, hermitian=True) @ (basis.T @ target)
    illumination = LinearHarmonics(coefficients)
    residual = target - illumination.shade(normals[inside])
    return HarmonicFit(illumination, float(np.sqrt(np.mean(residual**2))))


def nonnegative_least_squares(columns: Float, target: Float) -> tuple[Float, float]:
    """Return x >= 0 minimising ``|columns x - target|``, and that norm, from the Gram matrix.

    Examples
    --------
    >>> nonnegative_least_squares(np.eye(2), np.array([3.0, -1.0]))
    (array([3., 0.]), 1.0)
    """
    scale = np.linalg.norm(columns, axis=0)
    scaled = columns / np.where(scale > 0, scale, 1.0)
    # The triangular factor has the same normal equations as the tall matrix.
    orthogonal, triangular = np.linalg.qr(scaled)
    solution, _ = nnls(triangular, orthogonal.T @ target)
    solution = np.where(scale > 0, solution / np.where(scale > 0, scale, 1.0), 0.0)
    return solution, float(np.linalg.norm(columns @ solution - target))


@dataclass(frozen=True, eq=False)
class PointLightProblem:
    """Residual and Jacobian of `eq:argminL` in coordinates in which nothing is singular.

    A source has four parameters (q, a): its position is ``p = q sqrt(1 + c^2 / |q|^2)``, always
    farther than the clearance c from the object's centre, and its irradiance at the centre is
    ``a^2``, never negative.

    Parameters
    ----------
    points, normals : (n, 3) arrays
        Surface in units of the object's radius, from its centre.
    target : (n,) array
    clearance : float
    """

    points: Float
    normals: Float
    target: Float
    clearance: float

    def start(self) -> Float:
        """Return the paper's start, (20,): frontal and four sides, equal strengths."""
        directions = START_DIRECTIONS / np.linalg.norm(START_DIRECTIONS, axis=1, keepdims=True)
        start = np.column_stack([directions * START_DISTANCE * self.clearance, np.ones(5)])
        positions, _ = self.lights(start.ravel())
        total = sum(unit_shading(self.points, self.normals, p)[0] for p in positions)
        start[:, 3] = np.sqrt(max(self.target.mean(), 1e-12) / max(np.mean(total), 1e-12))
        return start.ravel()

    def lights(self, parameters: Float) -> tuple[Float, Float]:
        """Return positions (m, 3) and irradiances at the centre (m,)."""
        q, a = parameters.reshape(-1, 4)[:, :3], parameters[3::4]
        return q * self._stretch(q)[:, None], a**2

    def residual(self, parameters: Float) -> Float:
        """Return shade - S, shape (n,)."""
        shaded = -self.target
        for position, irradiance in zip(*self.lights(parameters), strict=True):
            shaded = shaded + irradiance * unit_shading(self.points, self.normals, position)[0]
        return shaded

    def jacobian(self, parameters: Float) -> Float:
        """Return the derivative of `residual`, shape (n, 4 m)."""
        blocks = []
        for q, a in zip(parameters.reshape(-1, 4)[:, :3], parameters[3::4], strict=True):
            stretch = self._stretch(q[None])[0]
            shaded, by_position = unit_shading(self.points, self.normals, q * stretch)
            length = q @ q
            inner = stretch * np.eye(3) - np.outer(q, q) * (
                self.clearance**2 / (length**2 * stretch)
            )
            blocks += [a**2 * by_position @ inner, 2 * a * shaded[:, None]]
        return np.concatenate(blocks, axis=1)

    def _stretch(self, q: Float) -> Float:
        stretch: Float = np.sqrt(1 + self.clearance**2 / np.einsum("ij,ij->i", q, q))
        return stretch


def unit_shading(points: Float, normals: Float, position: Float) -> tuple[Float, Float]:
    """Return the shading by a source of irradiance one at the origin, and its derivative.

    ``f = |p|^2 max(0, N . u) / |u|^3`` with ``u = p - x``.

    Parameters
    ----------
    points, normals : (n, 3) arrays
    position : (3,) array

    Returns
    -------
    (n,) array and (n, 3) array
        f and df/dp.
    """
    to_light = position - points
    inverse = 1 / np.sqrt(np.einsum("ij,ij->i", to_light, to_light))
    cosine = np.maximum(np.einsum("ij,ij->i", normals, to_light), 0.0)
    squared = position @ position
    cube = inverse**3
    falloff = cosine * cube
    lit = (cosine > 0) * cube * squared
    derivative = lit[:, None] * normals
    derivative -= (3 * squared * falloff * inverse**2)[:, None] * to_light
    derivative += falloff[:, None] * (2 * position)
    return squared * falloff, derivative


@dataclass(frozen=True, eq=False)
class _Frame:
    """Surface points about their centre in units of their bounding radius."""

    points: Float
    centre: Float
    radius: float
    clearance: float = CLEARANCE

    @classmethod
    def of(cls, points: Float) -> _Frame:
        centre = (points.min(axis=0) + points.max(axis=0)) / 2
        shifted = points - centre
        radius = max(float(np.sqrt(np.einsum("ij,ij->i", shifted, shifted).max())), 1.0)
        return cls(shifted / radius, centre, radius)

    def to_pixels(self, positions: Float, strengths: Float) -> PointLights:
        distance = np.einsum("ij,ij->i", positions, positions)
        return PointLights(
            positions * self.radius + self.centre, strengths * distance * self.radius**2
        )


def _common_pixels(shading: Map, normals: Normals, height: Map) -> Mask:
    everywhere = np.ones(shading.shape, dtype=bool)
    check_map(normals, everywhere, "normals", channels=3)
    check_map(height, everywhere, "heights")
    inside: Mask = np.isfinite(shading) & np.isfinite(normals).all(axis=-1) & np.isfinite(height)
    if not inside.any():
        raise RelightlabError("no pixel has both a shading and a normal: are the masks the same?")
    return inside
