"""Tests of evaluation.generic_view_study: means over azimuths, quartiles over objects."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from evaluation.generic_view_study import (
    ANGLES,
    AZIMUTHS,
    GenericViewRow,
    ObjectShape,
    generic_view_curves,
    generic_view_rows,
)
from shading_model.errors import RelightlabError
from shading_model.generic_view import outline_shift, self_shadow_share
from shading_model.object_model import contour_base
from tests.example_objects import disk, parameters


def bumpy(object_name: str, bump: float) -> ObjectShape:
    """Return a disk with a bump at its end, which stands out when the view turns."""
    mask = disk(40)
    height = np.zeros(mask.shape)
    height[15:25, 30:] = bump
    return ObjectShape(object_name, "bumpy", height, mask)


def test_rows_are_means_over_azimuths() -> None:
    """Every shape has one row for each angle, in order, with the means over the azimuths."""
    shapes = [bumpy("mug", 9.0), bumpy("jug", 4.0)]
    rows = generic_view_rows(shapes, [0, 15, 45])
    assert [(row.object, row.angle) for row in rows] == [
        (name, angle) for name in ("mug", "jug") for angle in (0.0, 15.0, 45.0)
    ]
    of_jug = shapes[1].height, shapes[1].mask, [45], AZIMUTHS
    assert rows[5].outline_shift == pytest.approx(float(outline_shift(*of_jug).mean()))
    assert rows[5].shadow_share == pytest.approx(float(self_shadow_share(*of_jug).mean()))
    assert rows[2].shadow_share > rows[5].shadow_share > 0


def test_shapes_are_taken_one_by_one() -> None:
    """A shape is asked for when the last one is measured, so that not all need be held."""

    def shapes() -> Iterator[ObjectShape]:
        yield bumpy("mug", 3.0)
        yield bumpy("jug", 3.0)._replace(mask=np.ones((2, 2), dtype=bool))
        pytest.fail("a third shape was asked for before the second was measured")

    with pytest.raises(RelightlabError, match="shape bumpy of jug: expected heights of shape"):
        generic_view_rows(shapes(), [15], [0])


def test_plain_tuples_serve() -> None:
    """Object, shape, height and mask in a plain tuple give the same rows."""
    named = bumpy("mug", 3.0)
    assert generic_view_rows([tuple(named)]) == generic_view_rows([named])


def test_contour_shape_lies_below_a_rougher_one() -> None:
    """The shape from contour moves its outline and shades itself less than one with a bump."""
    mask = disk(40)
    contour = ObjectShape("mug", "contour", contour_base(mask, parameters()).height, mask)
    rows = generic_view_rows([contour, bumpy("mug", 9.0)])
    for smooth, rough in zip(rows[: len(ANGLES)], rows[len(ANGLES) :], strict=True):
        assert smooth.outline_shift <= rough.outline_shift + 1e-12
        assert smooth.shadow_share <= rough.shadow_share + 1e-12


def five_rows() -> list[GenericViewRow]:
    """Return rows of five objects at two angles, the objects in no order."""
    return [
        GenericViewRow("sirfs", f"object {i}", angle, i * angle, float(i))
        for i in (3, 0, 4, 1, 2)
        for angle in (15.0, 5.0)
    ]


def test_curves_are_quartiles_in_the_order_of_angles() -> None:
    """A curve holds the three quartiles over objects at ascending angles, for each shape."""
    one_more = GenericViewRow("contour", "object 0", 5.0, 1.0, 2.0)
    curve, single = generic_view_curves([*five_rows(), one_more], "outline_shift")
    assert (curve.shape, curve.objects) == ("sirfs", 5)
    assert curve.angles.tolist() == [5.0, 15.0]
    assert np.array_equal(
        [curve.low, curve.median, curve.high], [[5.0, 15.0], [10.0, 30.0], [15.0, 45.0]]
    )
    assert (single.shape, single.objects, single.median.tolist()) == ("contour", 1, [1.0])
    shares = generic_view_curves(five_rows(), "shadow_share")[0]
    assert shares.high.tolist() == [3.0, 3.0]


@pytest.mark.parametrize("change", ["lacking", "twice", "replaced"])
def test_curves_need_every_object_once_at_every_angle(change: str) -> None:
    """An object that lacks an angle or has one twice is told, as quartiles would mix objects."""
    rows = five_rows()
    changed = {
        "lacking": rows[:-1],
        "twice": [*rows, rows[0]],
        "replaced": [*rows[:-1], replace(rows[0], outline_shift=1.0)],
    }[change]
    with pytest.raises(RelightlabError, match="every object of shape sirfs once at each of 2"):
        generic_view_curves(changed, "outline_shift")


def test_unknown_measure_is_told() -> None:
    """A measure that does not exist is refused with those that do."""
    with pytest.raises(RelightlabError, match=r"Unknown measure 'shadow'\. Did you mean 'shadow_s"):
        generic_view_curves(five_rows(), "shadow")


def test_fault_names_its_shape_and_object() -> None:
    """A height field without heights is told with the names of its object and shape."""
    broken = bumpy("mug", np.nan)._replace(height=np.full((40, 40), np.nan))
    with pytest.raises(RelightlabError, match=r"^shape bumpy of mug: none of the .* finite height"):
        generic_view_rows([broken])


def test_no_azimuth_is_refused() -> None:
    """A mean over no direction is refused."""
    with pytest.raises(RelightlabError, match="expected one azimuth or more"):
        generic_view_rows([bumpy("mug", 1.0)], [15], [])
