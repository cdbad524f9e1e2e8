"""Tests of the reading and writing of pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image as PillowImage

from datasets import image_files
from datasets.image_files import (
    decode_srgb,
    encode_srgb,
    read_image,
    read_linear_png,
    read_mask,
    read_picture,
    write_image,
)
from shading_model.errors import RelightlabError
from tests.example_objects import write_picture

RAMP = np.arange(40 * 30 * 3, dtype=np.uint16).reshape(40, 30, 3) * 18


def test_sixteen_bits_are_kept(tmp_path: Path) -> None:
    """A 16-bit RGB PNG keeps every value, in RGB order: more than 256 of them, and linear."""
    path = write_picture(tmp_path / "deep.png", RAMP)
    image = read_image(path)
    assert len(np.unique(image)) == RAMP.size
    np.testing.assert_array_equal(image, RAMP / 65535)
    np.testing.assert_array_equal(read_linear_png(path), image)


def test_eight_bits_are_linearised(tmp_path: Path) -> None:
    """Eight-bit sRGB 188 is half as bright as white, to a hundredth."""
    path = write_picture(tmp_path / "a.png", np.full((2, 2, 3), 188, np.uint8))
    np.testing.assert_allclose(read_image(path), 0.5, atol=0.01)


def test_every_level_survives_decoding_and_encoding() -> None:
    """Encoding undoes decoding at all 256 levels."""
    levels = np.arange(256)
    np.testing.assert_array_equal(encode_srgb(decode_srgb(levels / 255)), levels)


@given(st.lists(st.floats(0, 1), min_size=2, max_size=2).map(sorted))
def test_encoding_is_monotonic(pair: list[float]) -> None:
    """A brighter value is never encoded darker."""
    first, second = encode_srgb(np.array(pair))
    assert first <= second


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_gray_is_repeated_over_the_channels(tmp_path: Path, dtype: type) -> None:
    """A gray picture gives three equal channels."""
    levels = (np.arange(12).reshape(3, 4) * 20).astype(dtype)
    image = read_image(write_picture(tmp_path / "gray.png", levels))
    assert image.shape == (3, 4, 3)
    np.testing.assert_array_equal(image[..., 0], image[..., 2])
    assert (np.diff(image[0, :, 0]) > 0).all()


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_alpha_is_split_off(tmp_path: Path, dtype: type) -> None:
    """An alpha channel does not touch the colours, and says where the picture is opaque."""
    full = np.iinfo(dtype).max
    values = np.full((2, 2, 4), full, dtype)
    values[0, 0] = [full, 0, 0, 0]
    picture = read_picture(write_picture(tmp_path / "a.png", values))
    assert picture.opaque is not None
    np.testing.assert_array_equal(picture.opaque, [[False, True], [True, True]])
    np.testing.assert_array_equal(picture.colour, values[..., :3])


def test_no_alpha_is_none(tmp_path: Path) -> None:
    """A picture without an alpha channel says so."""
    assert read_picture(write_picture(tmp_path / "a.png", RAMP)).opaque is None


def test_a_palette_is_looked_up(tmp_path: Path) -> None:
    """A PNG with a palette gives its colours, not its indices."""
    values = np.zeros((2, 2, 3), np.uint8)
    values[0, 0] = [255, 0, 0]
    PillowImage.fromarray(values).quantize(4).save(tmp_path / "palette.png")
    np.testing.assert_allclose(read_image(tmp_path / "palette.png"), values / 255, atol=0.01)


def test_sixteen_bit_tiff_is_not_cut(tmp_path: Path) -> None:
    """A 16-bit gray TIFF keeps its values."""
    levels = np.arange(600, dtype=np.uint16).reshape(20, 30) * 100
    image = read_image(write_picture(tmp_path / "deep.tif", levels))
    np.testing.assert_array_equal(image[..., 0], levels / 65535)


def test_a_photograph_is_turned_upright(tmp_path: Path) -> None:
    """The EXIF orientation of a camera is obeyed."""
    picture = PillowImage.fromarray(np.zeros((20, 30, 3), np.uint8))
    exif = PillowImage.Exif()
    exif[0x0112] = 6
    picture.save(tmp_path / "turned.jpg", exif=exif)
    assert read_image(tmp_path / "turned.jpg").shape == (30, 20, 3)


@pytest.mark.parametrize(
    "values",
    [
        np.array([[0, 1]], np.uint8),
        np.array([[0, 255]], np.uint8),
        np.array([[0, 65025]], np.uint16),
        np.array([[[0, 0, 0], [0, 0, 9]]], np.uint8),
        np.array([[[9, 9, 9, 0], [9, 9, 9, 255]]], np.uint8),
    ],
)
def test_masks_in_two_values(tmp_path: Path, values: np.ndarray) -> None:
    """A mask is above zero, in any channel and depth; a used alpha channel takes precedence."""
    mask = read_mask(write_picture(tmp_path / "mask.png", values))
    np.testing.assert_array_equal(mask, [[False, True]])


def test_an_antialiased_mask_is_cut_at_one_half(tmp_path: Path) -> None:
    """Of many values, those above half of the range are inside."""
    values = np.array([[0, 100, 150, 255]], np.uint8)
    mask = read_mask(write_picture(tmp_path / "mask.png", values))
    np.testing.assert_array_equal(mask, [[False, False, True, True]])


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_a_truncated_png_is_refused_or_whole(tmp_path: Path, dtype: type) -> None:
    """Cut anywhere, a PNG is refused with its name, unless every pixel is still there."""
    noise = np.random.default_rng(1).integers(0, np.iinfo(dtype).max, (9, 8, 3)).astype(dtype)
    path = write_picture(tmp_path / "a.png", noise)
    content = path.read_bytes()
    refused = 0
    for length in range(0, len(content), 3):
        path.write_bytes(content[:length])
        try:
            np.testing.assert_array_equal(read_picture(path).colour, noise)
        except RelightlabError as error:
            assert str(path) in str(error)  # noqa: PT017  either outcome is right
            refused += 1
    assert refused > 0.9 * len(content) / 3


@pytest.mark.parametrize("suffix", ["jpg", "png"])
def test_half_a_picture_is_refused(tmp_path: Path, suffix: str) -> None:
    """Half of a picture is not taken for a dark picture."""
    path = tmp_path / f"a.{suffix}"
    noise = np.random.default_rng(1).integers(0, 255, (64, 64, 3)).astype(np.uint8)
    content = write_picture(path, noise).read_bytes()
    path.write_bytes(content[: len(content) // 2])
    with pytest.raises(RelightlabError, match="cannot read the picture"):
        read_image(path)


def test_what_is_no_picture_is_refused(tmp_path: Path) -> None:
    """A missing file, a folder and a text file each get a sentence."""
    with pytest.raises(RelightlabError, match="no such file"):
        read_image(tmp_path / "none.png")
    with pytest.raises(RelightlabError, match="no such file"):
        read_image(tmp_path)
    (tmp_path / "text.png").write_text("not a picture")
    with pytest.raises(RelightlabError, match="cannot read the picture"):
        read_image(tmp_path / "text.png")


def test_an_eight_bit_png_is_not_taken_for_linear(tmp_path: Path) -> None:
    """Where 16 bits are asked for, 8 are refused."""
    path = write_picture(tmp_path / "a.png", np.zeros((2, 2, 3), np.uint8))
    with pytest.raises(RelightlabError, match="expected a 16-bit PNG, got 8-bit"):
        read_linear_png(path)


def test_a_picture_that_is_too_large_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A picture over the limit is refused before it is decoded."""
    path = write_picture(tmp_path / "a.png", np.zeros((4, 5, 3), np.uint8))
    monkeypatch.setattr(image_files, "MAX_PIXELS", 19)
    with pytest.raises(RelightlabError, match="5x4 pixels, more than the 19"):
        read_image(path)


