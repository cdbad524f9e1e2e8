"""The light that a photographed white sphere was under (Ramamoorthi and Hanrahan 2001)."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import map_coordinates

from shading_model.arrays import Image
from shading_model.errors import RelightlabError
from shading_model.harmonic_conversion import fit_log_coefficients, visible_normals
from shading_model.illumination import LogHarmonics

SMALLEST_SIDE = 8
LARGEST_RADIUS = 0.95
"""Pixels farther from the centre, in radii, are mixed with the background."""
SATURATED = 0.999
LARGEST_SATURATED_SHARE = 0.05


def light_of_probe(image: Image) -> LogHarmonics:
    """Return the nine log coefficients of each colour that best explain a diffuse sphere.

    Parameters
    ----------
    image : (h, w, 3) array
        Linear picture cut to the sphere: its outline touches all four sides.

    Returns
    -------
    LogHarmonics
        Coefficients of shape (9, 3); the sphere's albedo is taken for one.

    Raises
    ------
    RelightlabError
        If the picture is not square to within two per cent, smaller than 8 pixels, not finite or
        negative, saturated, or dark.

    Examples
    --------
    >>> light = light_of_probe(np.full((32, 32, 3), 0.5))
    >>> light.shade(np.array([[[0.0, 0.0, 1.0]]])).round(3)
    array([[[0.5, 0.5, 0.5]]])
    """
    height, width = _checked_size(image)
    normals = visible_normals()
    normals = normals[np.hypot(normals[:, 0], normals[:, 1]) <= LARGEST_RADIUS]
    places = np.stack(
        [(height - 1 - height * normals[:, 1]) / 2, (width - 1 + width * normals[:, 0]) / 2]
    )
    colours = [np.asarray(map_coordinates(image[..., c], places, order=1)) for c in range(3)]
    shading = np.stack(colours, axis=-1)
    if not np.isfinite(shading).all() or (shading < 0).any():
        raise RelightlabError("the light probe has NaN, infinite or negative pixels")
    if (shading >= SATURATED).any(axis=-1).mean() > LARGEST_SATURATED_SHARE:
        raise RelightlabError("the light probe is saturated: expose it less, or give an .exr")
    return LogHarmonics(
        np.stack([fit_log_coefficients(normals, colour) for colour in shading.T], axis=-1)
    )


def _checked_size(image: Image) -> tuple[int, int]:
    if image.ndim != 3 or image.shape[-1] != 3:
        raise RelightlabError(f"expected a light probe of shape (h, w, 3), got {image.shape}")
    height, width = image.shape[:2]
    if abs(height - width) > 0.02 * max(height, width) or min(height, width) < SMALLEST_SIDE:
        raise RelightlabError(
            f"expected a light probe cut to its sphere, square and at least {SMALLEST_SIDE} pixels"
            f" wide, got {width}x{height}"
        )
    return height, width
