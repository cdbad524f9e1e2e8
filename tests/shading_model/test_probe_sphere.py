"""Circles fitted to the masks of spheres."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from shading_model.arrays import Mask
from shading_model.errors import RelightlabError
from shading_model.probe_sphere import ProbeSphere, fit_sphere
from tests.shading_model.probe_pictures import CENTRE, RADIUS, SHAPE, sphere_mask

places = st.tuples(st.floats(40, 41), st.floats(50, 51))


@given(places, st.floats(8, 36))
@example((40.0, 50.0), 12.0)
def test_a_disk_gives_its_circle(centre: tuple[float, float], radius: float) -> None:
    """Centre and radius are right to a fraction of a pixel, and the deviation is the staircase.

    A disk whose rim only touches pixel centres, as in the example, has the worst radius: 0.21.
    """
    sphere = fit_sphere(sphere_mask(centre=centre, radius=radius))
    assert np.hypot(sphere.row - centre[0], sphere.column - centre[1]) < 0.25
    assert abs(sphere.radius - radius) < 0.3
    assert sphere.deviation * sphere.radius < 0.4
    assert not sphere.is_cut


@given(places, st.floats(20, 36), st.floats(0.0, 0.9))
def test_a_cut_sphere_gives_its_circle(
    centre: tuple[float, float], radius: float, cut: float
) -> None:
    """A sphere beyond the picture's right edge is found from the outline that is seen."""
    whole = sphere_mask(centre=centre, radius=radius)
    sphere = fit_sphere(whole[:, : int(centre[1] + (1 - cut) * radius * 0.9)])
    assert sphere.is_cut
    assert np.hypot(sphere.row - centre[0], sphere.column - centre[1]) < 0.8
    assert abs(sphere.radius - radius) < 0.6


def test_normals_are_those_of_a_sphere() -> None:
    """Unit, x right and y up from the centre, NaN off the circle."""
    normals = ProbeSphere(*CENTRE, RADIUS).normals(SHAPE)
    inside = sphere_mask()
    np.testing.assert_allclose(np.linalg.norm(normals[inside], axis=-1), 1.0, atol=1e-12)
    assert np.isnan(normals[~inside]).all()
    rows, columns = np.nonzero(inside)
    np.testing.assert_allclose(normals[inside][:, 0], (columns - CENTRE[1]) / RADIUS, atol=1e-12)
    np.testing.assert_allclose(normals[inside][:, 1], (CENTRE[0] - rows) / RADIUS, atol=1e-12)
    assert (normals[inside][:, 2] >= 0).all()


@pytest.mark.parametrize(("radius", "border", "width"), [(38.0, 0.05, 1.9), (10.0, 0.05, 1.5)])
def test_the_ring_at_the_outline_is_left_out(radius: float, border: float, width: float) -> None:
    """Inner pixels keep their distance: a share of the radius, and a pixel and a half at least."""
    sphere = ProbeSphere(*CENTRE, radius)
    inner = sphere.inner_pixels(np.ones(SHAPE, bool), border)
    np.testing.assert_array_equal(inner, sphere_mask(radius=radius - width))
    assert not sphere.inner_pixels(np.zeros(SHAPE, bool), border).any()


def test_holes_do_not_move_the_circle() -> None:
    """A spot taken out of the mask changes nothing but the inner pixels."""
    mask = sphere_mask()
    holed = mask.copy()
    holed[30:40, 50:60] = False
    assert fit_sphere(holed) == fit_sphere(mask)
    assert not fit_sphere(holed).inner_pixels(holed)[30:40, 50:60].any()


def with_stick() -> Mask:
    """Return a sphere on the stick that holds it."""
    mask = sphere_mask(radius=25)
    mask[60:88, 58:66] = True
    return mask


@pytest.mark.parametrize(
    ("mask", "words"),
    [
        (sphere_mask(flattening=0.1), "is not round: its outline is off its circle by 3.7 %"),
        (with_stick(), "is not round: its outline is off"),
        (np.pad(np.ones((50, 50), bool), 20), "is not round: its outline is off"),
        (np.pad(sphere_mask()[:, :62], ((0, 0), (0, 9))), "is not round: its outline is off"),
        (np.concatenate([sphere_mask(), sphere_mask()], axis=1), "is not round: its outline"),
        (~sphere_mask()[:, 30:90], "it differs from the disk in its outline"),
        (~sphere_mask(), "fills the picture"),
        (sphere_mask()[:, :40], "the picture cuts the sphere"),
        (np.ones((9, 9), bool), "fills the picture"),
        (np.zeros((9, 9), bool), "the mask is empty"),
        (np.ones((9, 9, 3), bool), "expected a mask of shape (h, w)"),
    ],
)
def test_masks_of_no_sphere_are_refused(mask: Mask, words: str) -> None:
    """What is not round, or shows too little, gets one sentence with what was measured."""
    with pytest.raises(RelightlabError, match=re.escape(words)):
        fit_sphere(mask)


def test_roundness_is_a_limit_of_ones_own() -> None:
    """A flattened mask passes where more deviation is allowed, and says how much there is."""
    sphere = fit_sphere(sphere_mask(flattening=0.1), roundness=0.05)
    assert 0.03 < sphere.deviation < 0.045
