"""Tests of the commands that build and relight one object."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from datasets.image_files import read_image, read_picture
from datasets.model_files import load_model, read_model_header, save_model
from datasets.openexr_files import read_openexr
from reports.command_line import run
from shading_model.illumination import LinearHarmonics, LogHarmonics
from shading_model.object_model import Weights
from tests.example_objects import disk, disk_model, photograph_and_mask, write_picture

COEFFICIENTS = [0.1, -0.2, 0.3, 0.4, 0.0, 0.1, -0.1, 0.2, 0.05]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return the file of a small model."""
    path = tmp_path / "model.npz"
    save_model(path, disk_model())
    return path


def relit(file: Path, *options: str) -> np.ndarray:
    """Relight to OpenEXR and return the pixels."""
    out = file.parent / "relit.exr"
    assert run(["model", "relight", str(file), "--out", str(out), *options]) == 0
    return read_openexr(out)


def build(folder: Path, *options: str, mask: bool = True) -> int:
    """Build a model from a small photograph in a folder."""
    photograph, mask_file = photograph_and_mask(folder)
    given = ["--mask", str(mask_file)] if mask else []
    out = ["--out", str(folder / "model.npz")]
    return run(["model", "build", str(photograph), *given, *out, *options])


def test_build_then_relight_gives_the_photograph_back(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Under the fitted light, with S_p and without S_g, the picture is the photograph."""
    assert build(tmp_path) == 0
    assert "40x40 pixels, 812 on the object" in capsys.readouterr().out
    assert read_model_header(tmp_path / "model.npz")["name"] == "photograph"
    out = tmp_path / "relit.png"
    model = str(tmp_path / "model.npz")
    assert run(["model", "relight", model, "--weights", "1,0", "--out", str(out)]) == 0
    assert "exposure: 1 (nothing clips)" in capsys.readouterr().out
    first = read_picture(out).colour[disk()].astype(int)
    second = read_picture(tmp_path / "photograph.png").colour[disk()].astype(int)
    assert np.abs(first - second).max() <= 1
    assert (read_image(out)[~disk()] == 0).all()


def test_the_same_photograph_gives_the_same_bytes(tmp_path: Path) -> None:
    """Building twice writes the same file."""
    assert build(tmp_path) == 0
    first = (tmp_path / "model.npz").read_bytes()
    assert build(tmp_path) == 0
    assert (tmp_path / "model.npz").read_bytes() == first


def test_options_of_build_reach_the_model(tmp_path: Path) -> None:
    """Thresholds change the albedo, the slope limit the height, a known shading both layers."""
    assert build(tmp_path) == 0
    plain = load_model(tmp_path / "model.npz")
    assert build(tmp_path, "--gray-threshold", "0") == 0
    all_paint = load_model(tmp_path / "model.npz").albedo[disk()]
    assert not np.allclose(all_paint, plain.albedo[disk()])
    assert build(tmp_path, "--chromaticity-threshold", "9") == 0
    no_paint = load_model(tmp_path / "model.npz").albedo[disk()].mean(axis=-1)
    assert no_paint.std() < plain.albedo[disk()].mean(axis=-1).std()
    assert build(tmp_path, "--slope-limit", "0.3") == 0
    assert not np.allclose(load_model(tmp_path / "model.npz").height[disk()], plain.height[disk()])
    shading = write_picture(tmp_path / "s.png", np.full((40, 40), 60000, np.uint16))
    assert build(tmp_path, "--shading", str(shading)) == 0
    known = load_model(tmp_path / "model.npz")
    np.testing.assert_allclose(
        known.albedo[disk()], 2 * read_image(tmp_path / "photograph.png")[disk()]
    )


def test_a_large_object_is_reduced_with_a_notice(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An object over the limit is built smaller, and the command says so."""
    assert build(tmp_path, "--max-pixels", "300") == 0
    assert "built at 1/2 of the photograph's resolution" in capsys.readouterr().out
    assert load_model(tmp_path / "model.npz").mask.sum() <= 300


@pytest.mark.parametrize("convention", ["log", "linear"])
@pytest.mark.parametrize("colours", [1, 3])
def test_coefficients_are_taken_as_given(file: Path, convention: str, colours: int) -> None:
    """Nine or 27 numbers, in either convention, light the model as in Python."""
    numbers = np.repeat(np.array(COEFFICIENTS)[:, None], colours, axis=1) * np.arange(
        1, 1 + colours
    )
    kind = LogHarmonics if convention == "log" else LinearHarmonics
    light = kind(numbers if colours == 3 else numbers[:, 0])
    given = ",".join(str(number) for number in numbers.ravel())
    image = relit(file, f"--coefficients={given}", "--convention", convention, "--weights=0.5,2")
    expected = disk_model().relight(light, Weights(0.5, 2.0))[disk()]
    np.testing.assert_allclose(image[disk()], expected, rtol=1e-5, atol=1e-6)
    assert (image[~disk()] == 0).all()


def test_a_light_file_is_the_light_in_it(file: Path) -> None:
    """A file of coefficients equals the coefficients; a file of point lights the fitted light."""
    path = file.parent / "light.json"
    path.write_text(json.dumps({"coefficients": COEFFICIENTS, "convention": "linear"}))
    given = ",".join(map(str, COEFFICIENTS))
    np.testing.assert_array_equal(
        relit(file, "--light", str(path)),
        relit(file, f"--coefficients={given}", "--convention", "linear"),
    )
    path.write_text(json.dumps(read_model_header(file)["light"]))
    np.testing.assert_array_equal(relit(file, "--light", str(path)), relit(file))


def test_a_distant_light_follows_the_cosine(file: Path) -> None:
    """Without detail layers a direction shades by intensity times max(0, N . d)."""
    image = relit(file, "--direction=-2,0,2", "--intensity", "1.5", "--weights=0,0")
    model = disk_model()
    cosine = model.normals[disk()] @ (np.array([-1.0, 0.0, 1.0]) / np.sqrt(2))
    expected = model.albedo[disk()] * 1.5 * np.maximum(cosine, 0)[:, None]
    np.testing.assert_allclose(image[disk()], expected, atol=1e-3)


def test_a_natural_light_has_a_name(file: Path) -> None:
    """A shipped light lights the model by its name, in colour."""
    image = relit(file, "--light", "sunset-0", "--weights=0,0")[disk()]
    ratio = image / disk_model().albedo[disk()]
    assert np.isfinite(image).all()
    assert not np.allclose(ratio[:, 0], ratio[:, 2])


def test_exposure_keeps_the_brightest_pixel_from_clipping(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A light twenty times too bright is scaled to white, and the command says so."""
    out = file.parent / "a.png"
    command = ["model", "relight", str(file), "--out", str(out), "--direction=0,0,1"]
    assert run([*command, "--intensity", "20"]) == 0
    assert "so that the brightest pixel just does not clip" in capsys.readouterr().out
    levels = read_picture(out).colour
    assert levels.max() == 255
    assert (levels == 255).any(axis=-1).mean() < 0.05
    assert run([*command, "--intensity", "20", "--exposure", "1"]) == 0
    assert capsys.readouterr().out.startswith("exposure: 1\n")
    assert (read_picture(out).colour[disk()] == 255).mean() > 0.5


def test_the_background_may_be_transparent(file: Path) -> None:
    """A transparent background is the complement of the mask."""
    out = file.parent / "a.png"
    command = ["model", "relight", str(file), "--out", str(out)]
    assert run([*command, "--background", "transparent"]) == 0
    opaque = read_picture(out).opaque
    assert opaque is not None
    np.testing.assert_array_equal(opaque, disk())


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--light", "sunset"], "Did you mean 'sunset-0'?"),
        (["--light", "none.json"], "cannot read the light none.json"),
        (["--light", "fitted", "--direction=0,0,1"], "give one of"),
        (["--direction=0,0,0"], "expected a direction"),
        (["--direction=0,1"], "expected 3 numbers"),
        (["--direction=0,0,1", "--intensity", "0"], "intensity above zero"),
        (["--coefficients=1,2"], "expected 9 numbers"),
        (["--coefficients=1,2,3,4,5,6,7,8,nan"], "expected 9 numbers"),
        (["--coefficients=1,2,3,4,5,6,7,8,9", "--convention", "exp"], "Unknown convention 'exp'"),
        (["--intensity", "2"], "give its --direction too"),
        (["--convention", "linear"], "--convention is that of --coefficients"),
        (["--exposure=0"], "exposure above zero"),
        (["--background", "white"], "Unknown background 'white'"),
        (["--background", "transparent", "--out", "a.jpg"], "--out to end in .png"),
        (["--out", "a.gif"], "--out to end in .png or .jpg"),
    ],
)
def test_relight_refuses_in_one_sentence(
    file: Path, options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Wrong lights, numbers and names are refused, and no picture is written."""
    out = file.parent / "relit.png"
    assert run(["model", "relight", str(file), "--out", str(out), *options]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize(
    "content", ["[]", "{}", "x", '{"coefficients": [1, "a"]}', '{"positions": 1}']
)
def test_other_light_files_are_refused(
    file: Path, content: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A JSON file that holds no light is refused."""
    path = file.parent / "light.json"
    path.write_text(content)
    out = str(file.parent / "a.png")
    assert run(["model", "relight", str(file), "--light", str(path), "--out", out]) == 2
    assert f"expected a light in {path}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--gray-threshold", "-1"], "thresholds of at least zero"),
        (["--slope-limit", "0"], "slope limit above 0"),
        (["--shading", "none.png"], "no such file: none.png"),
        (["--out", "model.zip"], "--out to end in .npz"),
        (["--max-pixels", "0"], "at least one pixel"),
    ],
)
def test_build_refuses_in_one_sentence(
    tmp_path: Path, options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Options out of range are refused, and no model is written."""
    assert build(tmp_path, *options) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
    assert not (tmp_path / "model.npz").exists()


def test_a_shading_of_another_size_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The sentence gives both sizes and, where the photograph was reduced, says so."""
    shading = write_picture(tmp_path / "s.png", np.full((40, 40), 60000, np.uint16))
    assert build(tmp_path, "--shading", str(shading), "--max-pixels", "300") == 2
    error = capsys.readouterr().err
    assert f"the shading {shading} is 40x40 pixels but the model is built from" in error
    assert "built at 1/2 of the photograph's resolution: a larger --max-pixels" in error
    assert error.count("\n") == 1
    small = write_picture(tmp_path / "s.png", np.full((30, 40), 60000, np.uint16))
    assert build(tmp_path, "--shading", str(small)) == 2
    assert "is 40x30 pixels but the model is built from 40x40: give" in capsys.readouterr().err


def test_build_asks_for_a_mask(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without a mask or an alpha channel, the command says what to give."""
    assert build(tmp_path, mask=False) == 2
    assert "give a mask with --mask" in capsys.readouterr().err
