"""Tests of reports.base_shape_gallery: relit pictures on every shape, and lights beside them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reports.base_shape_gallery import above_sphere, picture_figures, spread_over_errors
from reports.base_shape_run import BaseShapeStudy
from reports.base_shape_words import SHAPE_WORDS
from reports.figures import PanelFigure
from shading_model.illumination import LogHarmonics
from tests.evaluation.sirfs.fake_fits import diverging_fit
from tests.reports.small_result import OBJECTS
from tests.reports.small_study import FlatFits, study_document


@pytest.fixture(scope="module")
def figures(small_study: BaseShapeStudy) -> tuple[PanelFigure, PanelFigure]:
    """The gallery and the lights of the small study."""
    return picture_figures(small_study, SHAPE_WORDS)


def test_every_object_is_relit_on_every_shape(figures: tuple[PanelFigure, PanelFigure]) -> None:
    """Above, the photograph and five relightings; below, the light and five errors."""
    gallery, _ = figures
    assert {row.title.split(",")[0] for row in gallery.rows} == set(OBJECTS)
    called = ["contour", "Kinect (simulated)", "SIRFS", "SIRFS-stereo", "ground truth"]
    for row in gallery.rows:
        above, below = row.panels[: row.columns], row.panels[row.columns :]
        assert [one.caption for one in above] == ["photograph", *called]
        assert [one.note for one in below[1:]] == called
        assert all(one.note.endswith(" %") for one in above[1:])
        assert len({one.description for one in row.panels}) == len(row.panels) == 12
        assert row.scales[0].limit > 0


def test_lights_differ_from_object_to_object(figures: tuple[PanelFigure, PanelFigure]) -> None:
    """The objects are not all shown under one light."""
    assert len({row.title.split(", ")[1] for row in figures[0].rows}) == 3


def test_every_light_stands_below_its_photograph(figures: tuple[PanelFigure, PanelFigure]) -> None:
    """There is a panel for each of the ten photographs, higher than wide for its sphere."""
    objects, lights = figures[1].rows
    assert [one.caption for one in objects.panels] == list(OBJECTS)
    assert [one.caption for one in lights.panels] == [f"light {k}" for k in range(1, 11)]
    for one in lights.panels:
        assert one.height > objects.panels[0].height
    assert len({one.source for one in lights.panels}) == 10


def test_a_shape_that_fails_is_left_out(
    small_study: BaseShapeStudy, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where a fit diverges, the other shapes are shown."""
    monkeypatch.setattr(FlatFits, "fit_images", diverging_fit)
    gallery, _ = picture_figures(small_study, SHAPE_WORDS)
    assert [row.columns for row in gallery.rows] == [4, 4, 4]


def test_quick_studies_show_the_flat_shape(small_study: BaseShapeStudy) -> None:
    """With room for it, the flat shape is in the gallery too."""
    parts = {
        part: [row for row in small_study.document[part] if not row["shape"].startswith("sirfs")]
        for part in ("rows", "objects")
    }
    quick = replace(small_study, document=small_study.document | parts)
    gallery, _ = picture_figures(quick, SHAPE_WORDS)
    assert [one.caption for one in gallery.rows[0].panels[:5]][-1] == "flat"


def test_objects_are_spread_over_their_errors() -> None:
    """Lowest, median and highest error are taken; of one, the median."""
    document = study_document(objects=9)
    names = [f"object {number:02d}" for number in (0, 4, 8)]
    assert spread_over_errors(document, 3) == tuple(names)
    assert spread_over_errors(document, 1) == (names[1],)
    assert len(spread_over_errors(study_document(objects=2), 3)) == 2


def test_sphere_is_lit_below_the_picture() -> None:
    """The picture stays as it is, and the sphere is brighter where its light is."""
    picture = np.full((20, 40, 4), 255, np.uint8)
    right = above_sphere(picture, LogHarmonics(np.array([0, 0, 0, 1.0, 0, 0, 0, 0, 0])))
    assert np.array_equal(right[:20], picture)
    sphere = right[20:].astype(float)
    inside = sphere[..., 3] > 0
    brightness = np.where(inside, sphere[..., :3].mean(axis=-1), np.nan)
    assert np.nanmean(brightness[:, 20:]) > np.nanmean(brightness[:, :20])
