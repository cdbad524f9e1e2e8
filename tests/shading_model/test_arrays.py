"""Checks that every public function makes on its arrays."""

from __future__ import annotations

import numpy as np
import pytest

from shading_model.arrays import check_image, check_map, check_mask
from shading_model.errors import RelightlabError

MASK = np.array([[True, True, False], [True, False, False]])


def test_a_mask_of_any_kind_becomes_boolean() -> None:
    """Numbers above zero select a pixel."""
    assert check_mask(np.array([[0, 255], [0.5, 0]])).tolist() == [[False, True], [True, False]]


@pytest.mark.parametrize(
    ("mask", "sentence"),
    [
        (np.zeros((3, 3)), "the mask is empty"),
        (np.zeros((0, 4)), "the mask is empty"),
        (np.ones((3, 3, 3)), r"expected a mask of shape \(h, w\), got shape \(3, 3, 3\)"),
        (np.ones(4), r"expected a mask of shape \(h, w\), got shape \(4,\)"),
    ],
)
def test_an_unusable_mask_is_refused(mask: np.ndarray, sentence: str) -> None:
    """An empty mask and one of another number of axes each get their sentence."""
    with pytest.raises(RelightlabError, match=sentence):
        check_mask(mask)


def test_a_gray_photograph_becomes_colour() -> None:
    """A gray image is repeated over three channels."""
    gray = np.arange(1.0, 7.0).reshape(2, 3)
    checked = check_image(gray, MASK)
    assert checked.shape == (2, 3, 3)
    assert (checked == gray[..., None]).all()


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        (np.nan, "1 NaN or infinite pixels inside the mask"),
        (np.inf, "1 NaN or infinite pixels inside the mask"),
        (-0.1, "1 negative pixels inside the mask"),
    ],
)
def test_one_bad_pixel_is_counted(value: float, sentence: str) -> None:
    """A NaN, infinite or negative pixel is refused inside the mask and ignored outside."""
    image = np.ones((2, 3, 3))
    image[1, 2, 0] = value
    assert check_image(image, MASK)[0, 0, 0] == 1
    image[0, 1, 2] = value
    with pytest.raises(RelightlabError, match=sentence):
        check_image(image, MASK)


def test_a_black_photograph_is_refused() -> None:
    """Light outside the mask does not help an object that is black all over."""
    image = np.ones((2, 3, 3))
    image[MASK] = 0
    with pytest.raises(RelightlabError, match="black all over the mask"):
        check_image(image, MASK)


def test_sizes_are_told_as_width_by_height() -> None:
    """A photograph of another size than its mask is refused with both sizes."""
    with pytest.raises(RelightlabError, match="photograph is 3x2 pixels but its mask is 2x3"):
        check_image(np.ones((2, 3, 3)), np.ones((3, 2), bool))


@pytest.mark.parametrize("shape", [(2, 3, 4), (2, 3, 1), (6,), (2, 3, 3, 1)])
def test_other_numbers_of_channels_are_refused(shape: tuple[int, ...]) -> None:
    """Alpha channels and stray axes are not guessed about."""
    with pytest.raises(RelightlabError, match=r"expected an image of shape \(h, w, 3\) or"):
        check_image(np.ones(shape), MASK)


def test_a_map_is_nan_outside_the_mask() -> None:
    """The caller's array is left alone and its copy masked."""
    given = np.ones((2, 3, 3))
    checked = check_map(given, MASK, "normals", 3)
    assert (given == 1).all()
    assert np.isnan(checked[~MASK]).all()
    assert (checked[MASK] == 1).all()


def test_a_map_of_another_size_is_refused() -> None:
    """The sentence names the map, its symbolic shape and the numbers."""
    with pytest.raises(
        RelightlabError,
        match=r"expected normals of shape \(h, w, 3\) = \(2, 3, 3\), got \(2, 3\)",
    ):
        check_map(np.ones((2, 3)), MASK, "normals", 3)
    with pytest.raises(RelightlabError, match=r"expected heights of shape \(h, w\) = \(2, 3\)"):
        check_map(np.ones((3, 2)), MASK, "heights")
