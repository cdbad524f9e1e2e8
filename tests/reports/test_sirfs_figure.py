"""Tests of reports.sirfs_figure: a fit beside the truth, as far as the truth is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from datasets.records import Capture, GroundTruth
from reports.sirfs_figure import significant, sirfs_figure
from shading_model.errors import RelightlabError
from tests.reports.fake_fits import true_fit
from tests.reports.small_result import SmallResult, small_result

__all__ = ["small_result"]


@pytest.fixture(scope="module")
def capture(small_result: SmallResult) -> Capture:
    """A small object in the laboratory."""
    return small_result.dataset.load("cup", "laboratory")


@pytest.mark.parametrize("channels", [1, 3])
def test_fit_and_truth_have_the_same_pictures(capture: Capture, channels: int) -> None:
    """The truth as a fit, in colour or gray, has the true pictures and errors of zero."""
    figure = sirfs_figure(true_fit(capture, channels), capture)
    fitted, true, fitted_shape, true_shape = (row.panels for row in figure.rows)
    assert [one.caption for one in fitted[1:]] == [
        *("albedo, fitted", "shading, fitted", "light, fitted")
    ]
    assert len(true) == len(fitted_shape) == len(true_shape) == 4
    for ours, theirs in zip((*fitted[1:], *fitted_shape), (*true[1:], *true_shape), strict=True):
        assert ours.source == theirs.source
        assert ours.caption.replace("fitted", "true") == theirs.caption
    notes = [one.note.split()[-1] for one in (*fitted, *fitted_shape) if one.note]
    assert len(notes) == 5
    assert all(float(note) < 1e-6 for note in notes)


def test_parts_of_the_truth_may_be_unknown(capture: Capture) -> None:
    """Without a truth there are the fit's own pictures, and no error."""
    fit = true_fit(capture)
    figure = sirfs_figure(fit, replace(capture, truth=GroundTruth()))
    assert [row.title for row in figure.rows] == ["cup: fitted", "cup: fitted shape"]
    assert all(one.note == "" for row in figure.rows for one in row.panels)
    shapeless = replace(capture.truth, height=None, normals=None, illumination=None)
    rows = sirfs_figure(fit, replace(capture, truth=shapeless)).rows
    assert [len(row.panels) for row in rows] == [4, 3, 4]


def test_shadows_in_the_albedo_are_shown(capture: Capture) -> None:
    """Where the fitted albedo is too dark, the map of both albedos is orange: red above blue."""
    fit = true_fit(capture)
    half = np.zeros(fit.mask.shape, dtype=bool)
    half[:, : half.shape[1] // 2] = True
    darker = np.where(half[..., None], fit.albedo / 3, fit.albedo)
    whole, spoiled = (
        sirfs_figure(one, capture).rows[1] for one in (fit, replace(fit, albedo=darker))
    )
    assert whole.panels[0].source != spoiled.panels[0].source
    assert spoiled.scales[0].limit >= np.log(3) / 2


def test_another_photograph_is_refused(capture: Capture) -> None:
    """A fit beside a photograph of another size is a fault that names both sizes."""
    fit = true_fit(capture)
    smaller = replace(fit, mask=fit.mask[1:])
    with pytest.raises(RelightlabError, match=r"fit is of shape .* but its photograph of"):
        sirfs_figure(smaller, capture)


def test_numbers_have_three_digits() -> None:
    """Large and small numbers keep three digits and no exponent; what is unknown is a dash."""
    assert [significant(v) for v in (1234.5, 1.0, 0.05, 0.0)] == ["1230", "1.00", "0.0500", "0.00"]
    assert significant(1234.5, 4) == "1234"
    assert significant(float("nan")) == significant(None) == "\u2013"
