"""The direction of a distant light, from its highlight on a photographed mirror sphere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from shading_model.arrays import Float, Image, Map, Mask, check_image, check_mask
from shading_model.errors import RelightlabError
from shading_model.probe_sphere import BORDER, ProbeSphere, fit_sphere

THRESHOLD = 0.5
"""A highlight is a connected region at least this share as bright as the brightest pixel."""
LARGEST_SHARE = 0.05
"""Share of the sphere that may be as bright as that."""
SMALLEST_AREA = 3
"""Pixels of a highlight at least: one or two may be a defect of the sensor."""
DOMINANCE = 2 / 3
"""Least share of the light as bright as that which the highlight has to hold."""

_TOWARD_VIEWER = np.array([0.0, 0.0, 1.0])
_EIGHT_NEIGHBOURS = np.ones((3, 3), bool)


@dataclass(frozen=True, eq=False)
class ChromeProbe:
    """The highlight on a mirror sphere, and the light it mirrors.

    Parameters
    ----------
    direction : (3,) array
        Unit vector toward the light (x right, y up, z toward the viewer).
    normal : (3,) array
        Of the sphere where the highlight is.
    row, column : float
        Centre of the highlight in pixels, weighted by brightness.
    area : int
        Pixels of the highlight.
    share : float
        What it holds of the light at least half as bright as the brightest pixel, from 0 to 1.
    degrees_per_pixel : float
        How far the direction moves at most if the highlight moves by a pixel.
    sphere : ProbeSphere
    """

    direction: Float
    normal: Float
    row: float
    column: float
    area: int
    share: float
    degrees_per_pixel: float
    sphere: ProbeSphere


def chrome_direction(
    image: Image,
    mask: Mask,
    *,
    threshold: float = THRESHOLD,
    border: float = BORDER,
    sphere: ProbeSphere | None = None,
) -> ChromeProbe:
    """Return the direction of the light whose highlight a mirror sphere shows.

    The highlight is the connected region of the most light among the pixels at least `threshold`
    as bright as the brightest (mean over the colours; eight neighbours). A viewer at v, far away,
    sees there the light from r = 2 (n . v) n - v.

    Parameters
    ----------
    image : (h, w, 3) or (h, w) array
        Picture, finite and at least zero on the sphere. A highlight may be saturated.
    mask : (h, w) bool array
        True on the sphere.
    threshold : float
        Above 0 and below 1.
    border : float
        Width in radii of the ring at the outline that is left out; never under 1.5 pixels.
    sphere : ProbeSphere, optional
        The circle, where it is known; by default that of the mask.

    Returns
    -------
    ChromeProbe

    Raises
    ------
    RelightlabError
        If the mask is not the picture of a sphere, sizes differ, pixels are NaN, infinite or
        negative, or no highlight stands out: none, too large or small a one, or several.

    Examples
    --------
    >>> rows, columns = np.mgrid[:61, :61]
    >>> mask = np.hypot(rows - 30, columns - 30) < 28
    >>> highlight = np.exp(-((rows - 30) ** 2 + (columns - 40) ** 2) / 4)
    >>> probe = chrome_direction(np.where(mask, 0.1 + highlight, 0.0), mask)
    >>> round(probe.row, 6), round(probe.column, 6), probe.area
    (30.0, 40.0, 9)
    """
    if not 0 < threshold < 1:
        raise RelightlabError(f"expected a threshold above 0 and below 1, got {threshold}")
    mask = check_mask(mask)
    sphere = sphere or fit_sphere(mask)
    inner = sphere.inner_pixels(mask, border)
    if not inner.any():
        raise RelightlabError("the sphere is too small: all its pixels are in the ring left out")
    brightness = np.where(inner, check_image(image, inner).mean(axis=-1), 0.0)
    region, share = _highlight(brightness, int(inner.sum()), threshold)
    row, column = ndimage.center_of_mass(np.where(region, brightness, 0.0))
    normal = sphere.normal_at(row, column)
    return ChromeProbe(
        direction=mirrored(normal),
        normal=normal,
        row=float(row),
        column=float(column),
        area=int(region.sum()),
        share=share,
        degrees_per_pixel=float(np.degrees(2.0 / (sphere.radius * normal[2]))),
        sphere=sphere,
    )


def mirrored(normal: Float) -> Float:
    """Return the direction from which a mirror sends light to a viewer far away.

    Parameters
    ----------
    normal : (..., 3) array
        Unit normals of the mirror (x right, y up, z toward the viewer).

    Returns
    -------
    (..., 3) array
        Unit vectors.

    Examples
    --------
    >>> mirrored(np.array([0.6, 0.0, 0.8])).round(6)
    array([0.96, 0.  , 0.28])
    """
    direction: Float = 2.0 * normal[..., 2:3] * normal - _TOWARD_VIEWER
    return direction


def _highlight(brightness: Map, pixels: int, threshold: float) -> tuple[Mask, float]:
    """Return the brightest region, and its share of all light above the threshold."""
    label, lights = _regions(brightness, threshold * brightness.max())
    covered = int((label > 0).sum()) / pixels
    if covered > LARGEST_SHARE:
        raise _indistinct(
            f"{100 * covered:.0f} % of the sphere is at least {100 * threshold:.0f} % as bright as"
            f" its brightest pixel, at most {100 * LARGEST_SHARE:.0f} % may be"
        )
    brightest = int(np.argmax(lights))
    region: Mask = label == brightest + 1
    area, share = int(region.sum()), float(lights[brightest] / lights.sum())
    if area < SMALLEST_AREA:
        raise _indistinct(f"the brightest region has {area} of {SMALLEST_AREA} pixels needed")
    if share < DOMINANCE:
        raise _indistinct(
            f"the brightest of {len(lights)} bright regions holds {100 * share:.0f} % of their"
            f" light, at least {100 * DOMINANCE:.0f} % is needed"
        )
    return region, share


def _regions(brightness: Map, level: float) -> tuple[NDArray[np.intp], Float]:
    """Return the number of each pixel's region, 0 for none, and the light of regions 1, 2, ..."""
    found, count = ndimage.label(brightness >= level, structure=_EIGHT_NEIGHBOURS)
    label = np.asarray(found, dtype=np.intp)
    lights = np.bincount(label.ravel(), weights=brightness.ravel(), minlength=count + 1)
    return label, np.asarray(lights[1:], dtype=np.float64)


def _indistinct(why: str) -> RelightlabError:
    return RelightlabError(f"the chrome sphere has no distinct highlight: {why}")
