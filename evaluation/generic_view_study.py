"""The generic-view check (`fig:cube`) over the objects of a dataset: curves for each shape.

How far the outline moves as the view turns, and how much of the surface lies in its own shadow as
a light inclines, of whatever shapes are given: a true one, one from contour, one of SIRFS.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from shading_model.arrays import Float, Map, Mask
from shading_model.errors import RelightlabError, unknown_name
from shading_model.generic_view import generic_view

LARGEST_TURN = 15.0
"""Degrees up to which the paper's check turns the view."""
ANGLES = (0.0, 3.0, 6.0, 9.0, 12.0, LARGEST_TURN, 30.0, 45.0, 60.0)
"""Degrees. Those beyond the largest turn are for the light, which may come from anywhere."""
AZIMUTHS = tuple(45.0 * step for step in range(8))
"""Degrees from right, counter-clockwise; measures are means over them."""
MEASURES = ("outline_shift", "shadow_share")


class ObjectShape(NamedTuple):
    """One shape of one object.

    Parameters
    ----------
    object, shape : str
        Names.
    height : (h, w) array
        Pixels, larger is nearer.
    mask : (h, w) bool array
        The object's, the same for all its shapes.
    """

    object: str
    shape: str
    height: Map
    mask: Mask


@dataclass(frozen=True)
class GenericViewRow:
    """The measures of one shape of one object at one angle.

    Parameters
    ----------
    shape, object : str
    angle : float
        Degrees from the camera's direction to the turned view, or to the light.
    outline_shift : float
        In diameters of the object, see `shading_model.generic_view.outline_shift`.
    shadow_share : float
        Of the object's area, see `shading_model.generic_view.self_shadow_share`.
    """

    shape: str
    object: str
    angle: float
    outline_shift: float
    shadow_share: float


@dataclass(frozen=True, eq=False)
class GenericViewCurve:
    """One measure of one shape over the angle: quartiles over objects.

    Parameters
    ----------
    shape : str
    objects : int
        How many objects the shape was given for.
    angles, low, median, high : (a,) arrays
        Degrees, ascending; the first quartile, the median and the third.
    """

    shape: str
    objects: int
    angles: Float
    low: Float
    median: Float
    high: Float


def generic_view_rows(
    shapes: Iterable[ObjectShape | tuple[str, str, Map, Mask]],
    angles: Sequence[float] = ANGLES,
    azimuths: Sequence[float] = AZIMUTHS,
) -> tuple[GenericViewRow, ...]:
    """Return the measures of shapes, means over the azimuths.

    Shapes are taken one after the other, so that an iterator need hold only one.

    Parameters
    ----------
    shapes : iterable of ObjectShape
        Or of plain tuples (object, shape, height, mask).
    angles, azimuths : sequences of float
        Degrees.

    Returns
    -------
    tuple of GenericViewRow
        One for each shape and angle, in the order given.

    Raises
    ------
    RelightlabError
        If a shape cannot be measured (see `shading_model.generic_view.generic_view`), with the
        names of its object and itself; or if no azimuth is given.

    Examples
    --------
    >>> mask = np.ones((4, 6), bool)
    >>> (row,) = generic_view_rows([ObjectShape("card", "flat", np.zeros((4, 6)), mask)], [15])
    >>> row.object, row.angle, round(row.outline_shift, 12), row.shadow_share
    ('card', 15.0, 0.0, 0.0)
    """
    if not len(azimuths):
        raise RelightlabError("expected one azimuth or more to turn the view toward, got none")
    return tuple(row for shape in shapes for row in _rows(ObjectShape(*shape), angles, azimuths))


def _rows(
    one: ObjectShape, angles: Sequence[float], azimuths: Sequence[float]
) -> list[GenericViewRow]:
    try:
        view = generic_view(one.height, one.mask, angles, azimuths)
    except RelightlabError as fault:
        raise RelightlabError(f"shape {one.shape} of {one.object}: {fault}") from fault
    means = (view.outline_shift.mean(axis=1), view.shadow_share.mean(axis=1))
    return [
        GenericViewRow(one.shape, one.object, float(angle), float(shift), float(share))
        for angle, shift, share in zip(angles, *means, strict=True)
    ]


def generic_view_curves(
    rows: Iterable[GenericViewRow], measure: str
) -> tuple[GenericViewCurve, ...]:
    """Return quartiles over objects of one measure, a curve for each shape.

    Parameters
    ----------
    rows : iterable of GenericViewRow
        Every object of a shape at the same angles, once.
    measure : {"outline_shift", "shadow_share"}

    Returns
    -------
    tuple of GenericViewCurve
        In the order in which the shapes come first.

    Raises
    ------
    RelightlabError
        If the measure is unknown, or an object of a shape lacks an angle or has one twice.

    Examples
    --------
    >>> rows = [GenericViewRow("flat", str(i), 15.0, i, 0.0) for i in range(5)]
    >>> (curve,) = generic_view_curves(rows, "outline_shift")
    >>> curve.objects, curve.low, curve.median, curve.high
    (5, array([1.]), array([2.]), array([3.]))
    """
    if measure not in MEASURES:
        raise unknown_name("measure", measure, MEASURES)
    of_shape: dict[str, list[GenericViewRow]] = {}
    for row in rows:
        of_shape.setdefault(row.shape, []).append(row)
    return tuple(_curve(shape, own, measure) for shape, own in of_shape.items())


def _curve(shape: str, rows: Sequence[GenericViewRow], measure: str) -> GenericViewCurve:
    objects = {row.object for row in rows}
    values = {(row.object, row.angle): getattr(row, measure) for row in rows}
    angles = sorted({row.angle for row in rows})
    if not len(rows) == len(values) == len(objects) * len(angles):
        raise RelightlabError(
            f"expected every object of shape {shape} once at each of {len(angles)} angles, got"
            f" {len(rows)} rows of {len(objects)} objects"
        )
    table = np.array([[values[name, angle] for angle in angles] for name in objects])
    low, median, high = np.quantile(table, [0.25, 0.5, 0.75], axis=0)
    return GenericViewCurve(shape, len(objects), np.array(angles), low, median, high)
