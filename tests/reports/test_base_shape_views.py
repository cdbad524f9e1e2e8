"""Tests of reports.base_shape_views: the generic-view check over the objects of a study."""

from __future__ import annotations

from dataclasses import replace

import pytest

from evaluation.generic_view_study import ANGLES
from reports.base_shape_run import BaseShapeStudy
from reports.base_shape_views import PART, SHAPES, view_figure, with_generic_view
from reports.base_shape_words import SHAPE_WORDS
from tests.evaluation.sirfs.fake_fits import diverging_fit
from tests.reports.small_result import OBJECTS
from tests.reports.small_study import FlatFits, study_document


def test_every_object_is_turned_on_three_shapes(small_study: BaseShapeStudy) -> None:
    """There is a row for each object, shape and angle; the flat fit moves no outline."""
    rows = small_study.document[PART]
    assert {(row["object"], row["shape"], row["angle"]) for row in rows} == {
        (name, shape, angle) for name in OBJECTS for shape in SHAPES for angle in ANGLES
    }
    assert len(rows) == len(OBJECTS) * len(SHAPES) * len(ANGLES)
    flat = [row for row in rows if row["shape"] == "sirfs"]
    assert max(row["outline_shift"] for row in flat) == pytest.approx(0.0, abs=1e-12)
    assert max(row["shadow_share"] for row in flat) == 0.0


def test_shapes_left_out_or_failed_are_not_turned(
    small_study: BaseShapeStudy, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A quick study and one whose fits diverge have the curves of the other shapes."""
    monkeypatch.setattr(FlatFits, "fit_images", diverging_fit)
    one = [row for row in small_study.document["objects"] if row["object"] == OBJECTS[0]]
    failed = with_generic_view(
        replace(small_study, document=small_study.document | {"objects": one})
    )
    assert {row["shape"] for row in failed.document[PART]} == {"contour", "ground-truth"}


def test_curves_have_the_words_of_the_set(small_study: BaseShapeStudy) -> None:
    """Curves are called what the table calls their shapes."""
    words = SHAPE_WORDS | {"ground-truth": "photometric stereo (reference)"}
    figure = view_figure(small_study.document, words)
    assert figure is not None
    assert figure.identifier == "generic-view-synthetic"
    assert figure.svg.count(">photometric stereo (reference)<") == 1
    assert "Turned by 15 degrees, contour (ours) moves its outline" in figure.description


def test_without_rows_there_is_no_figure() -> None:
    """A document without the check has no figure of it."""
    assert view_figure(study_document(), SHAPE_WORDS) is None
