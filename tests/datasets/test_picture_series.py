"""Numbered pictures of one view."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from datasets.picture_series import box_of, numbered, read_series
from shading_model.errors import RelightlabError


def write(path: Path, values: NDArray[np.uint8] | NDArray[np.uint16]) -> Path:
    """A picture file in RGB or gray."""
    cv2.imwrite(str(path), values[..., ::-1] if values.ndim == 3 else values)
    return path


def written(folder: Path, count: int = 3) -> tuple[tuple[Path, ...], Path]:
    """Some pictures whose values are 10, 20, ... and a mask of their middle."""
    paths = [
        write(folder / f"light{k}.png", np.full((20, 30, 3), 10 * k, np.uint8))
        for k in range(1, count + 1)
    ]
    mask = np.zeros((20, 30), np.uint8)
    mask[8:12, 10:20] = 255
    return tuple(paths), write(folder / "mask.png", mask)


def test_values_are_taken_as_they_are(tmp_path: Path) -> None:
    """Divided by 255 and nothing else; the mean is the mean of them."""
    series = read_series(*written(tmp_path), lights=3)
    assert np.allclose(series.images[1], 20 / 255, rtol=0, atol=1e-15)
    assert np.allclose(series.mean, 20 / 255)
    assert series.names == ("light1.png", "light2.png", "light3.png")
    assert series.mask.sum() == 40


def test_saturated_is_a_channel_at_the_end(tmp_path: Path) -> None:
    """255 in one colour is enough, 254 is not."""
    paths, mask = written(tmp_path)
    image = np.full((20, 30, 3), 254, np.uint8)
    image[3, 4, 1] = 255
    write(paths[2], image)
    saturated = read_series(paths, mask, 3).saturated
    assert np.argwhere(saturated).tolist() == [[2, 3, 4]]


@pytest.mark.parametrize(("margin", "size"), [(0, (4, 10)), (8, (20, 26)), (100, (20, 30))])
def test_a_crop_is_the_mask_and_its_margin(
    tmp_path: Path, margin: int, size: tuple[int, int]
) -> None:
    """As far as there is picture."""
    series = read_series(*written(tmp_path), lights=3).cropped(margin)
    assert series.images.shape == (3, *size, 3)
    assert series.mask.shape == size
    assert series.mask.sum() == 40
    assert box_of(series.mask)[0].start == min(margin, 8)


def test_numbers_are_ordered_as_numbers(tmp_path: Path) -> None:
    """Ten comes after nine; what has no number is not of the series."""
    for k in range(12):
        (tmp_path / f"cat.{k}.png").touch()
    (tmp_path / "cat.mask.png").touch()
    assert [path.name for path in numbered(tmp_path, "cat.")][9:11] == ["cat.9.png", "cat.10.png"]
    assert len(numbered(tmp_path, "cat.")) == 12


def test_a_gap_in_the_numbers_is_named(tmp_path: Path) -> None:
    """Otherwise every picture after it would get the light of another."""
    for k in (1, 2, 4):
        (tmp_path / f"rgb_{k:02d}.png").touch()
    with pytest.raises(RelightlabError, match=r"lacks rgb_3\.png"):
        numbered(tmp_path, "rgb_")


def test_what_cannot_be_used_is_one_sentence(tmp_path: Path) -> None:
    """Numbers and sizes that differ, other depths, a file of something else, a missing mask."""
    paths, mask = written(tmp_path)
    with pytest.raises(RelightlabError, match=r"there are 3 pictures beside .* but 4 lights"):
        read_series(paths, mask, 4)
    with pytest.raises(RelightlabError, match=r"no such file: .*none\.png"):
        read_series(paths, tmp_path / "none.png", 3)
    write(paths[0], np.ones((20, 31, 3), np.uint8))
    with pytest.raises(RelightlabError, match=r"light1\.png is 31x20 pixels but its mask is 30x20"):
        read_series(paths, mask, 3)
    write(paths[0], np.ones((20, 30), np.uint8))
    with pytest.raises(RelightlabError, match=r"eight-bit colour picture: .*light1\.png"):
        read_series(paths, mask, 3)
    write(paths[0], np.ones((20, 30, 3), np.uint16))
    with pytest.raises(RelightlabError, match=r"eight-bit colour picture: .*light1\.png"):
        read_series(paths, mask, 3)
    paths[0].write_text("<html>Not Found</html>")
    with pytest.raises(RelightlabError, match="cannot read the picture"):
        read_series(paths, mask, 3)
