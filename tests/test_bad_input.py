"""Unusual and wrong input: each gets the right answer or one clear sentence.

Whatever is written is whole or absent. Tests of single modules hold their own bad input; here it
goes through the door that users come in by.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as PillowImage
from scipy import ndimage

from datasets import shading_dictionary
from datasets.image_files import read_image
from datasets.model_files import load_model
from reports.command_line import run
from shading_model.arrays import Image, Mask
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ObjectModel, build_model
from tests.example_objects import disk, painted, parameters, photograph_and_mask, write_picture

MAPS = ("albedo", "height", "normals", "parametric_residual", "geometric_detail")
SIZE = 60


def build(image: Image, mask: Mask) -> ObjectModel:
    """Build a model with the shipped parameters."""
    return build_model(image, mask, parameters())


def assert_sound(model: ObjectModel, mask: Mask) -> None:
    """Assert that every map is finite on the mask and NaN elsewhere, and so is a relit picture."""
    np.testing.assert_array_equal(model.mask, mask)
    relit = model.relight(LogHarmonics(np.linspace(-0.3, 0.3, 9)))
    for values in (*(getattr(model, name) for name in MAPS), relit):
        assert np.isfinite(values[mask]).all()
        assert np.isnan(values[~mask]).all()
    lengths = np.linalg.norm(model.normals[mask], axis=-1)
    np.testing.assert_allclose(lengths, 1.0, atol=1e-9)


def everywhere() -> Mask:
    """Return a mask that fills its picture."""
    return np.ones((SIZE, SIZE), bool)


def in_a_corner() -> Mask:
    """Return a mask that touches two borders."""
    mask = np.zeros((SIZE, SIZE), bool)
    mask[:40, :30] = True
    return mask


def dust() -> Mask:
    """Return a mask of hundreds of small components."""
    return np.random.default_rng(0).random((SIZE, SIZE)) < 0.25


def with_holes() -> Mask:
    """Return a disk with a large and a one-pixel hole."""
    mask = disk(SIZE)
    mask[20:30, 20:30] = False
    mask[40, 40] = False
    return mask


def with_whiskers() -> Mask:
    """Return a disk with one-pixel-wide lines that reach the borders."""
    mask = disk(SIZE)
    mask[SIZE // 2, :] = True
    mask[:, SIZE // 3] = True
    return mask


def diagonal() -> Mask:
    """Return pixels that touch at their corners only."""
    return np.eye(SIZE, dtype=bool)


def one_pixel() -> Mask:
    """Return a single pixel."""
    mask = np.zeros((SIZE, SIZE), bool)
    mask[7, 9] = True
    return mask


SHAPES = (everywhere, in_a_corner, dust, with_holes, with_whiskers, diagonal, one_pixel)


@pytest.mark.parametrize("shape", SHAPES)
def test_unusual_masks_give_sound_models(shape: object) -> None:
    """Borders, dust, holes, whiskers, diagonals and single pixels give finite models."""
    mask = shape()  # type: ignore[operator]
    assert_sound(build(painted(mask), mask), mask)


def test_unusual_masks_reproduce_their_photograph() -> None:
    """Albedo times (fitted shading + S_p) is the photograph, whatever the mask."""
    for shape in SHAPES:
        mask = shape()
        model = build(painted(mask), mask)
        fitted = model.illumination.shade(model.normals, model.height)
        again = model.albedo * (fitted + model.parametric_residual)[..., None]
        np.testing.assert_allclose(again[mask], painted(mask)[mask], rtol=1e-9)


def test_components_do_not_know_each_other() -> None:
    """Two objects in one mask have the shapes, and up to scale the albedos, they have alone."""
    first, second = np.zeros((2, SIZE, SIZE), bool)
    first[3:25, 3:28] = True
    second[32:55, 25:58] = True
    image = painted(first)
    both = build(image, first | second)
    for mask in (first, second):
        alone = build(image, mask)
        np.testing.assert_allclose(both.normals[mask], alone.normals[mask], atol=0.01)
        np.testing.assert_allclose(both.height[mask], alone.height[mask], atol=0.05)
        ratio = both.albedo[mask] / alone.albedo[mask]
        assert np.ptp(ratio) < 1e-3 * ratio.mean()


def test_a_hole_is_a_contour() -> None:
    """Beside a hole the surface turns toward it and its height is zero, as on the outer contour."""
    mask = disk(SIZE)
    mask[25:35, 25:35] = False
    model = build(painted(mask), mask)
    assert model.normals[30, 24, 0] > 0.3
    assert model.normals[30, 35, 0] < -0.3
    assert model.normals[24, 30, 1] < -0.3
    np.testing.assert_allclose(model.height[25:35, 24], 0.0, atol=1e-6)


def test_a_line_is_flat() -> None:
    """A part one pixel wide is all contour: of height zero, facing the viewer along its length."""
    mask = with_whiskers()
    model = build(painted(mask), mask)
    whisker = model.normals[SIZE // 2, 1:4]
    np.testing.assert_allclose(model.height[SIZE // 2, :4], 0.0, atol=1e-6)
    np.testing.assert_allclose(whisker[:, :2], 0.0, atol=0.05)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (np.nan, "1 NaN or infinite pixels"),
        (np.inf, "1 NaN or infinite pixels"),
        (-0.01, "1 negative pixels"),
    ],
)
def test_bad_pixels_count_inside_only(value: float, words: str) -> None:
    """A NaN, infinite or negative pixel is counted on the object, and ignored beside it."""
    image = painted(disk())
    image[0, 0] = value
    assert_sound(build(image, disk()), disk())
    image[20, 20, 1] = value
    with pytest.raises(RelightlabError, match=words):
        build(image, disk())


def test_an_all_black_photograph_is_refused() -> None:
    """Where nothing is seen there is nothing to relight."""
    with pytest.raises(RelightlabError, match="black all over the mask"):
        build(np.zeros((40, 40, 3)), disk())


@pytest.mark.parametrize("level", [1e-9, 1.0, 1e6])
def test_a_uniform_photograph_has_a_uniform_albedo(level: float) -> None:
    """A saturated photograph, or one of any single value, is a plain object."""
    model = build(np.full((40, 40, 3), level), disk())
    assert_sound(model, disk())
    np.testing.assert_allclose(model.albedo[disk()], 2 * level, rtol=1e-6)


def test_black_parts_stay_black() -> None:
    """A photograph that is black in places, or in whole channels, gives a sound, black model."""
    image = painted(disk())
    image[:15] = 0.0
    image[..., 2] = 0.0
    model = build(image, disk())
    assert_sound(model, disk())
    assert (model.albedo[disk()][:, 2] == 0).all()
    assert (model.albedo[:15][disk()[:15]] == 0).all()


def test_gray_is_rgb_with_equal_channels() -> None:
    """A gray (h, w) photograph gives the model of its repetition over three channels."""
    gray = painted(disk())[..., 0]
    first, second = build(gray, disk()), build(np.repeat(gray[..., None], 3, -1), disk())
    np.testing.assert_array_equal(first.albedo, second.albedo)


@pytest.mark.parametrize(
    ("image", "mask", "words"),
    [
        (np.ones((30, 40, 3)), disk(), "40x30 pixels but its mask is 40x40"),
        (np.ones((40, 40, 4)), disk(), r"\(h, w, 3\) or \(h, w\), got \(40, 40, 4\)"),
        (np.ones((40, 40, 3)), np.ones((40, 40, 3), bool), r"mask of shape \(h, w\)"),
        (np.ones((40, 40, 3)), np.zeros((40, 40), bool), "the mask is empty"),
    ],
)
def test_wrong_arrays_are_refused(image: Image, mask: Mask, words: str) -> None:
    """Sizes that do not fit and an empty mask are told from the first line on."""
    with pytest.raises(RelightlabError, match=words):
        build(image, mask)


def command(folder: Path, photograph: Path, mask: Path) -> int:
    """Build a model on the command line."""
    files = [str(photograph), "--mask", str(mask), "--out", str(folder / "m.npz")]
    return run(["model", "build", *files])


def refusal(folder: Path, photograph: Path, mask: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """Return the one sentence that the command refuses with; it writes no model."""
    assert command(folder, photograph, mask) == 2
    sentence = capsys.readouterr().err
    assert sentence.startswith("relightlab: ")
    assert sentence.count("\n") == 1
    assert not (folder / "m.npz").exists()
    return sentence


def test_a_photograph_of_a_camera_is_linearised(tmp_path: Path) -> None:
    """The model of an 8-bit file is that of its linear values, not of its levels."""
    photograph, mask = photograph_and_mask(tmp_path)
    assert command(tmp_path, photograph, mask) == 0
    linear = build(read_image(photograph), disk())
    np.testing.assert_array_equal(load_model(tmp_path / "m.npz").albedo, linear.albedo)


def test_a_saturated_photograph_is_built_with_a_warning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A white photograph gives a model, and the command says what is lost."""
    photograph, mask = photograph_and_mask(tmp_path)
    write_picture(photograph, np.full((40, 40, 3), 255, np.uint8))
    assert command(tmp_path, photograph, mask) == 0
    assert "100 % of the object is saturated" in capsys.readouterr().out


