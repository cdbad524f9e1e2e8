"""Tests of photographs made ready for a model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from datasets.photograph_files import MARGIN, load_photograph, saturation_notice
from datasets.records import Photograph
from shading_model.errors import RelightlabError
from tests.example_objects import disk, painted, photograph_and_mask, write_picture


def deep(values: np.ndarray) -> np.ndarray:
    """Return values in [0, 1] with sixteen bits."""
    return np.round(65535 * values).astype(np.uint16)


def white(mask: np.ndarray) -> np.ndarray:
    """Return a mask as an 8-bit picture."""
    return np.uint8(255) * mask.astype(np.uint8)


def test_an_ordinary_photograph_is_taken_as_it_is(tmp_path: Path) -> None:
    """A small photograph keeps its size and gets no notice."""
    photograph, notice = load_photograph(*photograph_and_mask(tmp_path))
    assert notice is None
    assert photograph.name == "photograph"
    assert photograph.image.shape == (40, 40, 3)
    np.testing.assert_array_equal(photograph.mask, disk())


def test_the_mask_may_be_the_alpha_channel(tmp_path: Path) -> None:
    """Without a mask file, the alpha channel is the mask, and colours stay as they are."""
    values = np.concatenate([deep(painted(disk())), deep(disk()[..., None])], axis=-1)
    photograph, _ = load_photograph(write_picture(tmp_path / "a.png", values))
    np.testing.assert_array_equal(photograph.mask, disk())
    np.testing.assert_allclose(photograph.image, painted(disk()), atol=1e-5)


def test_a_mask_file_wins_over_the_alpha_channel(tmp_path: Path) -> None:
    """Where both are there, the mask that was asked for is taken."""
    values = np.full((40, 40, 4), 200, np.uint8)
    values[:20, :, 3] = 0
    path = write_picture(tmp_path / "a.png", values)
    mask = write_picture(tmp_path / "mask.png", white(disk()))
    np.testing.assert_array_equal(load_photograph(path, mask)[0].mask, disk())


@pytest.mark.parametrize(("channels", "why"), [(3, "has no alpha"), (4, "is opaque everywhere")])
def test_without_a_mask_there_is_a_sentence(tmp_path: Path, channels: int, why: str) -> None:
    """No alpha channel, or one that says nothing, asks for a mask."""
    path = write_picture(tmp_path / "a.png", np.full((4, 4, channels), 255, np.uint8))
    with pytest.raises(RelightlabError, match=rf"{why}.*--mask"):
        load_photograph(path)


def test_a_mask_of_another_size_is_refused(tmp_path: Path) -> None:
    """Both sizes are named, width first."""
    path = write_picture(tmp_path / "a.png", np.full((4, 6, 3), 255, np.uint8))
    mask = write_picture(tmp_path / "mask.png", white(disk(5)))
    with pytest.raises(RelightlabError, match="6x4 pixels but its mask 5x5"):
        load_photograph(path, mask)


def test_an_empty_mask_is_refused(tmp_path: Path) -> None:
    """A black mask is told from a picture without an object."""
    path, mask = photograph_and_mask(tmp_path)
    write_picture(mask, np.zeros((40, 40), np.uint8))
    with pytest.raises(RelightlabError, match="the mask is empty"):
        load_photograph(path, mask)


def test_a_large_photograph_is_cropped_to_its_object(tmp_path: Path) -> None:
    """Only the object and a margin are kept of a photograph that is too large, not reduced."""
    mask = np.zeros((60, 80), bool)
    mask[20:30, 40:60] = True
    image = np.random.default_rng(0).uniform(size=(60, 80, 3))
    paths = (
        write_picture(tmp_path / "a.png", deep(image)),
        write_picture(tmp_path / "mask.png", white(mask)),
    )
    photograph, notice = load_photograph(*paths, max_pixels=1000)
    assert notice == "cropped to rows 16 to 33 and columns 36 to 63 of the photograph"
    assert photograph.mask.shape == (10 + 2 * MARGIN, 20 + 2 * MARGIN)
    np.testing.assert_allclose(photograph.image, image[16:34, 36:64], atol=1e-5)


def test_a_large_object_is_averaged_without_its_background(tmp_path: Path) -> None:
    """Blocks are averaged, in linear light, over the object's own pixels only."""
    rng = np.random.default_rng(0)
    mask = disk(301, 150)
    image = np.where(mask[..., None], rng.uniform(0.2, 0.4, size=(301, 301, 3)), 1.0)
    paths = (
        write_picture(tmp_path / "a.png", deep(image)),
        write_picture(tmp_path / "mask.png", white(mask)),
    )
    photograph, notice = load_photograph(*paths, max_pixels=10_000)
    assert notice is not None
    assert notice.endswith("built at 1/3 of the photograph's resolution")
    assert photograph.mask.sum() == pytest.approx(mask.sum() / 9, rel=0.01)
    assert photograph.mask.sum() <= 10_000
    inside = photograph.image[photograph.mask]
    assert inside.max() < 0.41
    assert inside.mean() == pytest.approx(image[mask].mean(), rel=0.01)
    np.testing.assert_allclose(
        photograph.image[50, 50], image[150:153, 150:153].mean(axis=(0, 1)), atol=1e-4
    )


def test_at_least_one_pixel_must_be_allowed(tmp_path: Path) -> None:
    """A limit below one pixel is refused."""
    with pytest.raises(RelightlabError, match="at least one pixel"):
        load_photograph(*photograph_and_mask(tmp_path), max_pixels=0)


def test_few_saturated_pixels_are_passed_over() -> None:
    """One pixel in two hundred is no reason for a notice; one in fifty is."""
    image, mask = np.full((20, 20, 3), 0.5), np.ones((20, 20), bool)
    image[0, :2] = 1.0
    assert saturation_notice(Photograph(image, mask, "a", "")) is None
    image[0, :8] = 1.0
    notice = saturation_notice(Photograph(image, mask, "a", ""))
    assert notice is not None
    assert notice.startswith("2 % of the object is saturated")
