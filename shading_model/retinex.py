"""Retinex: a photograph is split into albedo and shading, I = A S.

A change of log brightness between neighbouring pixels belongs to the albedo where the chromaticity
changes too, or where the brightness changes a lot; all other changes are shading (Land and McCann
1971; colour Retinex as in Grosse et al. 2009).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shading_model.arrays import Float, Image, Map, Mask, check_image, check_mask
from shading_model.pixel_grid import PixelGrid, PoissonSolver

DARKEST = 1e-4
"""Intensities are not taken below this fraction of the object's brightest pixel."""
POISSON_TOLERANCE = 1e-5
MEAN_SHADING = 0.5
"""The scale that a single photograph leaves open is fixed by the shading's mean."""


@dataclass(frozen=True)
class RetinexThresholds:
    """Where a change between neighbours starts to be albedo, in natural-log units.

    Parameters
    ----------
    gray : float
        Change of log brightness (mean of the log channels).
    chromaticity : float
        Euclidean change of the log channels after taking out their mean; infinity for gray
        Retinex.
    """

    gray: float
    chromaticity: float


DEFAULT_THRESHOLDS = RetinexThresholds(gray=1.4, chromaticity=0.065)
"""Learned on the real photographs of MIT-Berkeley (`evaluation.retinex_thresholds`)."""


@dataclass(frozen=True, eq=False)
class IntrinsicImages:
    """Albedo and shading of a photograph, ``image = albedo * shading`` inside the mask.

    Parameters
    ----------
    albedo : (h, w, 3) array
        NaN outside the mask.
    shading : (h, w) array
        Mean `MEAN_SHADING`, NaN outside the mask.
    """

    albedo: Image
    shading: Map


class Retinex:
    """Retinex of one photograph for any number of thresholds: the multigrid is built once.

    Parameters
    ----------
    image : (h, w, 3) array
        Linear intensities; zeros inside the mask are raised to `DARKEST` times the brightest.
    mask : (h, w) bool array

    Raises
    ------
    RelightlabError
        For an empty mask, a size mismatch, or NaN, negative or all-black pixels inside it.
    """

    def __init__(self, image: Image, mask: Mask) -> None:
        grid = PixelGrid(check_mask(mask))
        self._image = check_image(image, grid.mask)
        inside = self._image[grid.mask]
        log_channels = np.log(np.maximum(inside, DARKEST * inside.max()))
        self._brightness: Float = log_channels.mean(axis=-1)
        self._brightness_change: Float = grid.gradient @ self._brightness
        chromaticity = log_channels - self._brightness[:, None]
        self._chromaticity_change: Float = np.linalg.norm(grid.gradient @ chromaticity, axis=-1)
        self._grid = grid
        self._solver = PoissonSolver(grid.laplacian, component=grid.components[1])

    def separate(self, thresholds: RetinexThresholds = DEFAULT_THRESHOLDS) -> IntrinsicImages:
        """Return albedo and shading for one pair of thresholds.

        The log albedo is the least-squares integral of the changes attributed to it; each
        connected component of the mask gets the same mean log albedo.
        """
        painted = (self._chromaticity_change > thresholds.chromaticity) | (
            np.abs(self._brightness_change) > thresholds.gray
        )
        albedo_change = np.where(painted, self._brightness_change, 0.0)
        divergence: Float = self._grid.gradient.T @ albedo_change
        log_albedo = self._solver.solve(divergence, POISSON_TOLERANCE)
        shading = np.exp(self._brightness - log_albedo)
        scaled = self._grid.spread(shading * (MEAN_SHADING / shading.mean()))
        return IntrinsicImages(self._image / scaled[..., None], scaled)


def retinex(
    image: Image, mask: Mask, thresholds: RetinexThresholds = DEFAULT_THRESHOLDS
) -> IntrinsicImages:
    """Return the colour-Retinex albedo and shading of a photograph; see `Retinex`.

    Examples
    --------
    >>> painted = np.full((8, 8, 3), 0.2)
    >>> painted[:, 4:] = (0.6, 0.3, 0.1)
    >>> parts = retinex(painted, np.ones((8, 8), bool))
    >>> bool(np.allclose(parts.shading, 0.5))
    True
    """
    return Retinex(image, mask).separate(thresholds)
