"""The light of a picture that is cut to a white sphere, as a set of one's own holds it."""

from __future__ import annotations

import numpy as np

from shading_model.arrays import Image
from shading_model.diffuse_probe import SATURATED, fit_diffuse_probe
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics
from shading_model.probe_sphere import ProbeSphere

SMALLEST_SIDE = 8


def light_of_probe(image: Image) -> LogHarmonics:
    """Return the nine log coefficients of each colour that best explain a diffuse sphere.

    Saturated pixels are left out; a picture with values above one has none.

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

    See Also
    --------
    shading_model.diffuse_probe.fit_diffuse_probe : the same of any picture with a mask.

    Examples
    --------
    >>> light = light_of_probe(np.full((32, 32, 3), 0.5))
    >>> light.shade(np.array([[[0.0, 0.0, 1.0]]])).round(3)
    array([[[0.5, 0.5, 0.5]]])
    """
    height, width = _checked_size(image)
    sphere = ProbeSphere((height - 1) / 2, (width - 1) / 2, (height + width) / 4)
    probe = fit_diffuse_probe(
        image,
        np.ones((height, width), bool),
        saturated=np.inf if image.max() > 1 else SATURATED,
        sphere=sphere,
    )
    if probe.log is None:
        raise RelightlabError("the light probe is dark in one of its colours: its log is infinite")
    return probe.log


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
