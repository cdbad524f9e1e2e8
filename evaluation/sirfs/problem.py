"""From photographs, masks and priors to the problem that is minimised, at any resolution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import zoom

from evaluation.sirfs.depth_term import DepthTerm
from evaluation.sirfs.light_prior import light_whitening
from evaluation.sirfs.objective import Problem
from evaluation.sirfs.priors import SirfsPriors
from evaluation.sirfs.regions import outline_of, pair_runs, runs_of
from evaluation.sirfs.settings import TermWeights
from evaluation.sirfs.view import view_of
from shading_model.arrays import Float, Image, Mask


@dataclass(frozen=True, eq=False)
class Observation:
    """What is seen of an object: photographs on one grid of pixels, and its outline.

    Parameters
    ----------
    images : tuple of (h, w, c) arrays
        Linear intensities; one, or several under different lights.
    valid : tuple of (h, w) bool arrays
        Where each is above zero on the object.
    outline : (h, w) bool array
        Mask whose border is an occluding contour.
    depth : (h, w) array, optional
        External depth map in pixels, NaN where unknown.
    depth_blur : float
        In pixels.
    scale : float
        Pixels of the photograph along one pixel here.
    """

    images: tuple[Image, ...]
    valid: tuple[Mask, ...]
    outline: Mask
    depth: Float | None = None
    depth_blur: float = 0.0
    scale: float = 1.0

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in pixels."""
        rows, columns = self.outline.shape
        return rows, columns

    def halved(self) -> Observation:
        """Return the observation at half the resolution: means over the known of 2 x 2 pixels."""
        reduced = [
            _halved_image(image, valid)
            for image, valid in zip(self.images, self.valid, strict=True)
        ]
        share = _block_means(self.outline.astype(np.float64))
        return Observation(
            tuple(image for image, _ in reduced),
            tuple(valid for _, valid in reduced),
            share >= 0.5,
            None if self.depth is None else _halved_depth(self.depth),
            self.depth_blur / 2,
            self.scale * 2,
        )


def problem_of(
    seen: Observation, priors: SirfsPriors, weights: TermWeights, light: str, channels: str
) -> Problem:
    """Return the problem of an observation.

    Parameters
    ----------
    seen : Observation
    priors : SirfsPriors
    weights : TermWeights
    light : {"natural", "laboratory"}
    channels : {"gray", "color"}

    Returns
    -------
    Problem
    """
    prior = priors.lights[light, channels]
    anywhere: Mask = np.any(np.stack(seen.valid), axis=0)
    share = 1.0 / len(seen.images)
    depth = seen.depth if weights.depth else None
    return Problem(
        shape=seen.shape,
        views=tuple(
            view_of(image, valid, priors, weights, share)
            for image, valid in zip(seen.images, seen.valid, strict=True)
        ),
        runs=runs_of(anywhere),
        pairs=pair_runs(anywhere),
        curvature=priors.curvature.cost_table(),
        outline=outline_of(seen.outline),
        weights=weights,
        whitening=light_whitening(prior),
        precision=np.asarray(np.linalg.inv(prior.covariance), dtype=np.float64),
        depth=None
        if depth is None
        else DepthTerm(depth, weights.depth, weights.depth_power, seen.depth_blur),
        scale=seen.scale,
    )


def doubled_height(height: Float, shape: tuple[int, int]) -> Float:
    """Return a height map at twice the resolution: twice as high, in twice as many pixels.

    Parameters
    ----------
    height : (ceil(h / 2), ceil(w / 2)) array
    shape : (h, w)

    Returns
    -------
    (h, w) array

    Examples
    --------
    >>> doubled_height(np.tile(np.arange(3.0), (2, 1)), (4, 6))[1]
    array([0. , 0.5, 1.5, 2.5, 3.5, 4. ])
    """
    # Pixel centres: fine pixels 2 i and 2 i + 1 lie a quarter of a coarse pixel beside pixel i.
    fine: Float = 2.0 * zoom(height, 2, order=1, mode="nearest", grid_mode=True)
    return np.ascontiguousarray(fine[: shape[0], : shape[1]])


def _halved_image(image: Image, valid: Mask) -> tuple[Image, Mask]:
    share = _block_means(valid.astype(np.float64))
    sums = np.stack(
        [_block_means(np.where(valid, plane, 0.0)) for plane in np.moveaxis(image, -1, 0)]
    )
    mean = np.divide(sums, share, out=np.zeros_like(sums), where=share > 0)
    return np.moveaxis(mean, 0, -1), share >= 0.5


def _halved_depth(depth: Float) -> Float:
    known = np.isfinite(depth)
    share = _block_means(known.astype(np.float64))
    sums = _block_means(np.where(known, depth, 0.0))
    return np.divide(sums, 2 * share, out=np.full_like(sums, np.nan), where=share > 0)


def _block_means(values: Float) -> Float:
    """Return means over 2 x 2 pixels, zero beyond the edge."""
    rows, columns = values.shape
    padded = np.pad(values, ((0, rows % 2), (0, columns % 2)))
    blocks = padded.reshape(padded.shape[0] // 2, 2, padded.shape[1] // 2, 2)
    means: Float = blocks.mean(axis=(1, 3))
    return means
