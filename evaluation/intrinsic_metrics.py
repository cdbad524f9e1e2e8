"""Errors of an albedo and shading estimate against the truth (Grosse et al. 2009)."""

from __future__ import annotations

import numpy as np

from shading_model.arrays import Float, Image, Map, Mask
from shading_model.errors import RelightlabError

WINDOW = 20
"""Side of the windows in pixels."""


def local_mean_squared_error(
    estimate: Float, truth: Float, mask: Mask, window: int = WINDOW
) -> float:
    """Return the LMSE: squared error with one scale per window, relative to the truth's power.

    Windows of `window` pixels tile the picture, in four copies shifted by half a window less one;
    each window's estimate is scaled to fit best. Zero for a perfect estimate, at most one.

    Parameters
    ----------
    estimate, truth : (h, w) or (h, w, c) array
        With channels, the mean over the channels is returned. Ignored outside the mask.
    mask : (h, w) bool array
        Pixels where both are known.
    window : int
        Side in pixels.

    Returns
    -------
    float

    Raises
    ------
    RelightlabError
        If the shapes differ, or the truth is zero all over the mask.

    Examples
    --------
    >>> truth = np.tile(np.linspace(0.1, 1, 40), (40, 1))
    >>> round(local_mean_squared_error(3 * truth, truth, truth > 0), 12)
    0.0
    """
    if np.shape(estimate) != np.shape(truth):
        raise RelightlabError(
            f"expected an estimate of shape {np.shape(truth)}, got {np.shape(estimate)}"
        )
    if np.ndim(truth) == 3:
        channels = range(np.shape(truth)[-1])
        return float(
            np.mean(
                [local_mean_squared_error(estimate[..., c], truth[..., c], mask, window)
                 for c in channels]
            )
        )  # fmt: skip
    known_estimate, known_truth = (np.where(mask, a, 0.0) for a in (estimate, truth))
    products = (known_truth**2, known_truth * known_estimate, known_estimate**2)
    shift = window // 2 - 1
    power = error = 0.0
    for row in (0, shift):
        for column in (0, shift):
            tt, te, ee = (_block_sums(p[row:, column:], window) for p in products)
            error += float(np.sum(tt - np.divide(te**2, ee, out=np.zeros_like(te), where=ee > 0)))
            power += float(np.sum(tt))
    if power <= 0:
        raise RelightlabError("the truth is zero all over the mask: no error can be relative to it")
    return max(error / power, 0.0)


def intrinsic_error(
    albedo: Image, shading: Map, true_albedo: Image, true_shading: Image, mask: Mask
) -> float:
    """Return the mean of the LMSE of shading and of albedo, Grosse et al.'s score.

    Parameters
    ----------
    albedo, true_albedo, true_shading : (h, w, 3) arrays
    shading : (h, w) array
        Compared with each channel of the true shading.
    mask : (h, w) bool array
        Narrowed to the pixels where everything is known.

    Returns
    -------
    float
    """
    colour = np.repeat(shading[..., None], 3, axis=-1)
    everything = np.concatenate([albedo, colour, true_albedo, true_shading], axis=-1)
    known = mask & np.isfinite(everything).all(axis=-1)
    of_shading = local_mean_squared_error(colour, true_shading, known)
    return (of_shading + local_mean_squared_error(albedo, true_albedo, known)) / 2


def _block_sums(values: Map, side: int) -> Float:
    rows, columns = (-size % side for size in values.shape)
    padded = np.pad(values, ((0, rows), (0, columns)))
    blocks = padded.reshape(padded.shape[0] // side, side, padded.shape[1] // side, side)
    sums: Float = blocks.sum(axis=(1, 3))
    return sums
