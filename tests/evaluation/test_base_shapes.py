"""Tests of the base shapes of Table 2."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from datasets.model_parameters import shipped_parameters
from datasets.records import GroundTruth
from datasets.synthetic import Synthetic
from evaluation.base_shapes import (
    BASE_SHAPES,
    FITTED_SHAPES,
    ShapeRequest,
    filled_shape,
    steepened,
)
from shading_model.errors import RelightlabError
from shading_model.height_field import normals_of_slopes
from shading_model.object_model import CoarseShape
from tests.evaluation.sirfs.fake_fits import pretend


@pytest.fixture
def request_for(tiny_set: Synthetic) -> ShapeRequest:
    """What the shapes of a bear may be made of."""
    capture = tiny_set.load("bear", "laboratory")
    lit = tuple(one.photograph.image for one in tiny_set.lit_photographs("bear"))
    mean = np.mean(lit, axis=0)
    return ShapeRequest(tiny_set, capture, mean, lit, shipped_parameters())


@pytest.mark.parametrize("name", BASE_SHAPES)
def test_every_shape_is_known_on_the_mask_and_nowhere_else(
    name: str, request_for: ShapeRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Heights and unit normals are finite on the mask and NaN outside it; twice the same."""
    pretend(monkeypatch)
    shape = BASE_SHAPES[name](request_for)
    mask = request_for.mask
    assert np.array_equal(np.isfinite(shape.height), mask)
    assert np.array_equal(np.isfinite(shape.normals).all(axis=-1), mask)
    assert np.allclose(np.linalg.norm(shape.normals[mask], axis=-1), 1.0)
    again = BASE_SHAPES[name](request_for)
    assert np.array_equal(shape.height, again.height, equal_nan=True)


@pytest.mark.parametrize("name", ["contour", "flat", "sirfs", "sirfs-stereo"])
def test_no_rival_sees_the_truth(
    name: str, request_for: ShapeRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without any truth these shapes are the same; the others say that they need it."""
    pretend(monkeypatch)
    blind = dataclasses.replace(
        request_for, capture=dataclasses.replace(request_for.capture, truth=GroundTruth())
    )
    shapes = [BASE_SHAPES[name](request) for request in (request_for, blind)]
    assert np.array_equal(shapes[0].normals, shapes[1].normals, equal_nan=True)
    for needing in ("ground-truth", "kinect"):
        with pytest.raises(RelightlabError, match="true shape of bear in synthetic is not known"):
            BASE_SHAPES[needing](blind)


@pytest.mark.slow
def test_sirfs_sees_its_own_photographs(request_for: ShapeRequest) -> None:
    """SIRFS is fitted to the build image, SIRFS-stereo to the others, each to its own."""
    darker = dataclasses.replace(request_for, image=request_for.image**2)
    fewer = dataclasses.replace(request_for, photographs=request_for.photographs[:2])
    for name, other, same in (("sirfs", darker, fewer), ("sirfs-stereo", fewer, darker)):
        made = [BASE_SHAPES[name](request).height for request in (request_for, other, same)]
        assert not np.array_equal(made[0], made[1], equal_nan=True)
        assert np.array_equal(made[0], made[2], equal_nan=True)
    assert {"sirfs", "sirfs-stereo"} == set(FITTED_SHAPES)


def test_the_true_shape_is_the_truth_where_it_is_known(request_for: ShapeRequest) -> None:
    """Known normals are kept, and the rim gets those of its neighbours."""
    truth = request_for.capture.truth.normals
    assert truth is not None
    shape = BASE_SHAPES["ground-truth"](request_for)
    known = np.isfinite(truth).all(axis=-1)
    assert np.array_equal(shape.normals[known], truth[known])


def test_a_steeper_plane_has_steeper_normals() -> None:
    """A plane of slope 0.3 times 2 is a plane of slope 0.6, and times 1 the same."""
    height = np.tile(0.3 * np.arange(4.0), (3, 1))
    normals = normals_of_slopes(np.full((3, 4), 0.3), np.zeros((3, 4)))
    steeper = steepened(CoarseShape(height, normals), 2.0)
    assert np.allclose(steeper.height, 2 * height)
    assert np.allclose(steeper.normals, normals_of_slopes(np.full((3, 4), 0.6), np.zeros((3, 4))))


def test_unknown_pixels_get_what_the_nearest_known_has() -> None:
    """Values outside the mask are not used, and a shape without any value is refused."""
    mask = np.array([[True, True, True, False]])
    height = np.array([[np.nan, 2.0, np.nan, 9.0]])
    facing = np.where(np.isfinite(height)[..., None], [0.0, 0.0, 1.0], np.nan)
    filled = filled_shape(height, facing, mask)
    assert filled.height[0, :3].tolist() == [2.0, 2.0, 2.0]
    assert np.isnan(filled.height[0, 3])
    with pytest.raises(RelightlabError, match="not known anywhere on the mask"):
        filled_shape(np.full((1, 4), np.nan), facing, mask)


def test_a_sensor_reads_the_same_whatever_is_left_out(request_for: ShapeRequest) -> None:
    """Without a true albedo its light is reflected by the object as photographed, not as built."""
    truth = dataclasses.replace(request_for.capture.truth, albedo=None)
    request = dataclasses.replace(
        request_for, capture=dataclasses.replace(request_for.capture, truth=truth)
    )
    other = dataclasses.replace(request, image=request.image**2)
    heights = [BASE_SHAPES["kinect"](one).height for one in (request, other)]
    assert np.array_equal(*heights, equal_nan=True)
