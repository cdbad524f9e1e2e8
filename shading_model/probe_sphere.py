"""The sphere in the picture of a light probe: its circle, and the normals a viewer sees on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from shading_model.arrays import Float, Mask, Normals, check_mask
from shading_model.errors import RelightlabError

ROUNDNESS = 0.01
"""Largest root mean square distance of the outline from its circle, in radii."""
STAIRCASE = 0.5
"""The same in pixels, added: the outline of pixels is a staircase, about 0.3 pixels off."""
LARGEST_AREA_DIFFERENCE = 0.05
"""Largest share of the circle that the mask may miss or exceed, beyond a pixel's ring."""
LEAST_ARC = 0.5
"""Least share of the circumference that a picture has to show of a sphere it cuts."""
BORDER = 0.05
"""Width of the ring, in radii, in which pixels are mixed with the background."""
LEAST_BORDER = 1.5
"""The same in pixels, for small spheres."""

_SECTORS = 72


@dataclass(frozen=True)
class ProbeSphere:
    """A sphere seen from far away: a circle in the picture.

    Parameters
    ----------
    row, column : float
        Centre in pixels; the middle of the first pixel is (0, 0).
    radius : float
        Pixels.
    deviation : float
        Root mean square distance of the mask's outline from the circle, in radii.
    is_cut : bool
        Whether the mask reaches the picture's edge.

    Examples
    --------
    >>> ProbeSphere(10.0, 10.0, 5.0).normal_at(10.0, 13.0).round(6) + 0.0
    array([0.6, 0. , 0.8])
    """

    row: float
    column: float
    radius: float
    deviation: float = 0.0
    is_cut: bool = False

    def normals(self, shape: tuple[int, int]) -> Normals:
        """Return the normals over a picture of `shape` (h, w); NaN off the sphere."""
        rows, columns = np.ogrid[: shape[0], : shape[1]]
        return self.normal_at(rows, columns)

    def normal_at(self, row: float | Float, column: float | Float) -> Normals:
        """Return the normals at places of the picture, of shape (..., 3); NaN off the sphere."""
        x = (np.asarray(column, dtype=np.float64) - self.column) / self.radius
        y = (self.row - np.asarray(row, dtype=np.float64)) / self.radius
        x, y = np.broadcast_arrays(x, y)
        squared = 1.0 - x * x - y * y
        on_sphere = squared >= 0
        normals = np.stack([x, y, np.sqrt(np.maximum(squared, 0.0))], axis=-1)
        normals[~on_sphere] = np.nan
        return normals

    def inner_pixels(self, mask: Mask, border: float = BORDER) -> Mask:
        """Return the pixels of `mask` off the border ring, `border` radii and 1.5 pixels wide."""
        largest = self.radius - max(border * self.radius, LEAST_BORDER)
        rows, columns = np.ogrid[: mask.shape[0], : mask.shape[1]]
        inner: Mask = mask & (np.hypot(rows - self.row, columns - self.column) <= largest)
        return inner


def fit_sphere(mask: Mask, *, roundness: float = ROUNDNESS) -> ProbeSphere:
    """Return the sphere whose picture a mask is.

    Of a mask off the picture's edge, the centre is the centroid and the radius that of a disk of
    the same area. Of a mask that reaches the edge, both come from the outline that is seen, by
    least squares. Holes are filled first, so a spot can be taken out of the mask.

    Parameters
    ----------
    mask : (h, w) bool array
        True on the sphere.
    roundness : float
        Largest root mean square distance of the outline from the circle, in radii; half a pixel
        is added.

    Returns
    -------
    ProbeSphere

    Raises
    ------
    RelightlabError
        If the mask is empty, is not round, is not the inside of its circle, or shows too little of
        the outline.

    Examples
    --------
    >>> rows, columns = np.mgrid[:41, :61]
    >>> sphere = fit_sphere(np.hypot(rows - 20, columns - 25) < 12)
    >>> sphere.row, sphere.column, round(sphere.radius, 1)
    (20.0, 25.0, 11.8)
    """
    filled = _without_holes(check_mask(mask))
    outline = _outline(filled)
    is_cut = bool(filled[[0, -1]].any() or filled[:, [0, -1]].any())
    if len(outline) < 3:
        raise RelightlabError("the sphere's mask fills the picture: its outline has to be seen")
    row, column, radius = _circle_of_outline(outline) if is_cut else _circle_of_area(filled)
    away = np.hypot(outline[:, 0] - row, outline[:, 1] - column) - radius
    sphere = ProbeSphere(row, column, radius, float(np.sqrt(np.mean(away**2)) / radius), is_cut)
    _check_round(sphere, roundness)
    _check_arc(sphere, outline)
    _check_area(sphere, filled)
    return sphere


