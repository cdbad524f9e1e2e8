"""Gaussian scale mixtures: heavy-tailed densities of differences between neighbours."""

from __future__ import annotations

from dataclasses import dataclass

from shading_model.arrays import Float


@dataclass(frozen=True, eq=False)
class ScaleMixture:
    """A mixture of K zero-mean Gaussians of fixed scales.

    Parameters
    ----------
    weights, scales : (K,) arrays
        a_k, which sum to one, and s_k.
    largest : float
        The largest |x| (or Mahalanobis length) of the training data: where tables end.
    covariance : (3, 3) array, optional
        Shape of the Gaussians in colour, s_k^2 times this, determinant one; None for numbers.
    """

    weights: Float
    scales: Float
    largest: float
    covariance: Float | None = None
