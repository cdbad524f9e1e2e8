"""Pictures of light probes as they are read."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from datasets.image_files import decode_srgb
from datasets.openexr_files import write_openexr
from datasets.probe_files import read_probe_picture
from shading_model.errors import RelightlabError
from tests.example_objects import write_picture

LEVELS = np.arange(0, 240, 20, dtype=np.uint8).reshape(3, 4)


@pytest.mark.parametrize("channels", [1, 3])
def test_eight_bits_are_srgb_unless_said_to_be_linear(tmp_path: Path, channels: int) -> None:
    """The same file is decoded, or divided by 255; gray is repeated over three channels."""
    levels = LEVELS if channels == 1 else np.repeat(LEVELS[..., None], 3, axis=-1)
    path = write_picture(tmp_path / "a.png", levels)
    shares = np.repeat(LEVELS[..., None], 3, axis=-1) / 255
    np.testing.assert_array_equal(read_probe_picture(path, linear=True).image, shares)
    np.testing.assert_allclose(read_probe_picture(path).image, decode_srgb(shares), atol=1e-15)


def test_sixteen_bits_are_linear(tmp_path: Path) -> None:
    """They are divided by 65535 either way, and saturate."""
    path = write_picture(tmp_path / "a.png", LEVELS.astype(np.uint16) * 257)
    for linear in (False, True):
        picture = read_probe_picture(path, linear=linear)
        np.testing.assert_allclose(picture.image[..., 0], LEVELS / 255, atol=1e-12)
        assert 0.99 < picture.saturated < 1


def test_openexr_has_no_end(tmp_path: Path) -> None:
    """Values above one are kept, and none is saturated."""
    image = np.full((3, 4, 3), 7.5)
    write_openexr(tmp_path / "a.exr", image)
    picture = read_probe_picture(tmp_path / "a.exr")
    np.testing.assert_array_equal(picture.image, image)
    assert picture.saturated == np.inf


def test_a_missing_picture_is_told(tmp_path: Path) -> None:
    """One sentence with the name."""
    with pytest.raises(RelightlabError, match=r"no such file: .*none\.png"):
        read_probe_picture(tmp_path / "none.png")
