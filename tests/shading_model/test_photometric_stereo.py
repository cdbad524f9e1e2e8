"""Photometric stereo on surfaces whose normals are known in closed form."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shading_model.arrays import Float, Mask, Normals
from shading_model.errors import RelightlabError
from shading_model.photometric_stereo import photometric_stereo

LIGHTS = np.array(
    [
        [0.4, 0.4, 0.8],
        [-0.4, 0.4, 0.8],
        [0.4, -0.4, 0.8],
        [-0.4, -0.4, 0.8],
        [0, 0, 1],
        [0.7, 0, 0.7],
    ]
)
LIGHTS /= np.linalg.norm(LIGHTS, axis=1, keepdims=True)
COLOUR = np.array([0.8, 0.5, 0.3])


def ball(side: int, reach: float = 0.9) -> tuple[Normals, Mask]:
    """The normals of a sphere, and the pixels within `reach` of its radius."""
    rows, columns = (np.mgrid[:side, :side] - (side - 1) / 2) / (side / 2)
    squared = rows**2 + columns**2
    upright = np.sqrt(np.maximum(0, 1 - squared))
    return np.stack([columns, -rows, upright], axis=-1), squared < reach**2


def pictures(normals: Normals, lights: Float) -> Float:
    """A Lambertian surface of one colour under each light, black where turned away."""
    return np.maximum(0, np.einsum("hwi,ki->khw", normals, lights))[..., None] * COLOUR


def degrees(found: Normals, truth: Normals, mask: Mask) -> Float:
    """The angles between normals on the mask."""
    cosine = np.clip(np.einsum("ni,ni->n", found[mask], truth[mask]), -1, 1)
    return np.degrees(np.arccos(cosine))


def test_a_matt_sphere_is_measured_exactly() -> None:
    """Normals and albedo come back to rounding, though much of the sphere lies in shadow."""
    normals, mask = ball(64)
    images = pictures(normals, LIGHTS)
    stereo = photometric_stereo(images, LIGHTS, mask)
    known = stereo.samples >= 3
    assert known[mask].mean() > 0.98
    known &= np.isfinite(stereo.normals).all(axis=-1)
    assert degrees(stereo.normals, normals, known).max() < 1e-4
    assert np.allclose(stereo.albedo[known], COLOUR)
    assert stereo.residual < 1e-8
    assert (images[:, mask] == 0).any()


def test_the_strength_of_a_light_is_its_length() -> None:
    """Lights of several strengths give the normals and the albedo of lights of one."""
    normals, mask = ball(32)
    strengths = np.array([[0.5], [1.0], [0.3], [0.9], [0.7], [0.6]])
    stereo = photometric_stereo(pictures(normals, strengths * LIGHTS), strengths * LIGHTS, mask)
    known = np.isfinite(stereo.normals).all(axis=-1)
    assert degrees(stereo.normals, normals, known).max() < 1e-4
    assert np.allclose(stereo.albedo[known], COLOUR)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_a_facet_of_any_orientation_is_found(seed: int) -> None:
    """A plane that all lights reach gives its normal, whichever way it faces."""
    generator = np.random.default_rng(seed)
    normal = np.array([*generator.uniform(-0.25, 0.25, 2), 1.0])
    normal /= np.linalg.norm(normal)
    facet = np.tile(normal, (2, 3, 1))
    mask = np.ones((2, 3), bool)
    stereo = photometric_stereo(pictures(facet, LIGHTS), LIGHTS, mask)
    assert (stereo.samples == len(LIGHTS)).all()
    assert degrees(stereo.normals, facet, mask).max() < 1e-4


def test_cast_shadows_are_left_out() -> None:
    """A bar of shadow, as black as stray light makes it, in a different place in each picture."""
    normals, mask = ball(64, reach=0.6)
    images = pictures(normals, LIGHTS)
    for k in range(len(LIGHTS)):
        images[k, :, 10 * k : 10 * k + 8] *= 0.05
    stereo = photometric_stereo(images, LIGHTS, mask)
    assert (stereo.samples[mask] < len(LIGHTS)).sum() > 200
    assert degrees(stereo.normals, normals, mask).max() < 1e-4


def test_saturated_samples_are_left_out() -> None:
    """A picture exposed too long is cut at one and told by the other five."""
    normals, mask = ball(64, reach=0.6)
    images = pictures(normals, LIGHTS)
    lights = LIGHTS * np.array([1, 1, 1, 1, 2, 1])[:, None]
    images[4] = np.minimum(1, 2 * images[4])
    stereo = photometric_stereo(images, lights, mask)
    assert (images[4][mask] == 1).any()
    assert degrees(stereo.normals, normals, mask).max() < 1e-4


def test_highlights_lose_their_say() -> None:
    """A highlight on one of twelve samples bends the normal by far less than least squares do."""
    turns = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    lights = np.column_stack([0.5 * np.cos(turns), 0.5 * np.sin(turns), np.full(12, np.sqrt(0.75))])
    facet, mask = np.tile([0.0, 0.0, 1.0], (1, 1, 1)), np.ones((1, 1), bool)
    images = pictures(facet, lights)
    images *= 1 + 0.005 * np.random.default_rng(1).normal(size=(12, 1, 1, 1))
    images[3] = 0.99
    plain = np.linalg.lstsq(lights, images[:, 0, 0].mean(axis=-1), rcond=None)[0]
    plain /= np.linalg.norm(plain)
    robust = photometric_stereo(images, lights, mask)
    assert degrees(plain[None, None], facet, mask)[0] > 5
    assert degrees(robust.normals, facet, mask)[0] < 1


def test_noise_bends_the_normals_by_its_own_size() -> None:
    """One per cent of noise gives about a degree, and a residual of about one per cent."""
    normals, mask = ball(64, reach=0.6)
    images = pictures(normals, LIGHTS)
    images = np.maximum(0, images + 0.005 * np.random.default_rng(2).normal(size=images.shape))
    stereo = photometric_stereo(images, LIGHTS, mask)
    assert degrees(stereo.normals, normals, mask).mean() < 1
    assert 0.001 < stereo.residual < 0.01


def test_unknown_pixels_are_nan() -> None:
    """Outside the mask, on black pixels and where only two lights reach, nothing is claimed."""
    normals, mask = ball(16, reach=0.6)
    images = pictures(normals, LIGHTS)
    images[:, 8, 8] = 0
    images[2:, 8, 9] = 0
    stereo = photometric_stereo(images, LIGHTS, mask)
    for unknown in (~mask, np.s_[8, 8], np.s_[8, 9]):
        assert np.isnan(stereo.normals[unknown]).all()
        assert np.isnan(stereo.albedo[unknown]).all()
    assert (stereo.samples[~mask] == 0).all()
    assert stereo.samples[8, 9] == 2


def test_gray_pictures_are_of_three_equal_colours() -> None:
    """Pictures (K, h, w) give what the same pictures repeated over the colours give."""
    normals, mask = ball(24)
    gray = pictures(normals, LIGHTS)[..., 0]
    one = photometric_stereo(gray, LIGHTS, mask)
    three = photometric_stereo(np.repeat(gray[..., None], 3, axis=-1), LIGHTS, mask)
    assert np.array_equal(one.normals, three.normals, equal_nan=True)
    assert np.array_equal(one.albedo, three.albedo, equal_nan=True)


def test_a_photograph_takes_less_than_a_second() -> None:
    """Fifty thousand pixels under twelve lights."""
    normals, mask = ball(280)
    lights = np.concatenate([LIGHTS, LIGHTS[:, [1, 0, 2]]])
    images = pictures(normals, lights)
    started = time.process_time()
    photometric_stereo(images, lights, mask)
    assert mask.sum() > 48_000
    assert time.process_time() - started < 1


COPLANAR = np.array([[0.6, 0, 0.8], [-0.6, 0, 0.8], [0, 0, 1.0], [0.28, 0, 0.96]])


@pytest.mark.parametrize(
    ("images", "directions", "words"),
    [
        (np.ones((5, 4, 4)) / 2, LIGHTS, "5 pictures but 6 light directions"),
        (np.ones((4, 4, 4)) / 2, COPLANAR, r"the 4 light directions span 2 of 3 dimensions"),
        (np.ones((2, 4, 4)) / 2, LIGHTS[:2], r"the 2 light directions span 2 of 3"),
        (np.ones((3, 4, 4)) / 2, np.tile([0, 0, 1.0], (3, 1)), r"span 1 of 3"),
        (np.ones((3, 4, 4)) / 2, np.zeros((3, 3)), r"span 0 of 3"),
        (np.ones((0, 4, 4)), np.zeros((0, 3)), r"the 0 light directions span 0 of 3"),
        (np.ones((6, 4, 4)), np.full((6, 3), np.nan), r"finite light directions of shape \(K, 3\)"),
        (np.ones((6, 4, 4)), LIGHTS[:, :2], r"of shape \(K, 3\), got \(6, 2\)"),
        (np.ones((4, 4)), LIGHTS, r"expected pictures of shape \(K, h, w\)"),
        (np.ones((6, 4, 4, 2)), LIGHTS, r"expected pictures of shape"),
        (np.ones((6, 4, 5)), LIGHTS, "the pictures are 5x4 pixels but their mask is 4x4"),
        (np.full((6, 4, 4), np.nan), LIGHTS, "NaN, infinite or negative"),
        (np.full((6, 4, 4), -0.1), LIGHTS, "NaN, infinite or negative"),
    ],
)
def test_what_cannot_be_solved_is_one_sentence(
    images: Float, directions: Float, words: str
) -> None:
    """Numbers that differ, lights in a plane, sizes and values that are wrong."""
    with pytest.raises(RelightlabError, match=words):
        photometric_stereo(images, directions, np.ones((4, 4), bool))


def test_an_empty_mask_is_refused() -> None:
    """There is nothing to measure."""
    with pytest.raises(RelightlabError, match="the mask is empty"):
        photometric_stereo(np.ones((6, 4, 4)), LIGHTS, np.zeros((4, 4), bool))
