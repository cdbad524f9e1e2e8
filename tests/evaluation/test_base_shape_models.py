"""Tests of evaluation.base_shape_models: what models share, and pictures of what is measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from datasets.model_parameters import shipped_parameters
from datasets.own_folder import OwnFolder
from datasets.synthetic import Synthetic
from evaluation.base_shape_models import BaseShapeContext, StudyBuild, study_builds
from evaluation.photograph_cells import photograph_cell, relit_as_photographed
from shading_model.errors import RelightlabError
from shading_model.object_model import Weights
from tests.datasets.own_set import write_object


@pytest.fixture(scope="module")
def context(tiny_set: Synthetic) -> BaseShapeContext:
    """The tiny synthetic set."""
    return BaseShapeContext(tiny_set, shipped_parameters())


@pytest.fixture(scope="module")
def build(context: BaseShapeContext) -> StudyBuild:
    """The cup, built from the mean of its photographs."""
    (one,) = study_builds(context, "cup")
    return one


def test_models_differ_in_their_base_shape_alone(build: StudyBuild) -> None:
    """Albedo and geometric detail are the same on every shape; residual and normals are not."""
    contour, flat = (build.model(build.shape(name)) for name in ("contour", "flat"))
    for part in ("albedo", "geometric_detail"):
        assert np.array_equal(getattr(contour, part), getattr(flat, part), equal_nan=True)
    for part in ("normals", "parametric_residual"):
        assert not np.array_equal(getattr(contour, part), getattr(flat, part), equal_nan=True)


def test_builds_of_a_variant_cover_every_light_once(context: BaseShapeContext) -> None:
    """The mean serves all lights in one build; leave-one-out has a build for each."""
    for variant, count in (("mean", 1), ("leave-one-out", 10)):
        builds = study_builds(context, "cup", variant)
        assert len(builds) == count
        lights = [light for one in builds for light in one.images.lights]
        assert sorted(lights) == list(range(10))


def test_heights_follow_the_variant(context: BaseShapeContext, build: StudyBuild) -> None:
    """Twice the height is twice the height."""
    (tall,) = study_builds(context, "cup", "double-height")
    for name in ("contour", "ground-truth"):
        expected = 2 * build.shape(name).height
        np.testing.assert_allclose(tall.shape(name).height, expected)


@pytest.mark.parametrize("match_exposure", [True, False])
@pytest.mark.parametrize("channels", ["gray", "color"])
def test_picture_has_the_error_that_is_measured(
    build: StudyBuild, channels: str, match_exposure: bool
) -> None:
    """The squared difference of the relit picture, best scaled, is the cell's error."""
    model, lit = build.model(build.shape("contour")), build.lit[3]
    weights = Weights(0.7, -0.3)
    image = relit_as_photographed(model, lit.illumination, weights, match_exposure=match_exposure)
    cell = photograph_cell(
        *(model, lit.photograph.image, lit.illumination, channels), match_exposure=match_exposure
    )
    ours, true = image[build.mask], lit.photograph.image[build.mask]
    if channels == "gray":
        ours, true = ours.mean(axis=-1), true.mean(axis=-1)
    scale = max((ours * true).sum() / (ours**2).sum(), 0.0)
    assert cell.error(weights) == pytest.approx(((scale * ours - true) ** 2).mean(), rel=1e-9)
    assert np.isnan(image[~build.mask]).all()


def test_unknown_names_are_refused(context: BaseShapeContext, build: StudyBuild) -> None:
    """A shape or a variant that does not exist is told with its nearest name."""
    with pytest.raises(RelightlabError, match="Did you mean 'contour'"):
        build.shape("contuor")
    with pytest.raises(RelightlabError, match="Did you mean 'mean'"):
        study_builds(context, "cup", "maen")


def test_a_set_of_ones_own_is_built_in_its_own_setting(
    context: BaseShapeContext, tmp_path: Path
) -> None:
    """A set has a laboratory, or is taken in its first setting, with all its lights."""
    assert context.setting == "laboratory"
    write_object(tmp_path / "ball", lit=3)
    own = replace(context, dataset=OwnFolder(tmp_path))
    assert own.setting == "photograph"
    (build,) = study_builds(own, "ball")
    assert build.images.lights == (0, 1, 2)
    assert np.isfinite(build.model(build.shape("contour")).albedo[build.mask]).all()
