"""Tests of reports.base_shape_figure: the bars of Table 2, and the same in words."""

from __future__ import annotations

import numpy as np
import pytest

from reports.base_shape_figure import base_shape_figure
from reports.base_shape_words import SHAPE_WORDS
from reports.generic_view_figure import SHAPE_LINES
from tests.reports.small_study import BOUNDS, PAPERS, study_document


def test_figure_names_shapes_objects_and_rules() -> None:
    """Default stands above oracle; shapes are in the legend and objects under the bars."""
    svg = base_shape_figure(study_document(), SHAPE_WORDS).svg
    for words in (*(SHAPE_WORDS[shape] for shape in {**PAPERS, **BOUNDS}), "object 07"):
        assert svg.count(f">{words}<") == 1
    assert svg.index(">Default weights, (1, 1)<") < svg.index(">Oracle weights<")
    assert "Regression" not in svg


def test_every_object_has_a_bar_of_each_shape() -> None:
    """Two rules of twelve objects, their mean and the legend make 27 bars of each colour."""
    svg = base_shape_figure(study_document(), SHAPE_WORDS).svg
    for shape in PAPERS:
        assert svg.count(f"fill: {SHAPE_LINES[shape][1]}") == 2 * (12 + 1) + 1


def test_description_has_the_means() -> None:
    """Who cannot see the figure reads every mean of the published rules."""
    figure = base_shape_figure(study_document(), SHAPE_WORDS)
    assert "Oracle weights, mean error: contour (ours) 0.0300, Kinect (simulated) 0.0310" in (
        figure.description
    )
    assert figure.identifier == "shaperes-mit-berkeley"


@pytest.mark.parametrize("objects", [1, 2, 3])
def test_few_objects_have_a_figure(objects: int) -> None:
    """One object has no interval, and a figure all the same."""
    document = study_document(objects=objects)
    assert base_shape_figure(document, SHAPE_WORDS).svg.startswith("<svg")


def test_shapes_left_out_or_failed_leave_no_bar() -> None:
    """A quick run shows what it has; a shape that failed has a place but no number."""
    quick = base_shape_figure(study_document({"contour": 0.02, **BOUNDS}), SHAPE_WORDS)
    assert SHAPE_LINES["sirfs"][1] not in quick.svg
    failed = study_document()
    for part in ("rows", "objects"):
        for row in failed[part]:
            if row["shape"] == "sirfs":
                row |= {"imse": None, "relative_imse": None, "low": None, "high": None}
    assert "SIRFS not measured" in base_shape_figure(failed, SHAPE_WORDS).description


def test_figure_is_the_same_when_drawn_again() -> None:
    """The same document gives the same bytes, and sets have identifiers of their own."""
    document = study_document()
    figures = [base_shape_figure(document, SHAPE_WORDS).svg for _ in range(2)]
    assert figures[0] == figures[1]
    other = base_shape_figure(study_document(dataset="psm-uw"), SHAPE_WORDS)
    assert 'id="shaperes-psm-uw-' in other.svg


def test_unknown_errors_of_all_are_borne() -> None:
    """Where nothing was measured there are empty axes, not a fault."""
    document = study_document({"contour": np.nan, "flat": np.nan})
    assert base_shape_figure(document, SHAPE_WORDS).svg.startswith("<svg")
