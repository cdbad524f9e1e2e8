"""The pull of an external depth map on the shape."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import convolve1d

from shading_model.arrays import Float, Mask
from shading_model.errors import RelightlabError

DEPTH_FLOOR = 0.01
_SHARE = 0.1
_REACH = 3.0


@dataclass(frozen=True, eq=False)
class DepthTerm:
    """``weight / 10 * mean ((G Z - Z_0)^2 + floor^2)^(power / 2)`` over the known pixels.

    Parameters
    ----------
    depth : (h, w) array
        Z_0 in pixels, larger is nearer; NaN where unknown.
    weight, power : float
    blur : float
        Width of G, a normalised ``exp(-(x / blur)^2)``, in pixels; zero leaves the shape as it is.

    Raises
    ------
    RelightlabError
        If the depth is known nowhere, or the blur is negative.

    Examples
    --------
    >>> term = DepthTerm(np.array([[1.0, np.nan]]), weight=10.0, power=2.0)
    >>> round(term.add(np.array([[3.0, 5.0]]), np.zeros((1, 2))), 4)
    4.0001
    """

    depth: Float
    weight: float
    power: float
    blur: float = 0.0

    def __post_init__(self) -> None:
        if not np.isfinite(self.depth).any():
            raise RelightlabError("the external depth is known nowhere: give one with some depths")
        if not self.blur >= 0:
            raise RelightlabError(f"expected a depth blur of at least 0 pixels, got {self.blur:g}")

    @property
    def known(self) -> Mask:
        """Where the depth is known, (h, w)."""
        known: Mask = np.isfinite(self.depth)
        return known

    def add(self, height: Float, by_height: Float) -> float:
        """Return the term, and add its gradient.

        Parameters
        ----------
        height, by_height : (h, w) arrays
        """
        known = self.known
        away = np.where(known, self._blurred(height) - np.where(known, self.depth, 0.0), 0.0)
        squared = away**2 + DEPTH_FLOOR**2
        scale = _SHARE * self.weight / known.sum()
        slope = np.where(known, scale * self.power * away * squared ** (self.power / 2 - 1), 0.0)
        by_height += self._blurred_back(slope)
        return float(scale * np.sum(squared[known] ** (self.power / 2)))

    def _blurred(self, values: Float) -> Float:
        if not self.blur:
            return values
        return self._filtered(values) / self._filtered(np.ones_like(values))

    def _blurred_back(self, values: Float) -> Float:
        if not self.blur:
            return values
        return self._filtered(values / self._filtered(np.ones_like(values)))

    def _filtered(self, values: Float) -> Float:
        reach = max(math.ceil(_REACH * self.blur), 1)
        kernel = np.exp(-((np.arange(-reach, reach + 1) / self.blur) ** 2))
        once = convolve1d(values, kernel, axis=0, mode="constant")
        twice: Float = convolve1d(once, kernel, axis=1, mode="constant")
        return twice
