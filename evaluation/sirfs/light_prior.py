"""The Gaussian of log-harmonic lights, and the coordinates in which it is round."""

from __future__ import annotations

from dataclasses import dataclass

from shading_model.arrays import Float


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
