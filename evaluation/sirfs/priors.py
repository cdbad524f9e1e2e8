"""What SIRFS learned from its training objects and lights."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets.array_archive import npy_bytes
from evaluation.sirfs.light_prior import LightPrior
from evaluation.sirfs.scale_mixture import ScaleMixture
from shading_model.arrays import Float

MIXTURES = ("curvature", "gray_difference", "color_difference")
ABSOLUTE = ("gray_absolute", "color_whitening", "color_absolute")


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
        Cost of a gray log albedo at 256 knots evenly in [-7, 4]; the least is 0.
    color_whitening : (3, 3) array
        W: log albedo as row vectors times W is white.
    color_absolute : (102, 102, 102) array
        Cost of whitened log albedo at knots evenly in [-7, 4] along each axis; the least is 0.
    lights : mapping of (light, channels) to LightPrior
        Such as ``("natural", "color")``.
    """

    curvature: ScaleMixture
    gray_difference: ScaleMixture
    color_difference: ScaleMixture
    gray_absolute: Float
    color_whitening: Float
    color_absolute: Float
    lights: Mapping[tuple[str, str], LightPrior]


def arrays_of(priors: SirfsPriors) -> dict[str, NDArray[Any]]:
    """Return all numbers of priors by name, in a fixed order.

    Parameters
    ----------
    priors : SirfsPriors

    Returns
    -------
    dict of str to array
        The names are those of the fields, joined by dots: ``curvature.weights``.
    """
    arrays: dict[str, NDArray[Any]] = {}
    for name in MIXTURES:
        mixture: ScaleMixture = getattr(priors, name)
        parts = {"weights": mixture.weights, "scales": mixture.scales, "largest": mixture.largest}
        if mixture.covariance is not None:
            parts["covariance"] = mixture.covariance
        arrays |= {f"{name}.{part}": np.asarray(value) for part, value in parts.items()}
    arrays |= {name: np.asarray(getattr(priors, name)) for name in ABSOLUTE}
    for light, channels in sorted(priors.lights):
        prior = priors.lights[light, channels]
        parts = {"mean": prior.mean, "covariance": prior.covariance, "count": prior.count}
        arrays |= {f"light.{light}.{channels}.{k}": np.asarray(v) for k, v in parts.items()}
    return arrays


def priors_of(arrays: Mapping[str, NDArray[Any]]) -> SirfsPriors:
    """Return the priors whose numbers `arrays_of` gave.

    Parameters
    ----------
    arrays : mapping of str to array

    Returns
    -------
    SirfsPriors

    Raises
    ------
    KeyError, ValueError
        If one is missing or has another shape.
    """
    kinds = [tuple(n.split(".")[1:3]) for n in arrays if n.endswith(".mean")]
    lights = {
        (light, channels): LightPrior(
            arrays[f"light.{light}.{channels}.mean"],
            arrays[f"light.{light}.{channels}.covariance"],
            int(arrays[f"light.{light}.{channels}.count"]),
        )
        for light, channels in kinds
    }
    return SirfsPriors(
        curvature=_mixture(arrays, "curvature"),
        gray_difference=_mixture(arrays, "gray_difference"),
        color_difference=_mixture(arrays, "color_difference"),
        gray_absolute=arrays["gray_absolute"],
        color_whitening=arrays["color_whitening"],
        color_absolute=arrays["color_absolute"],
        lights=lights,
    )


def _mixture(arrays: Mapping[str, NDArray[Any]], name: str) -> ScaleMixture:
    return ScaleMixture(
        arrays[f"{name}.weights"],
        arrays[f"{name}.scales"],
        float(arrays[f"{name}.largest"]),
        arrays.get(f"{name}.covariance"),
    )


def priors_identity(priors: SirfsPriors) -> str:
    """Return the SHA-256 over all numbers of priors, in hexadecimal.

    Parameters
    ----------
    priors : SirfsPriors

    Returns
    -------
    str
        64 digits; the same for equal numbers, however they were stored.
    """
    digest = hashlib.sha256()
    for name, values in arrays_of(priors).items():
        digest.update(name.encode())
        digest.update(npy_bytes(np.asarray(values, dtype=np.float64)))
    return digest.hexdigest()
