"""The one OpenEXR reader and writer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from datasets.openexr_files import read_openexr, write_openexr
from shading_model.errors import RelightlabError


@given(
    height=st.integers(1, 9),
    width=st.integers(1, 9),
    steps=st.tuples(*[st.sampled_from([-3, -2, -1, 1, 2, 3])] * 2),
    order=st.permutations(range(3)),
    kind=st.sampled_from([np.float16, np.float32, np.float64]),
    seed=st.integers(0, 1000),
)
@settings(max_examples=60, deadline=None)
def test_any_strides_come_back_as_they_were(
    tmp_path_factory: pytest.TempPathFactory,
    height: int,
    width: int,
    steps: tuple[int, int],
    order: list[int],
    kind: type[np.floating],
    seed: int,
) -> None:
    """Flipped, strided and transposed arrays of any float type are written pixel for pixel."""
    shape = (height * abs(steps[0]), width * abs(steps[1]), 3)
    stored = np.random.default_rng(seed).random(shape).astype(kind)
    transposed = np.ascontiguousarray(stored.transpose(order)).transpose(np.argsort(order))
    view = transposed[:: steps[0], :: steps[1], ::-1]
    path = tmp_path_factory.mktemp("strides") / "image.exr"
    write_openexr(path, view)
    np.testing.assert_array_equal(read_openexr(path), view.astype(np.float32))


def test_the_same_image_gives_the_same_bytes(tmp_path: Path) -> None:
    """Writing twice gives one file."""
    image = np.random.default_rng(0).random((20, 30, 3))
    for name in ("a.exr", "b.exr"):
        write_openexr(tmp_path / name, image)
    assert (tmp_path / "a.exr").read_bytes() == (tmp_path / "b.exr").read_bytes()


def test_a_luminance_file_becomes_gray(tmp_path: Path) -> None:
    """A file with only Y is read as three equal channels."""
    gray = np.arange(6, dtype=np.float32).reshape(2, 3)
    with OpenEXR.File({}, {"Y": gray}) as file:
        file.write(str(tmp_path / "gray.exr"))
    np.testing.assert_array_equal(read_openexr(tmp_path / "gray.exr"), np.stack([gray] * 3, -1))


def test_other_channels_are_refused(tmp_path: Path) -> None:
    """A depth file is no picture."""
    with OpenEXR.File({}, {"Z": np.ones((2, 2), np.float32)}) as file:
        file.write(str(tmp_path / "depth.exr"))
    with pytest.raises(RelightlabError, match=r"expected channels R, G, B or Y .* got Z"):
        read_openexr(tmp_path / "depth.exr")


def test_nan_values_are_refused(tmp_path: Path) -> None:
    """A map with a NaN would poison every light made of it."""
    write_openexr(tmp_path / "nan.exr", np.full((2, 2, 3), np.nan))
    with pytest.raises(RelightlabError, match="NaN or infinite"):
        read_openexr(tmp_path / "nan.exr")


def test_missing_foreign_and_truncated_files_are_refused(tmp_path: Path) -> None:
    """Each of the three gets its sentence."""
    with pytest.raises(RelightlabError, match="cannot read"):
        read_openexr(tmp_path / "absent.exr")
    (tmp_path / "text.exr").write_text("not an image")
    with pytest.raises(RelightlabError, match="expected an OpenEXR file"):
        read_openexr(tmp_path / "text.exr")
    write_openexr(tmp_path / "whole.exr", np.random.default_rng(0).random((40, 40, 3)))
    whole = (tmp_path / "whole.exr").read_bytes()
    (tmp_path / "cut.exr").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(RelightlabError, match="is damaged"):
        read_openexr(tmp_path / "cut.exr")


@pytest.mark.parametrize("shape", [(4, 4), (4, 4, 4), (0, 4, 3)])
def test_wrong_shapes_are_not_written(tmp_path: Path, shape: tuple[int, ...]) -> None:
    """Only (h, w, 3) is an RGB image, and no file is left behind for anything else."""
    with pytest.raises(RelightlabError, match=r"expected an image of shape \(h, w, 3\)"):
        write_openexr(tmp_path / "image.exr", np.zeros(shape))
    assert list(tmp_path.iterdir()) == []
