"""Parsimony and absolute cost of log albedo, both functions of its histogram."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from evaluation.sirfs.histogram_kernels import (
    add_color_slopes,
    add_slopes,
    occupied_box,
    splat,
    splat_color,
)
from evaluation.sirfs.regions import Runs
from shading_model.arrays import Float

FIRST_KNOT, LAST_KNOT = -7.0, 4.0
"""Where the histograms of log albedo begin and end."""
_REACH = 6.0
"""The kernel of the entropy is cut off after so many standard deviations."""


@dataclass(frozen=True, eq=False)
class HistogramCost:
    """Entropy and absolute cost of the log albedo of n pixels.

    With the histogram q, the entropy is ``-log sum q (q * k)`` with the Gaussian kernel
    ``k(x) = exp(-x^2 / (4 sigma^2)) / n^2``, and the absolute cost ``sum q F / (8 n)``.

    Parameters
    ----------
    absolute : (k,) or (k, k, k) array
        F at the knots, as many as the histogram has.
    sigma : float
        Width of the kernel.
    entropy, absolute_weight : float
        Weights of the two.
    count : int
        n.
    """

    absolute: Float
    sigma: float
    entropy: float
    absolute_weight: float
    count: int

    @property
    def spacing(self) -> float:
        """Distance between knots."""
        return (LAST_KNOT - FIRST_KNOT) / (len(self.absolute) - 1)

    def gray(self, albedo: Float, runs: Runs, gradient: Float) -> tuple[float, float]:
        """Return both weighted costs of gray log albedo, and add their gradient.

        Parameters
        ----------
        albedo, gradient : (h, w) arrays
        runs : (r, 3) array
        """
        histogram = np.zeros(len(self.absolute))
        splat(albedo, runs, FIRST_KNOT, self.spacing, histogram)
        smooth = self._smoothing(histogram.size) @ histogram
        losses, potential = self._losses(histogram, smooth, self.absolute)
        add_slopes(albedo, runs, FIRST_KNOT, self.spacing, potential, gradient)
        return losses

    def color(self, white: Float, runs: Runs, gradient: Float) -> tuple[float, float]:
        """Return both weighted costs of white log albedo, and fill their gradient on the runs.

        Parameters
        ----------
        white, gradient : (3, h, w) arrays
        runs : (r, 3) array
        """
        knots, first, spacing = len(self.absolute), FIRST_KNOT, self.spacing
        box = occupied_box(white, runs, first, spacing, knots)
        corner = np.ascontiguousarray(box[:, 0])
        histogram = np.zeros(tuple(box[:, 1] - box[:, 0]))
        splat_color(white, runs, first, spacing, knots, corner, histogram)
        smooth = histogram
        for axis in range(3):
            kernel = self._smoothing(smooth.shape[axis], 3)
            smooth = np.moveaxis(np.tensordot(kernel, smooth, (1, axis)), 0, axis)
        inside = self.absolute[tuple(slice(*ends) for ends in box)]
        losses, potential = self._losses(histogram, smooth, inside)
        add_color_slopes(white, runs, first, spacing, knots, corner, potential, gradient)
        return losses

    def _smoothing(self, size: int, axes: int = 1) -> Float:
        """Return the convolution with the kernel as a banded (size, size) matrix."""
        distance = np.abs(np.subtract.outer(np.arange(size), np.arange(size)))
        kernel = np.exp(-((distance * self.spacing) ** 2) / (4 * self.sigma**2))
        kernel[distance > math.ceil(_REACH * self.sigma / self.spacing)] = 0.0
        scaled: Float = kernel / self.count ** (2 / axes)
        return scaled

    def _losses(
        self, histogram: Float, smooth: Float, absolute: Float
    ) -> tuple[tuple[float, float], Float]:
        together = float(np.vdot(histogram, smooth))
        share = self.absolute_weight / (8 * self.count)
        losses = -self.entropy * math.log(together), share * float(np.vdot(histogram, absolute))
        potential = np.ascontiguousarray(
            share * absolute - (2 * self.entropy / together) * smooth, dtype=np.float64
        )
        return losses, potential