@pytest.mark.parametrize("kind", ["truncated", "missing", "text", "black", "small", "empty mask"])
def test_bad_files_are_refused(
    tmp_path: Path, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A truncated, missing, foreign, black or ill-fitting file is told by its name or fault."""
    photograph, mask = photograph_and_mask(tmp_path)
    black = np.zeros((40, 40, 3), np.uint8)
    spoil = {
        "truncated": lambda: photograph.write_bytes(photograph.read_bytes()[:90]),
        "missing": photograph.unlink,
        "text": lambda: photograph.write_text("a text"),
        "black": lambda: write_picture(photograph, black),
        "small": lambda: write_picture(photograph, black[:30]),
        "empty mask": lambda: write_picture(mask, black[..., 0]),
    }
    words = {
        "truncated": f"cannot read the picture {photograph}",
        "missing": f"no such file: {photograph}",
        "text": f"cannot read the picture {photograph}",
        "black": "black all over the mask",
        "small": "is 40x30 pixels but its mask 40x40",
        "empty mask": "the mask is empty",
    }
    spoil[kind]()
    assert words[kind] in refusal(tmp_path, photograph, mask, capsys)


def test_a_damaged_model_file_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Relighting a truncated model writes no picture."""
    photograph, mask = photograph_and_mask(tmp_path)
    assert command(tmp_path, photograph, mask) == 0
    model, out = tmp_path / "m.npz", tmp_path / "relit.png"
    model.write_bytes(model.read_bytes()[:-100])
    capsys.readouterr()
    assert run(["model", "relight", str(model), "--out", str(out)]) == 2
    assert f"{model} is damaged" in capsys.readouterr().err
    assert not out.exists()


def test_a_truncated_mat_file_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Half a pool of lights stops the measurement in one sentence."""
    (tmp_path / "boundary-cues").mkdir()
    half = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + b"\x0e\x00\x00\x00\xff\x00"
    (tmp_path / "boundary-cues" / "Ldata.mat").write_bytes(half)
    assert run(["evaluate", "rerendering", "--data", str(tmp_path)]) == 2
    sentence = capsys.readouterr().err
    assert "Ldata.mat" in sentence
    assert sentence.count("\n") == 1


def test_a_shipped_dictionary_with_another_hash_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A dictionary that is not the one that was learned is not used."""
    photograph, mask = photograph_and_mask(tmp_path)
    shading_dictionary.shipped_dictionary.cache_clear()
    monkeypatch.setattr(shading_dictionary, "SHA256", "0" * 64)
    try:
        assert "dictionary" in refusal(tmp_path, photograph, mask, capsys)
    finally:
        shading_dictionary.shipped_dictionary.cache_clear()


def test_an_unwritable_output_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file where a folder is needed, and a folder where a file is, are told as such."""
    photograph, mask = photograph_and_mask(tmp_path)
    build_it = ["model", "build", str(photograph), "--mask", str(mask), "--out"]
    for out in (mask / "m.npz", tmp_path / "folder.npz"):
        (tmp_path / "folder.npz").mkdir(exist_ok=True)
        assert run([*build_it, str(out)]) == 2
        assert f"cannot write {out}" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        *("folder.npz", "mask.png", "photograph.png")
    ]


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_an_interrupted_write_leaves_nothing_under_the_final_name(
    tmp_path: Path, number: signal.Signals
) -> None:
    """Stopped half-way, even without a chance to clean up, a writer leaves the old content."""
    target = tmp_path / "result.json"
    target.write_text("old")
    code = (
        "import sys, time; from datasets.atomic import atomic_path\n"
        "with atomic_path(sys.argv[1]) as path:\n"
        "    path.write_text('half'); print('written', flush=True); time.sleep(60)\n"
    )
    writer = subprocess.Popen(
        [sys.executable, "-c", code, str(target)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    assert writer.stdout is not None
    assert writer.stdout.readline() == "written\n"
    writer.send_signal(number)
    writer.communicate(timeout=60)
    assert target.read_text() == "old"
    left = [path.name for path in tmp_path.iterdir() if path != target]
    assert all(name.startswith(".") for name in left)
    assert left == [] or number == signal.SIGKILL


@pytest.mark.slow
def test_twenty_megapixels_are_built_in_bounds(tmp_path: Path) -> None:
    """A 20-megapixel photograph is reduced and built within a minute and 1.5 GiB."""
    rows, columns = np.ogrid[:3650, :5480]
    inside = ((columns - 2740) / 2700) ** 2 + ((rows - 1825) / 1800) ** 2 < 1
    levels = (40 + columns // 40 + rows // 80).astype(np.uint8)
    PillowImage.fromarray(np.repeat(levels[..., None], 3, -1)).save(tmp_path / "p.jpg")
    PillowImage.fromarray(np.uint8(255) * inside.astype(np.uint8)).save(tmp_path / "m.png")
    photograph, mask, out = (str(tmp_path / name) for name in ("p.jpg", "m.png", "m.npz"))
    build_it = ["model", "build", photograph, "--mask", mask, "--out", out]
    code = (
        "import sys, resource; from reports.command_line import run; code = run(sys.argv[1:]);"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss); sys.exit(code)"
    )
    started = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-c", code, *build_it, "--max-pixels", "250000"],
        check=True,
        capture_output=True,
        text=True,
    )
    unit = 1 if sys.platform == "darwin" else 1024
    assert int(done.stdout.split()[-1]) * unit < 1.5 * 2**30
    assert time.monotonic() - started < 60
    assert "built at 1/8 of the photograph's resolution" in done.stdout
    model = load_model(tmp_path / "m.npz")
    assert_sound(model, model.mask)
    assert ndimage.label(model.mask)[1] == 1