def test_written_pictures_are_read_back(tmp_path: Path) -> None:
    """Writing and reading changes a value by less than one level; NaN is black."""
    image = np.linspace(0, 1, 30).reshape(2, 5, 3)
    image[0, 0] = np.nan
    write_image(tmp_path / "a.png", image)
    back = read_image(tmp_path / "a.png")
    assert (back[0, 0] == 0).all()
    np.testing.assert_allclose(back[1], image[1], atol=0.005)


def test_transparency_is_written(tmp_path: Path) -> None:
    """Pixels that are not opaque are transparent in the file."""
    opaque = np.array([[True, False]])
    write_image(tmp_path / "a.png", np.ones((1, 2, 3)), opaque=opaque)
    read = read_picture(tmp_path / "a.png").opaque
    assert read is not None
    np.testing.assert_array_equal(read, opaque)


def test_formats_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    """An unknown suffix, and transparency in a JPEG, are refused and nothing is written."""
    image = np.ones((1, 2, 3))
    with pytest.raises(RelightlabError, match=r"ending in \.png or \.jpg"):
        write_image(tmp_path / "a.gif", image)
    with pytest.raises(RelightlabError, match="picture with transparency"):
        write_image(tmp_path / "a.jpg", image, opaque=np.ones((1, 2), bool))
    assert list(tmp_path.iterdir()) == []
