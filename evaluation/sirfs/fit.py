"""Fitting SIRFS to a photograph."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from evaluation.sirfs.priors import SirfsPriors
from evaluation.sirfs.result import SirfsFit
from shading_model.arrays import Float, Image, Map, Mask
from shading_model.illumination import LogHarmonics

FitProgress = Callable[[float, float, float], None]
"""Called with evaluations done, evaluations at most, and the loss."""


@dataclass(frozen=True, eq=False)
class FitOptions:
    """How a photograph is fitted.

    Parameters
    ----------
    light : {"laboratory", "natural"}
        Which lights are likely.
    channels : {"color", "gray"}
    without : tuple of str
        Terms of `evaluation.sirfs.settings.TERMS` that are left out.
    known_height : (h, w) array, optional
        The shape, if it is known: only the light is fitted.
    known_light : LogHarmonics, optional
        The light, if it is known: only the shape is fitted.
    depth : (h, w) array, optional
        An external depth map, NaN where unknown, that the shape is drawn to.
    depth_blur : float
        Width in pixels of the blur that relates the shape to `depth`.
    """

    light: str = "laboratory"
    channels: str = "color"
    without: tuple[str, ...] = ()
    known_height: Map | None = None
    known_light: LogHarmonics | None = None
    depth: Float | None = None
    depth_blur: float = 0.0


def fit_sirfs(
    image: Image,
    mask: Mask,
    priors: SirfsPriors,
    options: FitOptions = FitOptions(),
    *,
    outline: Mask | None = None,
    progress: FitProgress | None = None,
) -> SirfsFit:
    """Fit shape, albedo, shading and light to one photograph."""
    raise NotImplementedError