def _without_holes(mask: Mask) -> Mask:
    """Fill what the mask encloses: the parts of the background that do not reach the edge."""
    label, count = ndimage.label(~mask)
    reaches = np.zeros(count + 1, bool)
    for side in (label[0], label[-1], label[:, 0], label[:, -1]):
        reaches[side] = True
    filled: Mask = mask | ~reaches[label]
    return filled


def _outline(mask: Mask) -> Float:
    """Return the midpoints (row, column) between pixels of the mask and of the background."""
    vertical, horizontal = mask[1:] != mask[:-1], mask[:, 1:] != mask[:, :-1]
    below = np.argwhere(vertical) + np.array([0.5, 0.0])
    beside = np.argwhere(horizontal) + np.array([0.0, 0.5])
    return np.concatenate([below, beside])


def _circle_of_area(mask: Mask) -> tuple[float, float, float]:
    rows, columns = np.nonzero(mask)
    return float(rows.mean()), float(columns.mean()), float(np.sqrt(len(rows) / np.pi))


def _circle_of_outline(outline: Float) -> tuple[float, float, float]:
    """Fit |p|^2 = 2 c . p + (r^2 - |c|^2), which is linear in its three unknowns."""
    middle = outline.mean(axis=0)
    points = outline - middle
    design = np.column_stack([2 * points, np.ones(len(points))])
    (row, column, rest), *_ = np.linalg.lstsq(design, (points**2).sum(axis=1), rcond=None)
    radius = np.sqrt(max(rest + row**2 + column**2, np.finfo(float).tiny))
    return float(middle[0] + row), float(middle[1] + column), float(radius)


def _check_round(sphere: ProbeSphere, roundness: float) -> None:
    if sphere.deviation > roundness + STAIRCASE / sphere.radius:
        raise RelightlabError(
            f"the sphere's mask is not round: its outline is off its circle by"
            f" {100 * sphere.deviation:.1f} % of the radius (root mean square), at most"
            f" {100 * (roundness + STAIRCASE / sphere.radius):.1f} % is expected"
        )


def _check_arc(sphere: ProbeSphere, outline: Float) -> None:
    angles = np.arctan2(outline[:, 0] - sphere.row, outline[:, 1] - sphere.column)
    sectors = np.unique(np.floor((angles / np.pi + 1) * _SECTORS / 2).astype(int) % _SECTORS)
    shown = len(sectors) / _SECTORS
    if sphere.is_cut and shown < LEAST_ARC:
        raise RelightlabError(
            f"the picture cuts the sphere: {100 * shown:.0f} % of its outline is seen, at least"
            f" {100 * LEAST_ARC:.0f} % has to be"
        )


def _check_area(sphere: ProbeSphere, mask: Mask) -> None:
    """Refuse what has a round outline but is not the disk inside it, such as a mask inverted."""
    rows, columns = np.ogrid[: mask.shape[0], : mask.shape[1]]
    disk = np.hypot(rows - sphere.row, columns - sphere.column) <= sphere.radius
    different = float((disk != mask).sum()) / max(1.0, float(disk.sum()))
    if different > LARGEST_AREA_DIFFERENCE + 2 / sphere.radius:
        raise RelightlabError(
            f"the sphere's mask is not round: it differs from the disk in its outline by"
            f" {100 * different:.0f} % of the disk's area; mark the sphere and nothing else"
        )
