"""Photometric stereo: normals and albedo from pictures under known lights (Woodham 1980).

One view, several distant lights of known direction, a Lambertian surface: at each pixel the
intensities are linear in the albedo times the normal. Shadows and highlights are not, and are left
out pixel by pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shading_model.arrays import Float, Image, Map, Mask, Normals, check_mask
from shading_model.errors import RelightlabError

SATURATED = 0.999
"""An intensity from here on says only that the sensor was full."""
SHADOWED = 0.08
"""A sample below this share of its pixel's brightest is taken for a shadow."""
COPLANAR = 1e-3
"""Directions whose least extent is below this share of their greatest do not span space."""
LEAST_SPREAD = 0.02
"""The same bound, squared and for the samples left at a pixel: normals beyond it are noise."""
NOISE_FLOOR = 0.01
"""Residuals below this share of the pixel's median are never held against a sample."""
ROUNDS = 4
_CAUCHY = 2.385  # 95 % efficient on Gaussian residuals
_DEVIATION = 1.4826  # of a median absolute deviation


@dataclass(frozen=True, eq=False)
class PhotometricStereo:
    """A surface measured by its shading.

    Parameters
    ----------
    normals : (h, w, 3) array
        Unit normals (x right, y up, z toward the viewer); NaN outside the mask and where the
        usable samples do not determine one.
    albedo : (h, w, 3) array
        Albedo times the strength of a light of unit length, NaN where `normals` are.
    samples : (h, w) int array
        Samples that were neither shadowed nor saturated; zero outside the mask.
    residual : float
        Root mean square over those samples of what the fit leaves of the mean over the colour
        channels, relative to the root mean square of the samples.
    """

    normals: Normals
    albedo: Image
    samples: Map
    residual: float


def photometric_stereo(images: Float, directions: Float, mask: Mask) -> PhotometricStereo:
    """Return the normals and the albedo that best explain pictures under known lights.

    At each pixel ``I_k = albedo * (N . d_k)`` is solved for ``albedo * N`` by least squares,
    reweighted `ROUNDS` times (Cauchy) so that highlights and soft shadows lose their say. Samples
    that are saturated, below `SHADOWED` of the pixel's brightest, or turned away from their light
    are left out; a pixel of fewer than three samples, or whose lights nearly lie in a plane, is
    unknown.

    Parameters
    ----------
    images : (K, h, w) or (K, h, w, 3) array
        Linear intensities in [0, 1], at least zero on the mask.
    directions : (K, 3) array
        From the object to each light, times the light's strength.
    mask : (h, w) bool array

    Returns
    -------
    PhotometricStereo

    Raises
    ------
    RelightlabError
        If pictures and lights differ in number, sizes differ, the directions do not span space,
        or a value is NaN, infinite or negative.

    Examples
    --------
    >>> directions = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.6, 0.8]])
    >>> images = (0.5 * directions @ [0.0, 0.0, 1.0])[:, None, None]
    >>> stereo = photometric_stereo(images, directions, np.ones((1, 1), bool))
    >>> stereo.normals[0, 0].round(6) + 0.0, stereo.albedo[0, 0].round(6)
    (array([0., 0., 1.]), array([0.5, 0.5, 0.5]))
    """
    inside = check_mask(mask)
    lights = _checked_directions(directions)
    colours = _checked_pixels(images, inside, len(lights))
    intensities = colours.mean(axis=-1)
    usable = _usable(colours, intensities)
    scaled, usable = _robust_fit(intensities, lights, usable)
    scaled[~_is_determined(lights, usable)] = np.nan
    return _result(colours, lights, usable, scaled, inside)


def _robust_fit(intensities: Float, lights: Float, usable: Mask) -> tuple[Float, Mask]:
    """Return albedo times normal, (n, 3), and the samples (n, K) that it rests on."""
    floor = NOISE_FLOOR * np.median(intensities, axis=1, keepdims=True)
    weights = usable.astype(np.float64)
    for _ in range(ROUNDS):
        scaled = _weighted_fit(intensities, lights, weights)
        shaded = scaled @ lights.T
        lit = usable & (shaded > 0)
        # Samples the pixel cannot do without stay, whatever the fit thinks of them.
        usable = np.where(lit.sum(axis=1, keepdims=True) >= 3, lit, usable)
        misfit = np.abs(intensities - shaded)
        left_out = usable.any(axis=1, keepdims=True) & ~usable
        middle = np.nanmedian(np.where(left_out, np.nan, misfit), axis=1, keepdims=True)
        spread = np.maximum(_DEVIATION * middle, np.maximum(floor, 1e-12))
        weights = usable / (1 + (misfit / (_CAUCHY * spread)) ** 2)
    return _weighted_fit(intensities, lights, weights), usable


