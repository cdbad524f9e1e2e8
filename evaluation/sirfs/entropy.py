"""Parsimony and absolute cost of log albedo, both functions of its histogram."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evaluation.sirfs.color_histogram_kernels import (
    fill_color_slopes,
    locate,
    smoothed_histogram,
    splat_color,
)
from evaluation.sirfs.histogram_kernels import add_slopes, splat
from evaluation.sirfs.regions import Runs
from shading_model.arrays import Float

FIRST_KNOT, LAST_KNOT = -7.0, 4.0
"""Where the histograms of log albedo begin and end."""
_REACH = 6.0
"""The kernel of the entropy is cut off after so many standard deviations."""


@dataclass(frozen=True, eq=False)
class Places:
    """Where the colours of n pixels lie among the knots: scratch of `HistogramCost.color`."""

    cells: NDArray[np.int32]
    shares: Float

    @classmethod
    def of(cls, pixels: int) -> Places:
        """Return scratch for so many pixels."""
        return cls(np.zeros((3, pixels), np.int32), np.zeros((3, pixels)))


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
        smooth = np.convolve(histogram, self._kernel(1), mode="same")
        losses, potential = self._losses(histogram, smooth, self.absolute)
        add_slopes(albedo, runs, FIRST_KNOT, self.spacing, potential, gradient)
        return losses

    def color(
        self, white: Float, runs: Runs, places: Places, gradient: Float
    ) -> tuple[float, float]:
        """Return both weighted costs of white log albedo, and fill their gradient on the runs.

        Parameters
        ----------
        white, gradient : (3, h, w) arrays
        runs : (r, 3) array
        places : Places
            Scratch, for as many pixels as the runs have.
        """
        cells, shares = places.cells, places.shares
        knots, spacing = len(self.absolute), self.spacing
        corner, size = locate(white, runs, FIRST_KNOT, spacing, knots, cells, shares)
        histogram = np.zeros(tuple(size))
        splat_color(cells, shares, corner, histogram)
        smooth = smoothed_histogram(histogram, self._kernel(3))
        box = tuple(slice(a, a + n) for a, n in zip(corner, size, strict=True))
        losses, potential = self._losses(histogram, smooth, self.absolute[box])
        fill_color_slopes(cells, shares, corner, potential, runs, spacing, gradient)
        return losses

    def _kernel(self, axes: int) -> Float:
        """Return the entropy's kernel along one of so many axes."""
        reach = math.ceil(_REACH * self.sigma / self.spacing)
        distance = np.arange(-reach, reach + 1) * self.spacing
        kernel: Float = np.exp(-(distance**2) / (4 * self.sigma**2)) / self.count ** (2 / axes)
        return kernel

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
