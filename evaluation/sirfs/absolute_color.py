"""How common a colour of albedo is: a smooth minus log density in three dimensions.

Log albedo is whitened first (`color_whitening`), then spread over a grid of 102^3 knots evenly in
[-7, 4] along each axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import fmin_l_bfgs_b

from evaluation.sirfs.absolute_albedo import LARGEST, LEAST, checked_albedos
from evaluation.sirfs.bending import bending
from evaluation.sirfs.scale_mixture import inverse_root
from shading_model.arrays import Float

COLOR_KNOTS = 102
COLOR_SMOOTHNESS = 2.0**-12
"""Weight of the bending at each of 102^3 knots; see `evaluation.sirfs.smoothness_search`."""
PADDING = 0.01
_STAGES = ((27, 500), (52, 400), (COLOR_KNOTS, 300))
"""Knots along an axis and steps at most, from coarse to fine."""
_SPACING = (LARGEST - LEAST) / (COLOR_KNOTS - 1)
_SOFTNESS = 1e-5
_COARSEST = 5


def color_whitening(samples: Float) -> Float:
    """Return W, symmetric, such that the rows ``samples @ W`` are about white around zero.

    The inverse root of the second moments, which are padded by 0.01.

    Parameters
    ----------
    samples : (n, 3) array
        Log albedos.

    Returns
    -------
    (3, 3) array

    Raises
    ------
    RelightlabError
        If there are no samples or one is NaN.

    Examples
    --------
    >>> color_whitening(np.sqrt(3 * 0.99) * np.eye(3)).round(6)
    array([[1., 0., 0.],
           [0., 1., 0.],
           [0., 0., 1.]])
    """
    given = checked_albedos(samples)
    return inverse_root(given.T @ given / len(given), PADDING)


def trilinear_splat(whitened: Float, knots: int = COLOR_KNOTS) -> Float:
    """Return the histogram of colours, each shared out between the eight knots around it.

    Parameters
    ----------
    whitened : (n, 3) array
        Values beyond the ends count at the ends.
    knots : int
        Along each axis.

    Returns
    -------
    (knots, knots, knots) array
        Sums to one.

    Raises
    ------
    RelightlabError
        If there are no samples or one is NaN.

    Examples
    --------
    >>> trilinear_splat(np.array([[-7.0, 4.0, -1.5]]), 2)[0, 1]
    array([0.5, 0.5])
    """
    given = checked_albedos(whitened)
    places = np.clip((given - LEAST) * ((knots - 1) / (LARGEST - LEAST)), 0, knots - 1)
    below = np.minimum(places.astype(int), knots - 2)
    above = places - below
    histogram = np.zeros(knots**3)
    for corner in np.ndindex(2, 2, 2):
        shares = np.where(corner, above, 1 - above).prod(axis=1)
        indices = np.ravel_multi_index(tuple((below + corner).T), (knots,) * 3)
        histogram += np.bincount(indices, shares, knots**3)
    shared: Float = (histogram / len(given)).reshape((knots,) * 3)
    return shared


def fit_color_absolute(
    whitened: Float, smoothness: float = COLOR_SMOOTHNESS, finest: int = COLOR_KNOTS
) -> Float:
    """Return F, a smooth minus log density of whitened log albedo.

    Minimises ``sum p F + log sum exp(-F) + smoothness * bending(F)``, p the histogram of the
    samples: the gray problem of `evaluation.sirfs.absolute_albedo`, with the bending of a thin
    plate for the second difference. It is convex, and solved from coarse to fine grids.

    Parameters
    ----------
    whitened : (n, 3) array
    smoothness : float
        Of the grid of 102^3 knots; a coarser one gets what keeps the integral the same.
    finest : int
        Stop at grids of so many knots along an axis: 27, 52 or 102.

    Returns
    -------
    (finest, finest, finest) array
        Its least value is 0.

    Raises
    ------
    RelightlabError
        If there are no samples or one is NaN.

    Examples
    --------
    >>> samples = np.random.default_rng(0).normal(-1.0, 0.7, (2000, 3))
    >>> cost = fit_color_absolute(samples, 2.0**-9, 27)
    >>> np.linspace(-7, 4, 27)[list(np.unravel_index(cost.argmin(), cost.shape))].round()
    array([-1., -1., -1.])
    """
    samples = checked_albedos(whitened)
    cost = _first_guess(samples, _STAGES[0][0])
    for knots, steps in _STAGES:
        if knots > finest:
            break
        cost = _resampled(cost, _interpolation(len(cost), knots))
        cost = _solve(cost, trilinear_splat(samples, knots), smoothness, steps)
    lowered: Float = cost - cost.min()
    return lowered


def mean_cost(cost: Float, histogram: Float) -> float:
    """Return the mean minus log density that F gives to a histogram on the same knots.

    In natural units, of a density per unit volume of whitened log albedo.

    Parameters
    ----------
    cost, histogram : (n, n, n) arrays

    Returns
    -------
    float

    Examples
    --------
    >>> flat = np.zeros((5, 5, 5))
    >>> bool(np.isclose(mean_cost(flat, flat + 1 / 125), 3 * np.log(5 * 11 / 4)))
    True
    """
    least = cost.min()
    total = np.log(np.exp(least - cost).sum()) - least
    spacing = (LARGEST - LEAST) / (len(cost) - 1)
    return float((histogram * cost).sum() + total + 3 * np.log(spacing))


def _first_guess(whitened: Float, knots: int) -> Float:
    """Return a bowl around the mean of the samples, straight far out as F is."""
    axis = np.linspace(LEAST, LARGEST, knots)
    grid = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
    root = inverse_root(np.cov(whitened, rowvar=False), PADDING)
    squared = (((grid - whitened.mean(axis=0)) @ root) ** 2).sum(axis=-1)
    bowl: Float = np.sqrt(1 + squared)
    return bowl


def _solve(start: Float, histogram: Float, smoothness: float, steps: int) -> Float:
    coarser = (LARGEST - LEAST) / (len(start) - 1) / _SPACING
    weight, softness = smoothness * coarser, _SOFTNESS * coarser**4
    pyramid, by_bending = _Pyramid.of(len(start)), np.empty_like(start)

    def loss(parts: Float) -> tuple[float, Float]:
        cost = start + pyramid.sum(parts)
        least = cost.min()
        density = np.exp(least - cost)
        total = density.sum()
        bent = bending(cost, softness, by_bending)
        gradient = histogram - density / total + weight * by_bending
        value = (histogram * cost).sum() + np.log(total) - least + weight * bent
        return float(value), pyramid.adjoint(gradient)

    found, _, _ = fmin_l_bfgs_b(
        loss, np.zeros(pyramid.size), m=20, factr=4.5e7, pgtol=1e-9, maxiter=steps
    )
    return start + pyramid.sum(found)


@dataclass(frozen=True, eq=False)
class _Pyramid:
    """A function as the sum of interpolated coarser ones: in these unknowns descent is quick."""

    interpolations: tuple[Float, ...]
    sizes: tuple[int, ...]

    @classmethod
    def of(cls, knots: int) -> _Pyramid:
        sizes = [knots]
        while sizes[-1] > _COARSEST:
            sizes.append(sizes[-1] // 2 + 1)
        pairs = zip(sizes[1:], sizes[:-1], strict=True)
        return cls(tuple(_interpolation(*pair) for pair in pairs), tuple(sizes))

    @property
    def size(self) -> int:
        return sum(size**3 for size in self.sizes)

    def sum(self, parts: Float) -> Float:
        ends = np.cumsum([size**3 for size in self.sizes])[:-1]
        pairs = zip(np.split(parts, ends), self.sizes, strict=True)
        *finer, total = [part.reshape((size,) * 3) for part, size in pairs]
        for part, matrix in zip(reversed(finer), reversed(self.interpolations), strict=True):
            total = part + _resampled(total, matrix)
        return total

    def adjoint(self, gradient: Float) -> Float:
        parts = [gradient]
        for matrix in self.interpolations:
            parts.append(_resampled(parts[-1], matrix.T))
        return np.concatenate([part.ravel() for part in parts])


def _interpolation(coarse: int, fine: int) -> Float:
    """Return the (fine, coarse) matrix of linear interpolation over the same interval."""
    places = np.linspace(0, coarse - 1, fine)
    below = np.minimum(places.astype(int), coarse - 2)
    matrix = np.zeros((fine, coarse))
    matrix[np.arange(fine), below] = 1 - (places - below)
    matrix[np.arange(fine), below + 1] = places - below
    return matrix


def _resampled(values: Float, matrix: Float) -> Float:
    """Apply a matrix along each of the three axes."""
    for _ in range(3):
        # The axis that was first comes last; after three turns all are where they were.
        values = np.tensordot(values, matrix, axes=(0, 1))
    return values
