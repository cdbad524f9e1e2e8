"""Tests of what models of the study of base shapes are built from."""

from __future__ import annotations

import numpy as np
import pytest

from datasets.records import Capture, GroundTruth, LitPhotograph, Photograph
from evaluation.study_variants import VARIANTS, leave_one_out
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics

MASK = np.ones((3, 4), dtype=bool)


def photographs(count: int) -> tuple[LitPhotograph, ...]:
    """Photographs whose grey level is a power of two, so that a sum tells which are in it."""
    return tuple(
        LitPhotograph(
            Photograph(np.full((3, 4, 3), 2.0**number), MASK, "thing", str(number)),
            LogHarmonics(np.zeros(9)),
        )
        for number in range(count)
    )


CAPTURE = Capture(Photograph(np.full((3, 4, 3), 0.25), MASK, "thing", "x"), GroundTruth(), "lab")


@pytest.mark.parametrize("name", VARIANTS)
def test_every_light_is_tested_once(name: str) -> None:
    """In each variant the builds together serve every light, and each of them once."""
    builds = VARIANTS[name].build(CAPTURE, photographs(5))
    assert sorted(light for build in builds for light in build.lights) == list(range(5))


@pytest.mark.parametrize("count", [2, 5, 10])
def test_leaving_one_out_uses_nothing_of_the_photograph_under_test(count: int) -> None:
    """The mean is that of all others, and a shape gets others only, half of them."""
    for build in leave_one_out(CAPTURE, photographs(count)):
        (light,) = build.lights
        others = 2.0**count - 1 - 2.0**light
        assert np.allclose(build.image, others / (count - 1))
        used = {float(np.log2(image[0, 0, 0])) for image in build.photographs}
        assert light not in used
        assert count // 2 <= len(used) <= -(-count // 2)


def test_two_fits_serve_all_lights() -> None:
    """The photographs that a shape may use are one of two halves."""
    halves = {
        tuple(image[0, 0, 0] for image in build.photographs)
        for build in leave_one_out(CAPTURE, photographs(10))
    }
    assert len(halves) == 2


def test_the_diffuse_variant_builds_from_the_diffuse_photograph() -> None:
    """Its image is that of the capture; the shape may use all the others."""
    (build,) = VARIANTS["diffuse"].build(CAPTURE, photographs(3))
    assert (build.image == 0.25).all()
    assert len(build.photographs) == 3


@pytest.mark.parametrize("name", VARIANTS)
def test_an_object_without_photographs_is_refused(name: str) -> None:
    """Nothing can be relit without photographs under known lights."""
    with pytest.raises(RelightlabError, match="no photographs under known lights"):
        list(VARIANTS[name].build(CAPTURE, ()))


def test_one_photograph_cannot_be_left_out() -> None:
    """Without a second photograph there is nothing to build from."""
    with pytest.raises(RelightlabError, match="needs at least two, got one"):
        list(leave_one_out(CAPTURE, photographs(1)))
