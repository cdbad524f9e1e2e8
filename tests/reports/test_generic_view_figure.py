"""Tests of reports.generic_view_figure: curves as a plot, and in words."""

from __future__ import annotations

import pytest

from evaluation.generic_view_study import ANGLES, GenericViewRow
from reports.generic_view_figure import SHAPE_LINES, generic_view_figure
from reports.style import PURPLE
from shading_model.errors import RelightlabError


def rows(shapes: tuple[str, ...], objects: int = 5) -> list[GenericViewRow]:
    """Return rows in which an object's measures grow with its number and the angle."""
    return [
        GenericViewRow(shape, f"object {i}", angle, i * angle / 1500, i * angle / 6000)
        for shape in shapes
        for i in range(objects)
        for angle in ANGLES
    ]


def test_figure_tells_its_curves_in_words() -> None:
    """The description has median and quartiles at the largest turn, and at the largest angle."""
    figure = generic_view_figure(rows(("contour", "sirfs")))
    assert figure.identifier == "generic-view"
    for shape in ("contour", "sirfs"):
        assert (
            f"Turned by 15 degrees, {shape} moves its outline by 2.00 (middle half 1.00 to 3.00)"
            " percent of the diameter."
        ) in figure.description
        assert (
            f"{shape} casts shadows on 0.50 (middle half 0.25 to 0.75) percent of itself at 15"
            " degrees and 2.00 (middle half 1.00 to 3.00) percent of itself at 60 degrees."
        ) in figure.description
    assert "(number: 5)" in figure.caption


def test_every_shape_has_its_own_colour_and_name() -> None:
    """Each shape of the study, and one that is not, is in the legend and in its own colour."""
    svg = generic_view_figure(rows((*SHAPE_LINES, "puffball"))).svg
    assert svg.startswith("<svg")
    for name in (*SHAPE_LINES, "puffball"):
        assert svg.count(f">{name}</text>") == 1
    lines = list(SHAPE_LINES.values())
    assert len(set(lines)) == len({mark for mark, _ in lines}) == len({c for _, c in lines})
    assert svg.count(PURPLE) > 2


def test_figure_is_the_same_when_drawn_again() -> None:
    """The same rows give the same bytes, and an identifier of one's own is used throughout."""
    own = rows(("contour",))
    assert generic_view_figure(own).svg == generic_view_figure(own).svg
    assert 'id="second-' in generic_view_figure(own, "second").svg


def test_small_angles_alone_and_one_object_serve() -> None:
    """Without angles beyond the turned views, or with one object, there is a figure too."""
    near = [row for row in rows(("flat",), 1) if row.angle <= 15]
    figure = generic_view_figure(near)
    assert "percent of itself at 15 degrees." in figure.description
    assert generic_view_figure(near[:1]).svg.startswith("<svg")
    uneven = generic_view_figure([*rows(("contour",), 3), *rows(("sirfs",), 2)])
    assert "(number: 2 to 3)" in uneven.caption


def test_rows_without_turned_views_are_refused() -> None:
    """No rows, or none at the angles of the check, is told in a sentence."""
    with pytest.raises(RelightlabError, match="expected measures of views turned by up to 15 deg"):
        generic_view_figure([row for row in rows(("flat",)) if row.angle > 15])
