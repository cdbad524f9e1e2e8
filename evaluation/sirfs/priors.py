"""What SIRFS learned from its training objects and lights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from evaluation.sirfs.light_prior import LightPrior
from evaluation.sirfs.scale_mixture import ScaleMixture
from shading_model.arrays import Float


@dataclass(frozen=True, eq=False)
class SirfsPriors:
    """The learned part of the loss.

    Parameters
    ----------
    curvature : ScaleMixture
        Of differences of mean curvature between neighbours, 1/pixels.
    gray_difference : ScaleMixture
        Of differences of gray log albedo between neighbours.
    color_difference : ScaleMixture
        The same in colour, with a (3, 3) covariance of determinant one.
    gray_absolute : (256,) array
        Cost of a gray log albedo at `scale of knots`: 256 knots evenly in [-7, 4], least is 0.
    color_whitening : (3, 3) array
        W: log albedo as row vectors times W is white.
    color_absolute : (102, 102, 102) array
        Cost of whitened log albedo at knots evenly in [-7, 4] along each axis, least is 0.
    lights : mapping of (light, channels) to LightPrior
    """

    curvature: ScaleMixture
    gray_difference: ScaleMixture
    color_difference: ScaleMixture
    gray_absolute: Float
    color_whitening: Float
    color_absolute: Float
    lights: Mapping[tuple[str, str], LightPrior]
