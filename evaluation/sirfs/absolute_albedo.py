"""How common a log albedo is: a smooth minus log density on a grid of knots, least is zero."""

from __future__ import annotations

import numpy as np

from shading_model.arrays import Float
from shading_model.errors import RelightlabError

LEAST, LARGEST = -7.0, 4.0
"""The ends of the knots, of gray log albedo and of each axis of whitened colour."""
GRAY_KNOTS = 256
GRAY_SMOOTHNESS = 32 / 256
_SOFTNESS = 1e-5
_STEPS = 200


def linear_splat(samples: Float, knots: int = GRAY_KNOTS) -> Float:
    """Return the histogram of numbers, each shared out between the two knots beside it.

    Parameters
    ----------
    samples : (n,) array
        Values beyond the ends count at the ends.
    knots : int

    Returns
    -------
    (knots,) array
        Sums to one.

    Raises
    ------
    RelightlabError
        If there are no samples or one is NaN.

    Examples
    --------
    >>> linear_splat(np.array([-7.0, 1.25]), 5)
    array([0.5, 0. , 0. , 0.5, 0. ])
    """
    given = checked_albedos(samples)
    places = np.clip((given - LEAST) * ((knots - 1) / (LARGEST - LEAST)), 0, knots - 1)
    below = np.minimum(places.astype(int), knots - 2)
    above = places - below
    counts = np.bincount(below, 1 - above, knots) + np.bincount(below + 1, above, knots)
    histogram: Float = counts / len(given)
    return histogram


def fit_gray_absolute(samples: Float, smoothness: float = GRAY_SMOOTHNESS) -> Float:
    """Return F, a smooth minus log density of gray log albedo at 256 knots.

    Minimises ``sum p F + log sum exp(-F) + smoothness * sum sqrt((F'')^2 + 1e-5)``, p the
    histogram of the samples and F'' the second differences: a convex problem, solved by damped
    Newton steps. The last term holds F piecewise straight, so it goes on rising where no sample
    fell.

    Parameters
    ----------
    samples : (n,) array
    smoothness : float

    Returns
    -------
    (256,) array
        Its least value is 0.

    Raises
    ------
    RelightlabError
        If there are no samples or one is NaN.

    Examples
    --------
    >>> cost = fit_gray_absolute(np.random.default_rng(0).normal(-1.0, 0.5, 5000))
    >>> round(float(gray_knots()[cost.argmin()]))
    -1
    """
    histogram = linear_splat(samples)
    second = np.diff(np.eye(GRAY_KNOTS), 2, axis=0)
    cost = 0.5 * (gray_knots() - samples.mean()) ** 2

    def loss(candidate: Float) -> float:
        bent = np.sqrt((second @ candidate) ** 2 + _SOFTNESS).sum()
        evidence = np.log(np.exp(-(candidate - candidate.min())).sum()) - candidate.min()
        return float(histogram @ candidate + evidence + smoothness * bent)

    current = loss(cost)
    for _ in range(_STEPS):
        step, expected = _newton_step(cost, histogram, second, smoothness)
        length = 1.0
        while loss(cost - length * step) > current - 1e-4 * length * expected and length > 1e-9:
            length /= 2
        cost = cost - length * step
        current = loss(cost)
        if expected < 1e-12:
            break
    lowered: Float = cost - cost.min()
    return lowered


def gray_knots() -> Float:
    """Return the 256 log albedos at which the gray cost is known.

    Returns
    -------
    (256,) array

    Examples
    --------
    >>> gray_knots()[[0, -1]]
    array([-7.,  4.])
    """
    return np.linspace(LEAST, LARGEST, GRAY_KNOTS)


def _newton_step(
    cost: Float, histogram: Float, second: Float, smoothness: float
) -> tuple[Float, float]:
    """Return the step to subtract, and how fast the loss falls along it."""
    density = np.exp(-(cost - cost.min()))
    density /= density.sum()
    bend = second @ cost
    length = np.sqrt(bend**2 + _SOFTNESS)
    gradient = histogram - density + smoothness * (second.T @ (bend / length))
    hessian = np.diag(density) - np.outer(density, density)
    hessian += smoothness * (second.T * (_SOFTNESS / length**3)) @ second
    # A constant added to F changes nothing; the last two terms make the step unique and tame.
    hessian += 1 / cost.size + 1e-10 * np.eye(cost.size)
    step = np.linalg.solve(hessian, gradient)
    return step, float(gradient @ step)


def checked_albedos(samples: Float) -> Float:
    """Return log albedos as an array of at least one, none of them NaN.

    Parameters
    ----------
    samples : (n,) or (n, 3) array

    Raises
    ------
    RelightlabError
        If there are none or one is NaN.

    Examples
    --------
    >>> checked_albedos(np.array([-1]))
    array([-1.])
    """
    given = np.asarray(samples, dtype=np.float64)
    if not given.size:
        raise RelightlabError("there are no log albedos to learn from")
    if np.isnan(given).any():
        raise RelightlabError("the log albedos to learn from contain NaN")
    return given
