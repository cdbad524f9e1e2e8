"""The light of a picture relative to another of the same view, on a shape known beforehand.

Without a light probe the object has to tell its own light. In the ratio of two pictures of one view
its albedo cancels; what is left is the ratio of two shadings, and of two log-harmonic shadings that
ratio is log-harmonic too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shading_model.arrays import Float, Image, Mask, Normals, check_image, check_map
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics, harmonics

RIDGE = 1e-3
"""Pull of the coefficients to zero, in units of the mean squared difference of the log ratio.

An object that mostly faces the viewer says little of normals that do not, and without a pull the
light would be anything there. Directions it does show are determined a hundred times better.
"""
FITTED_PIXELS = 20_000
DARKEST = 1e-3
"""Pixels darker than this in a channel of either picture take no part: their ratio is noise."""


@dataclass(frozen=True, eq=False)
class RelativeLight:
    """A light told from the picture of an object.

    Parameters
    ----------
    illumination : LogHarmonics
        Coefficients of shape (9, 3): the shading of the picture over that of the reference.
    residual : float
        Root mean square of what ``reference * shading`` leaves of the picture over the usable
        pixels, relative to the picture's own.
    unlit_residual : float
        The same for the reference times one number: what there was to explain.
    """

    illumination: LogHarmonics
    residual: float
    unlit_residual: float


def relative_light(image: Image, reference: Image, normals: Normals, usable: Mask) -> RelativeLight:
    """Return the light under which a reference picture becomes another picture of the view.

    Weighted linear least squares of ``log(image / reference) = B(N) . L`` for each colour on about
    `FITTED_PIXELS` pixels, weighted by the squared image, so that differences count as they do in
    the image, with a pull to zero (`RIDGE`). The light is **relative**: if the reference was taken
    under even light it is the picture's own; otherwise it lacks what the reference's light did.

    Parameters
    ----------
    image, reference : (h, w, 3) array
        Linear pictures of one view.
    normals : (h, w, 3) array
        Unit normals of the view; NaN where unknown.
    usable : (h, w) bool array
        Pixels of the object that are not saturated.

    Returns
    -------
    RelativeLight

    Raises
    ------
    RelightlabError
        If sizes differ, a usable pixel is NaN, infinite or negative, or fewer than nine are left.

    Examples
    --------
    >>> from shading_model.harmonic_conversion import visible_normals
    >>> normals = visible_normals(400).reshape(20, 20, 3)
    >>> cloth = np.full((20, 20, 3), 0.4)
    >>> light = relative_light(cloth / 2, cloth, normals, np.ones((20, 20), bool))
    >>> light.illumination.shade(normals[10, 10]).round(2), round(light.residual, 2)
    (array([0.5, 0.5, 0.5]), 0.0)
    """
    facing = check_map(normals, usable, "normals", channels=3)
    lit, even = check_image(image, usable), check_image(reference, usable)
    bright = (np.minimum(lit, even) > DARKEST).all(axis=-1)
    told = usable & bright & np.isfinite(facing).all(axis=-1)
    count = int(np.count_nonzero(told))
    if count < 9:
        raise RelightlabError(
            f"{count} pixels are neither dark nor saturated and have a normal, and nine"
            " coefficients need more: give another picture"
        )
    basis, lit, even = harmonics(facing[told]), lit[told], even[told]
    chosen = np.arange(0, count, max(1, count // FITTED_PIXELS))
    fits = [_fit(basis[chosen], lit[chosen, c], even[chosen, c]) for c in range(3)]
    light = LogHarmonics(np.stack(fits, axis=-1))
    shading = np.exp(basis @ light.coefficients)
    scale = float((lit * even).sum() / (even**2).sum())
    return RelativeLight(light, _relative(even * shading, lit), _relative(scale * even, lit))


def _fit(basis: Float, lit: Float, even: Float) -> Float:
    weights = lit**2 / np.mean(lit**2)
    weighted = basis * weights[:, None]
    gram = weighted.T @ basis / len(basis) + RIDGE * np.eye(9)
    right = weighted.T @ np.log(lit / even) / len(basis)
    return np.asarray(np.linalg.solve(gram, right), dtype=np.float64)


def _relative(found: Float, picture: Float) -> float:
    return float(np.sqrt(np.mean((found - picture) ** 2) / np.mean(picture**2)))
