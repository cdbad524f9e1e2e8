"""How well a height field bears a turned view: its outline, and the shadows it casts on itself.

A viewer who goes by an angle t toward an azimuth sees a point of height Z, at s along that azimuth,
at ``s cos t - Z sin t``; places across the azimuth stay. So an open surface cut into strips along
the azimuth is seen strip by strip, and each measure is one sweep over its pixels. A distant light
inclined by t shines on exactly what that viewer sees, so the same sweep gives the shadows.

Angles are degrees from the view direction, from 0 to below 90; azimuths are degrees from right,
counter-clockwise. Both measures are free of units, and neither depends on where the surface
stands, how far away it is, or at what scale it is given.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import affine_transform, distance_transform_edt, gaussian_filter

from shading_model.arrays import Float, Map, Mask, check_map, check_mask
from shading_model.errors import RelightlabError

OUTLINE_BLUR = 1.0
"""Pixels by which the mask is blurred where its outline is measured, not where it is turned."""


@dataclass(frozen=True, eq=False)
class GenericView:
    """Both measures of one surface.

    Parameters
    ----------
    outline_shift, shadow_share : (angles, azimuths) arrays
        See the functions of these names.
    """

    outline_shift: Float
    shadow_share: Float


def generic_view(
    height: Map, mask: Mask, angles: Sequence[float], azimuths: Sequence[float]
) -> GenericView:
    """Return `outline_shift` and `self_shadow_share` of a surface, for the work of one.

    Parameters
    ----------
    height : (h, w) array
        Pixels, larger is nearer. A pixel of the mask whose height is NaN or infinite takes the
        nearest known one, so the outline is always the mask's; ignored outside the mask.
    mask : (h, w) bool array
    angles, azimuths : sequences of float
        Degrees, see the module.

    Returns
    -------
    GenericView

    Raises
    ------
    RelightlabError
        If no height is known inside the mask, the sizes differ, an angle is not in [0, 90), or
        an azimuth is not finite.

    Examples
    --------
    >>> flat = generic_view(np.zeros((4, 6)), np.ones((4, 6), bool), [0, 15], [0, 45, 90])
    >>> flat.outline_shift.shape, flat.shadow_share.shape
    ((2, 3), (2, 3))
    >>> round(float(flat.outline_shift.max()), 12), float(flat.shadow_share.max())
    (0.0, 0.0)
    """
    area, share = _measured(height, mask, angles, azimuths, (_differing, _shadowed))
    return GenericView(area / _outline_unit(mask, azimuths), share)


def outline_shift(
    height: Map, mask: Mask, angles: Sequence[float], azimuths: Sequence[float]
) -> Float:
    """Return how far the outline moves from that of the flat cut-out, in diameters of the object.

    The turned open surface and the turned flat mask, which only narrows by cos t, are both drawn
    without perspective. The area that one covers and the other does not, over the length of the
    outline as it is met along the azimuth (two ends for each run of the mask in each strip), is
    the mean distance between both outlines along the azimuth; the object's diameter is that of the
    disk of the mask's area. The viewer follows the object: the median shift of all ends is taken
    out, so that neither the pivot nor the unknown offset of a height field counts.

    A surface over a level outline whose slopes stay below cot t does not move its outline at all.
    A hemisphere that stands on its outline has ``pi / 16 (1 - cos t)``.

    Parameters
    ----------
    height, mask, angles, azimuths
        As for `generic_view`.

    Returns
    -------
    (angles, azimuths) array

    Raises
    ------
    RelightlabError
        As `generic_view`.

    Examples
    --------
    A block at the left end is 10 nearer than the other ends, and moves by 10 sin 15:

    >>> height = np.zeros((9, 40))
    >>> height[:3, :5] = 10.0
    >>> shift = outline_shift(height, height > -1, [15], [0, 180])
    >>> diameter = 2 * np.sqrt(9 * 40 / np.pi)
    >>> (shift * diameter * 18 / (3 * 10 * np.sin(np.deg2rad(15)))).round(6)
    array([[1., 1.]])
    """
    (area,) = _measured(height, mask, angles, azimuths, (_differing,))
    shift: Float = area / _outline_unit(mask, azimuths)
    return shift


def self_shadow_share(
    height: Map, mask: Mask, angles: Sequence[float], azimuths: Sequence[float]
) -> Float:
    """Return the share of the mask that lies in shadows the surface casts on itself.

    The light is distant, inclined by the angle toward the azimuth. What faces it and is hidden
    from it by another part of the surface counts; what is turned away from it does not, so that
    nothing convex counts. The surface runs straight from pixel to pixel along the azimuth, and
    shadows end between pixels. It is the front of something solid: light passes over a gap of the
    mask, not under the surface beyond. A hemispherical hollow has ``(cos t - cos 2t) / 2``.

    Parameters
    ----------
    height, mask, angles, azimuths
        As for `generic_view`; the angles are those between light and view direction.

    Returns
    -------
    (angles, azimuths) array
        In [0, 1]: of the mask's area as the camera sees it.

    Raises
    ------
    RelightlabError
        As `generic_view`.

    Examples
    --------
    A wall of 10 pixels, with the light on its right at 45 degrees; its own slope takes one pixel:

    >>> height = np.zeros((5, 40))
    >>> height[:, 20:] = 10.0
    >>> self_shadow_share(height, height > -1, [45], [0, 180]) * 40
    array([[9., 0.]])
    """
    share: Float = _measured(height, mask, angles, azimuths, (_shadowed,))[0]
    return share


@dataclass(frozen=True, eq=False)
class _Strips:
    """The pixels of a mask in strips along an azimuth: strip by strip, each in its order.

    ``first`` and ``last`` are the ends of runs: neighbours in one strip with no gap.
    """

    strip: Float
    along: Float
    height: Float
    first: NDArray[np.intp]
    last: NDArray[np.intp]

    def seen(self, angle: float) -> Float:
        """Return the places along the azimuth where a viewer turned by `angle` sees the pixels."""
        places: Float = self.along * np.cos(angle) - self.height * np.sin(angle)
        return places


def _measured(
    height: Map,
    mask: Mask,
    angles: Sequence[float],
    azimuths: Sequence[float],
    measures: Sequence[Callable[[_Strips, float], float]],
) -> Float:
    """Return measures of each turned view, shape (measures, angles, azimuths)."""
    own_mask = check_mask(mask)
    own_height, own_mask = _cut_out(check_map(height, own_mask, "heights"), own_mask)
    complete = _completed(own_height, own_mask)
    turns = np.deg2rad(_checked_angles(angles))
    if not np.isfinite(azimuths).all():
        raise RelightlabError(f"expected azimuths in degrees, got {list(azimuths)}")
    measured = np.empty((len(measures), len(turns), len(azimuths)))
    for column, azimuth in enumerate(azimuths):
        strips = _strips(*_turned(complete, own_mask, float(azimuth)))
        for row, turn in enumerate(turns):
            measured[:, row, column] = [measure(strips, turn) for measure in measures]
    return measured


def _checked_angles(angles: Sequence[float]) -> Float:
    checked = np.asarray(angles, dtype=np.float64)
    if not ((checked >= 0) & (checked < 90)).all():
        raise RelightlabError(f"expected angles from 0 to below 90 degrees, got {list(angles)}")
    return checked


def _cut_out(height: Map, mask: Mask) -> tuple[Map, Mask]:
    """Return both maps cut to the mask, so that turned pixels lie alike wherever it is."""
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    return height[box], mask[box]


def _completed(height: Map, mask: Mask) -> Map:
    """Return heights everywhere, unknown ones from the nearest pixel; the median is zero."""
    known = np.isfinite(height)
    if not known.any():
        raise RelightlabError(
            f"none of the {np.count_nonzero(mask)} pixels of the mask has a finite height:"
            " give a height field that covers the mask"
        )
    nearest = distance_transform_edt(~known, return_distances=False, return_indices=True)
    complete: Map = height[tuple(nearest)] - np.median(height[known])
    return complete


def _turned(height: Map, mask: Mask, azimuth: float) -> tuple[Map, Mask]:
    """Return both maps turned in the picture so that the azimuth points right."""
    quarters, rest = divmod(azimuth, 90.0)
    if rest == 0:
        return np.rot90(height, -int(quarters)), np.rot90(mask, -int(quarters))
    cosine, sine = np.cos(np.deg2rad(azimuth)), np.sin(np.deg2rad(azimuth))
    matrix = np.array([[cosine, -sine], [sine, cosine]])
    size = np.array(mask.shape)
    turned_size = np.ceil(np.abs(matrix) @ size).astype(int) + 1
    place = {
        "matrix": matrix,
        "offset": (size - 1) / 2 - matrix @ (turned_size - 1) / 2,
        "output_shape": tuple(turned_size.tolist()),
    }
    heights: Map = affine_transform(height, order=1, mode="nearest", **place)
    # Half covered is inside: the nearest pixel would break slanted outlines into many runs.
    covered = affine_transform(mask.astype(np.float64), order=1, mode="grid-constant", **place)
    inside: Mask = covered >= min(0.5, covered.max())
    return heights, inside


def _strips(height: Map, mask: Mask) -> _Strips:
    rows, columns = np.nonzero(mask)
    begins = np.ones(rows.size + 1, dtype=bool)
    begins[1:-1] = (np.diff(rows) != 0) | (np.diff(columns) != 1)
    return _Strips(
        rows.astype(np.float64),
        columns.astype(np.float64),
        height[rows, columns],
        np.flatnonzero(begins[:-1]),
        np.flatnonzero(begins[1:]),
    )


def _differing(strips: _Strips, angle: float) -> float:
    """Return the area that the turned surface covers and the flat one does not, or vice versa."""
    seen, half = strips.seen(angle), 0.5 * np.cos(angle)
    flat = [
        strips.along[ends] * np.cos(angle) + side
        for ends, side in ((strips.first, -half), (strips.last, half))
    ]
    turned = [
        np.minimum.reduceat(seen, strips.first) - half,
        np.maximum.reduceat(seen, strips.first) + half,
    ]
    common = np.median(np.subtract(turned, flat))
    runs = np.stack([np.array(flat), np.array(turned) - common])  # (which, end, run)
    # Strips are laid end to end on one line, apart from one another.
    runs = runs + strips.strip[strips.first] * (np.ptp(runs) + 1.0)
    either = _covered(*np.concatenate(runs, axis=-1))
    differing = 2 * either - _covered(*runs[0]) - _covered(*runs[1])
    return max(float(differing), 0.0)


def _covered(low: Float, high: Float) -> float:
    """Return the length that intervals cover together."""
    order = np.argsort(low)
    start, end = low[order], high[order]
    reached = np.concatenate([[-np.inf], np.maximum.accumulate(end)[:-1]])
    return float(np.maximum(end - np.maximum(start, reached), 0.0).sum())


def _shadowed(strips: _Strips, angle: float) -> float:
    """Return the share of the pixels that face a light along the azimuth but do not see it."""
    seen = strips.seen(angle)
    # Every strip lies beyond the one before, so a sweep from the last forgets where it has been.
    seen = seen + strips.strip * (np.ptp(seen) + 1.0)
    nearest = np.minimum.accumulate(seen[::-1])[::-1][1:]
    this, following = seen[:-1], seen[1:]
    joined = np.ones(this.size, dtype=bool)
    joined[strips.last[:-1]] = False
    hidden = np.flatnonzero(joined & (this < following) & (nearest < following))
    low, high = this[hidden], following[hidden]
    parts = (high - np.maximum(nearest[hidden], low)) / (high - low)
    return float(parts.sum()) / seen.size


def _outline_unit(mask: Mask, azimuths: Sequence[float]) -> Float:
    """Return the area between two outlines one diameter apart, for each azimuth."""
    inside = np.asarray(mask, dtype=bool)
    # Ends of runs in a turned raster would count every step of a slanted outline.
    smooth = gaussian_filter(np.pad(inside.astype(np.float64), 6), OUTLINE_BLUR)
    down, right = np.gradient(smooth)
    turns = np.deg2rad(np.asarray(azimuths, dtype=np.float64))
    ends = [np.abs(np.cos(turn) * right - np.sin(turn) * down).sum() for turn in turns]
    diameter = 2 * np.sqrt(np.count_nonzero(inside) / np.pi)
    return np.array(ends, dtype=np.float64) * float(diameter)
