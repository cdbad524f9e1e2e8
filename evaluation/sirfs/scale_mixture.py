"""Gaussian scale mixtures: heavy-tailed densities of differences between neighbours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shading_model.arrays import Float
from shading_model.errors import RelightlabError

SCALES = 40
NUMBER_KNOTS = 20_000
COLOR_KNOTS = 100_000
ROUNDS = 200
"""Steps of expectation and maximisation."""
SHAPE_ROUNDS = 10
"""In colour, steps of the weights between two of the shape."""


@dataclass(frozen=True, eq=False)
class CostTable:
    """A cost at ``start + spacing * [0, 1, ...]``; beyond its ends it goes on straight.

    Parameters
    ----------
    values : (knots,) array
    start, spacing : float
    """

    values: Float
    start: float
    spacing: float


@dataclass(frozen=True, eq=False)
class ScaleMixture:
    """A mixture of K zero-mean Gaussians of fixed scales.

    Parameters
    ----------
    weights, scales : (K,) arrays
        a_k, which sum to one, and s_k.
    largest : float
        Where tables end. For numbers the largest |x| of the training data; for colours their
        largest *half squared length* m = ||W x||^2 / 2, the argument of `cost`.
    covariance : (3, 3) array, optional
        Shape of the Gaussians in colour, s_k^2 times this, determinant one; None for numbers.
    """

    weights: Float
    scales: Float
    largest: float
    covariance: Float | None = None

    @property
    def precision_root(self) -> Float:
        """W = covariance^(-1/2), symmetric, (3, 3); of the identity for a mixture of numbers."""
        return inverse_root(np.eye(1) if self.covariance is None else self.covariance)

    def log_density(self, half_squared_lengths: Float) -> Float:
        """Return log p at half squared lengths m = ||W x||^2 / 2, x^2 / 2 for numbers x."""
        m = np.asarray(half_squared_lengths, dtype=np.float64)[..., None]
        with np.errstate(divide="ignore"):  # a weight that came down to zero
            heights = np.log(self.weights) - self._dimensions * np.log(self.scales)
        exponents = heights - m / self.scales**2
        top = exponents.max(axis=-1, keepdims=True)
        total = np.log(np.exp(exponents - top).sum(axis=-1)) + top[..., 0]
        density: Float = total - 0.5 * self._dimensions * np.log(2 * np.pi)
        return density

    def cost(self, values: Float) -> Float:
        """Return c(x) = log p(0) - log p(x): zero at zero, positive elsewhere.

        Of numbers x; of colours, given by their half squared lengths m = ||W x||^2 / 2.
        """
        given = np.asarray(values, dtype=np.float64)
        m = 0.5 * given**2 if self.covariance is None else given
        cost: Float = self.log_density(np.zeros(())) - self.log_density(m)
        return cost

    def cost_table(self, knots: int | None = None) -> CostTable:
        """Return the cost at equally spaced knots over [-largest, largest], in colour from 0 on.

        Parameters
        ----------
        knots : int, optional
            By default 20000 for numbers and 100000 for colours.
        """
        in_color = self.covariance is not None
        count = knots or (COLOR_KNOTS if in_color else NUMBER_KNOTS)
        start = 0.0 if in_color else -self.largest
        places = np.linspace(start, self.largest, count)
        return CostTable(self.cost(places), start, (self.largest - start) / (count - 1))

    @property
    def _dimensions(self) -> int:
        return 1 if self.covariance is None else 3


def fit_scale_mixture(samples: Float, scales: int = SCALES, rounds: int = ROUNDS) -> ScaleMixture:
    """Fit the weights of a mixture, and in colour its shape, by expectation and maximisation.

    The scales stay where they are put: evenly in their logarithm, from a thousandth of the mean
    length of the samples to three times the largest. The weights start uniform.

    In colour the shape is fitted in turn with the weights, by maximum likelihood: a sample counts
    by the inverse square of the scale it comes from, so that the shape is that of all differences
    and not of the few largest, as that of plain second moments would be.

    Parameters
    ----------
    samples : (n,) or (n, 3) array
    scales : int
        K.
    rounds : int
        Steps of the weights.

    Returns
    -------
    ScaleMixture

    Raises
    ------
    RelightlabError
        If the shape is another, there are no samples, one is not finite, all are zero, or
        those of colours lie in a plane.

    Examples
    --------
    >>> mixture = fit_scale_mixture(np.random.default_rng(0).laplace(size=5000))
    >>> bool(abs(mixture.cost(np.array(2.0)) - 2) < 0.3)
    True
    """
    given = _checked(samples)
    if given.shape[1] == 1:
        lengths = np.abs(given[:, 0])
        grid = _scale_grid(lengths, scales)
        weights = _better_weights(0.5 * lengths**2, grid, np.full(scales, 1 / scales), rounds, 1)
        return ScaleMixture(weights, grid, float(lengths.max()))
    return _fit_color(given, scales, rounds)


def _fit_color(samples: Float, scales: int, rounds: int) -> ScaleMixture:
    covariance = _unit_determinant(samples.T @ samples)
    m = _half_squared_lengths(samples, covariance)
    grid, weights = _scale_grid(np.sqrt(2 * m), scales), np.full(scales, 1 / scales)
    for done in range(0, rounds, SHAPE_ROUNDS):
        weights = _better_weights(m, grid, weights, min(SHAPE_ROUNDS, rounds - done), 3)
        precision = _mean_precision(m, grid, weights)
        covariance = _unit_determinant((samples * precision[:, None]).T @ samples)
        m = _half_squared_lengths(samples, covariance)
    return ScaleMixture(weights, grid, float(m.max()), covariance)


def inverse_root(matrix: Float, padding: float = 0.0) -> Float:
    """Return V diag(1 / sqrt(D + padding)) V^T of a symmetric matrix V diag(D) V^T.

    Parameters
    ----------
    matrix : (n, n) array
        Symmetric, positive definite unless padded.
    padding : float

    Returns
    -------
    (n, n) array
        Symmetric.

    Examples
    --------
    >>> inverse_root(np.diag([4.0, 0.0]), 0.25).round(3)
    array([[0.485, 0.   ],
           [0.   , 2.   ]])
    """
    values, vectors = np.linalg.eigh(matrix)
    root: Float = (vectors / np.sqrt(np.maximum(values, 0.0) + padding)) @ vectors.T
    return root


def _checked(samples: Float) -> Float:
    given = np.asarray(samples, dtype=np.float64)
    columns = given[:, None] if given.ndim == 1 else given
    if columns.ndim != 2 or columns.shape[1] not in {1, 3}:
        raise RelightlabError(f"expected samples of shape (n,) or (n, 3), got {given.shape}")
    if not len(columns):
        raise RelightlabError("there are no samples to fit a mixture to")
    if not np.isfinite(columns).all():
        raise RelightlabError("the samples of a mixture contain NaN or infinite values")
    if not columns.any():
        raise RelightlabError("all samples of a mixture are zero: it has no scale")
    if np.linalg.matrix_rank(columns.T @ columns) < columns.shape[1]:
        raise RelightlabError("the samples of a mixture lie in a plane: it has no shape")
    return columns


def _scale_grid(lengths: Float, count: int) -> Float:
    return np.geomspace(lengths.mean() / 1000, 3 * lengths.max(), count)


def _half_squared_lengths(samples: Float, covariance: Float) -> Float:
    half: Float = 0.5 * ((samples @ inverse_root(covariance)) ** 2).sum(axis=1)
    return half


def _unit_determinant(matrix: Float) -> Float:
    scaled: Float = matrix / np.cbrt(np.linalg.det(matrix))
    return scaled


def _component_densities(m: Float, scales: Float, dimensions: int) -> Float:
    """Return N(x; 0, s_k^2) up to a factor of each sample, which cancels in every use."""
    exponents = -m[:, None] / scales**2 - dimensions * np.log(scales)
    densities: Float = np.exp(exponents - exponents.max(axis=1, keepdims=True))
    return densities


def _better_weights(m: Float, scales: Float, weights: Float, rounds: int, dimensions: int) -> Float:
    densities = _component_densities(m, scales, dimensions)
    for _ in range(rounds):
        weights = weights * ((1 / (densities @ weights)) @ densities) / len(m)
    better: Float = weights / weights.sum()
    return better


def _mean_precision(m: Float, scales: Float, weights: Float) -> Float:
    """Return the expected 1 / s^2 of the component that each sample comes from."""
    shares = _component_densities(m, scales, 3) * weights
    precision: Float = (shares @ scales**-2.0) / shares.sum(axis=1)
    return precision