def _weighted_fit(intensities: Float, lights: Float, weights: Float) -> Float:
    products = np.einsum("ki,kj->kij", lights, lights).reshape(len(lights), 9)
    gram = (weights @ products).reshape(-1, 3, 3)
    # A pixel without enough samples is solved all the same, and dropped afterwards.
    ridge = 1e-9 * np.trace(products.sum(axis=0).reshape(3, 3))
    right = (weights * intensities) @ lights
    solution: Float = np.linalg.solve(gram + ridge * np.eye(3), right[..., None])[..., 0]
    return solution


def _usable(colours: Float, intensities: Float) -> Mask:
    unsaturated = (colours < SATURATED).all(axis=-1)
    brightest = intensities.max(axis=1, keepdims=True)
    usable: Mask = unsaturated & (intensities >= SHADOWED * brightest) & (intensities > 0)
    return usable


def _is_determined(lights: Float, usable: Mask) -> Mask:
    """Return which pixels' usable lights span space well enough to tell a normal."""
    products = np.einsum("ki,kj->kij", lights, lights).reshape(len(lights), 9)
    gram = (usable.astype(np.float64) @ products).reshape(-1, 3, 3)
    extent = np.linalg.eigvalsh(gram)
    whole = np.linalg.eigvalsh(products.sum(axis=0).reshape(3, 3))
    determined: Mask = (usable.sum(axis=1) >= 3) & (extent[:, 0] >= LEAST_SPREAD * whole[0])
    return determined


def _result(
    colours: Float, lights: Float, usable: Mask, scaled: Float, mask: Mask
) -> PhotometricStereo:
    normals = scaled / np.maximum(np.linalg.norm(scaled, axis=-1, keepdims=True), 1e-12)
    known = np.isfinite(scaled).all(axis=-1, keepdims=True)
    cosine = np.where(usable, np.maximum(normals @ lights.T, 0), 0)
    energy = np.einsum("nk,nk->n", cosine, cosine)
    albedo = np.einsum("nk,nkc->nc", cosine, colours) / np.maximum(energy, 1e-12)[:, None]
    counted = usable & known
    intensities = colours.mean(axis=-1)
    left = (intensities - np.nan_to_num(scaled) @ lights.T)[counted]
    power = float(np.mean(intensities[counted] ** 2)) if counted.any() else 1.0
    residual = float(np.sqrt(np.mean(left**2) / power)) if counted.any() else 0.0
    return PhotometricStereo(
        normals=_spread(normals, mask),
        albedo=_spread(np.where(known, albedo, np.nan), mask),
        samples=np.nan_to_num(_spread(usable.sum(axis=1).astype(np.float64), mask)),
        residual=residual,
    )


def _spread(values: Float, mask: Mask) -> Float:
    full = np.full((*mask.shape, *values.shape[1:]), np.nan)
    full[mask] = values
    return full


def _checked_directions(directions: Float) -> Float:
    lights = np.asarray(directions, dtype=np.float64)
    if lights.ndim != 2 or lights.shape[1] != 3 or not np.isfinite(lights).all():
        raise RelightlabError(
            f"expected finite light directions of shape (K, 3), got {np.shape(directions)}"
        )
    extent = np.linalg.svd(lights, compute_uv=False)
    rank = int((extent > COPLANAR * extent[0]).sum()) if len(extent) and extent[0] > 0 else 0
    if rank < 3:
        raise RelightlabError(
            f"the {len(lights)} light directions span {rank} of 3 dimensions (their rank): give at"
            " least three lights that do not lie in one plane with the object"
        )
    return lights


def _checked_pixels(images: Float, mask: Mask, lights: int) -> Float:
    """Return the colours of the mask's pixels, (n, K, 3)."""
    pictures = np.asarray(images, dtype=np.float64)
    if pictures.ndim not in {3, 4} or pictures.shape[3:] not in {(), (3,)}:
        raise RelightlabError(
            f"expected pictures of shape (K, h, w) or (K, h, w, 3), got {pictures.shape}"
        )
    if len(pictures) != lights:
        raise RelightlabError(
            f"there are {len(pictures)} pictures but {lights} light directions: give one for each"
        )
    if pictures.shape[1:3] != mask.shape:
        raise RelightlabError(
            f"the pictures are {pictures.shape[2]}x{pictures.shape[1]} pixels but their mask is"
            f" {mask.shape[1]}x{mask.shape[0]}: give a mask of their size"
        )
    inside = pictures[:, mask]
    if not np.isfinite(inside).all() or (inside < 0).any():
        raise RelightlabError("the pictures have NaN, infinite or negative pixels in the mask")
    coloured = inside[..., None] if inside.ndim == 2 else inside
    return np.ascontiguousarray(np.broadcast_to(coloured, (*inside.shape[:2], 3)).swapaxes(0, 1))
