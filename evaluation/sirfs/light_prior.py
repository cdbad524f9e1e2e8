"""The Gaussian of log-harmonic lights, and the coordinates in which it is round."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from evaluation.sirfs.scale_mixture import inverse_root
from shading_model.arrays import Float
from shading_model.errors import RelightlabError

PADDING = 0.01
"""Added to the variances before whitening."""


@dataclass(frozen=True, eq=False)
class LightPrior:
    """Mean and covariance of the coefficients of lights, in the project's axes.

    Parameters
    ----------
    mean : (9 c,) array
        Channel by channel: nine coefficients of the first colour, then of the next.
    covariance : (9 c, 9 c) array
        Unbiased.
    count : int
        Lights that it was estimated from.
    """

    mean: Float
    covariance: Float
    count: int


@dataclass(frozen=True, eq=False)
class LightWhitening:
    """Coordinates l of lights in which those of a prior are round: ``L = inverse @ l + mean``.

    Parameters
    ----------
    mean : (9 c,) array
    inverse, map : (9 c, 9 c) arrays
        ``l = map @ (L - mean)``; each is the other's inverse, and symmetric.
    """

    mean: Float
    inverse: Float
    map: Float


def light_prior(lights: Float) -> LightPrior:
    """Return the mean and the unbiased covariance of lights.

    Parameters
    ----------
    lights : (n, 9) or (n, 9, 3) array

    Returns
    -------
    LightPrior

    Raises
    ------
    RelightlabError
        If the shape is another, there are fewer than two lights, or one is not finite.

    Examples
    --------
    >>> prior = light_prior(np.stack([np.zeros(9), np.full(9, 2.0)]))
    >>> prior.mean[:2], prior.covariance[0, :2], prior.count
    (array([1., 1.]), array([2., 2.]), 2)
    """
    given = np.asarray(lights, dtype=np.float64)
    if given.ndim not in {2, 3} or given.shape[1:] not in {(9,), (9, 3)}:
        raise RelightlabError(f"expected lights of shape (n, 9) or (n, 9, 3), got {given.shape}")
    if len(given) < 2:
        raise RelightlabError(f"expected at least two lights to learn from, got {len(given)}")
    if not np.isfinite(given).all():
        raise RelightlabError("the lights to learn from contain NaN or infinite values")
    vectors = given if given.ndim == 2 else np.swapaxes(given, 1, 2).reshape(-1, 27)
    mean = vectors.mean(axis=0)
    centred = vectors - mean
    return LightPrior(mean, centred.T @ centred / (len(given) - 1), len(given))


def light_whitening(prior: LightPrior, padding: float = PADDING) -> LightWhitening:
    """Return the coordinates in which the lights of a prior are round and of unit mean square.

    ``map`` is ``V diag(1 / sqrt(D + padding)) V^T`` of the biased covariance ``C = V D V^T``,
    divided by the root mean square of the whitened lights, ``sqrt(trace(map^T C map) / n)``.

    Parameters
    ----------
    prior : LightPrior
    padding : float
        Added to the variances D, so that what hardly varies is not blown up.

    Returns
    -------
    LightWhitening

    Examples
    --------
    >>> whitening = light_whitening(LightPrior(np.zeros(9), np.eye(9), 100))
    >>> bool(np.allclose(whitening.map, np.eye(9) / np.sqrt(0.99)))
    True
    """
    biased = prior.covariance * ((prior.count - 1) / prior.count)
    root = inverse_root(biased, padding)
    mean_square = np.trace(root.T @ biased @ root) / len(biased)
    scaled = root / np.sqrt(mean_square)
    return LightWhitening(prior.mean, np.linalg.inv(scaled), scaled)
