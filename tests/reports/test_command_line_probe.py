"""Tests of the commands that measure lights on photographed spheres."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from datasets.image_files import encode_srgb
from datasets.model_files import save_model
from datasets.openexr_files import read_openexr, write_openexr
from reports.command_line import run
from shading_model.arrays import Image, Mask
from shading_model.diffuse_probe import fit_diffuse_probe
from shading_model.illumination import LinearHarmonics
from tests.example_objects import disk, disk_model, write_picture
from tests.shading_model.probe_pictures import (
    bright_light,
    chrome_picture,
    degrees_between,
    diffuse_picture,
    sphere_mask,
)

MASK = sphere_mask()
LIGHT = bright_light(11)


def eight_bits(image: Image) -> np.ndarray:
    """Return linear values stored linear in eight bits."""
    return np.round(255 * image).astype(np.uint8)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a matt sphere in three formats, a mirror sphere, and their mask."""
    matt = diffuse_picture(LIGHT, MASK)
    write_picture(tmp_path / "linear.png", eight_bits(matt))
    write_picture(tmp_path / "srgb.png", encode_srgb(matt))
    write_openexr(tmp_path / "matt.exr", matt)
    chrome = chrome_picture(np.array([0.6, 0.0, 0.8]), MASK, 0.2)
    write_picture(tmp_path / "chrome.png", eight_bits(chrome))
    save_mask(tmp_path / "mask.png", MASK)
    return tmp_path


def save_mask(path: Path, mask: Mask) -> None:
    """Write a mask as a picture."""
    write_picture(path, np.where(mask, 255, 0).astype(np.uint8))


def probe(kind: str, folder: Path, *arguments: str) -> dict[str, Any]:
    """Run a command in a folder and return the JSON it writes."""
    images = [str(folder / word) if word.endswith((".png", ".exr")) else word for word in arguments]
    file = folder / "rows.json"
    command = ["probe", kind, *images, "--mask", str(folder / "mask.png"), "--json", str(file)]
    assert run(command) == 0
    document: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return document


def test_formats_agree(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A matt sphere stored as sRGB, linear and OpenEXR gives its light three times."""
    (srgb,) = probe("diffuse", folder, "srgb.png")["rows"]
    (linear,) = probe("diffuse", folder, "linear.png", "--linear")["rows"]
    (exact,) = probe("diffuse", folder, "matt.exr")["rows"]
    np.testing.assert_allclose(exact["coefficients"], LIGHT.coefficients, atol=1e-6)
    for row in (srgb, linear):
        np.testing.assert_allclose(row["coefficients"], LIGHT.coefficients, atol=5e-3)
        assert row["residual"] < 0.01
    wrong = probe("diffuse", folder, "linear.png")["rows"][0]
    assert np.abs(np.array(wrong["coefficients"]) - LIGHT.coefficients).max() > 0.1
    printed = capsys.readouterr().out
    assert "Light of a matt sphere of radius" in printed
    assert "green" in printed


def test_the_file_carries_what_python_finds(folder: Path) -> None:
    """Coefficients, residuals, rank, direction and sphere are those of the library."""
    document = probe("diffuse", folder, "matt.exr", "--albedo", "0.9,0.8,0.7")
    found = fit_diffuse_probe(
        read_openexr(folder / "matt.exr"), MASK, albedo=np.array([0.9, 0.8, 0.7])
    )
    (row,) = document["rows"]
    assert found.log is not None
    assert found.distant is not None
    np.testing.assert_allclose(row["coefficients"], found.linear.coefficients, rtol=1e-9)
    np.testing.assert_allclose(row["log_coefficients"], found.log.coefficients, rtol=1e-6)
    np.testing.assert_allclose(row["direction"], found.direction, rtol=1e-9)
    np.testing.assert_allclose(row["distant_direction"], found.distant.direction, rtol=1e-9)
    assert row["residual"] == pytest.approx(found.residual, rel=1e-6)
    assert (row["rank"], row["pixels"]) == (found.rank, found.pixels)
    assert document["sphere"]["radius"] == found.sphere.radius
    assert document["coefficients"] == row["coefficients"]


def test_several_pictures_give_a_row_each(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In the order given, printed and in the file; the whole is then no single light."""
    document = probe("diffuse", folder, "linear.png", "matt.exr", "linear.png", "--linear")
    assert [row["image"] for row in document["rows"]] == ["linear.png", "matt.exr", "linear.png"]
    assert document["rows"][0] == document["rows"][2]
    assert "coefficients" not in document
    assert capsys.readouterr().out.count("linear.png") == 6


def test_the_file_of_one_picture_is_a_light(folder: Path) -> None:
    """What probe diffuse writes, model relight takes."""
    probe("diffuse", folder, "matt.exr")
    model, out = folder / "model.npz", folder / "out.exr"
    save_model(model, disk_model())
    light = ["--light", str(folder / "rows.json")]
    assert run(["model", "relight", str(model), "--out", str(out), *light]) == 0
    expected = disk_model().relight(LinearHarmonics(LIGHT.coefficients))[disk()]
    np.testing.assert_allclose(read_openexr(out)[disk()], expected, rtol=1e-4, atol=1e-5)


def test_a_chrome_sphere_gives_its_direction(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Printed and in the file, to a pixel's worth, for each picture."""
    document = probe("chrome", folder, "chrome.png", "chrome.png")
    first, second = document["rows"]
    assert first == second
    direction = np.array(first["direction"])
    assert degrees_between(direction, np.array([0.6, 0.0, 0.8])) < first["degrees_per_pixel"]
    printed = capsys.readouterr().out
    assert f"{direction[0]:.4f}" in printed
    assert str(first["area"]) in printed


def test_too_few_pixels_need_a_fit_by_name(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Refused with the rank, fitted by minimum norm or ridge; what is missing is null."""
    small = sphere_mask((12, 12), (6.0, 6.0), 2.7)
    save_mask(folder / "mask.png", small)
    write_picture(folder / "small.png", np.full((12, 12), 100, np.uint8))
    command = ["probe", "diffuse", str(folder / "small.png"), "--mask", str(folder / "mask.png")]
    assert run(command) == 2
    assert "5 pixels determine 5 of the 9 coefficients" in capsys.readouterr().err
    for fit in ("minimum-norm", "ridge"):
        (row,) = probe("diffuse", folder, "small.png", "--fit", fit)["rows"]
        assert (row["rank"], row["log_coefficients"], row["log_residual"]) == (5, None, None)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["diffuse", "none.png"], "no such file"),
        (["diffuse", "small.png"], "small.png: the photograph is 12x12 pixels but its mask"),
        (["diffuse", "linear.png", "white.png"], "white.png: the light probe is saturated on 100"),
        (["diffuse", "linear.png", "--fit", "lasso"], "Unknown fit 'lasso'"),
        (["diffuse", "linear.png", "--ridge=-1"], "expected a ridge above zero"),
        (["diffuse", "linear.png", "--albedo", "2"], "expected an albedo above 0"),
        (["diffuse", "linear.png", "--albedo", "1,1"], "expected 3 numbers"),
        (["chrome", "linear.png"], "linear.png: the chrome sphere has no distinct highlight"),
        (["chrome", "chrome.png", "--mask", "square.png"], "mask is not round"),
        (["chrome", "chrome.png", "--mask", "none.png"], "no such file"),
    ],
)
def test_bad_input_is_one_sentence(
    folder: Path,
    arguments: list[str],
    words: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Exit code 2, one line that names the picture at fault, and no file."""
    monkeypatch.chdir(folder)
    write_picture(folder / "small.png", np.full((12, 12), 100, np.uint8))
    write_picture(folder / "white.png", np.full((*MASK.shape, 3), 255, np.uint8))
    save_mask(folder / "square.png", np.pad(np.ones((50, 50), bool), 20))
    mask = [] if "--mask" in arguments else ["--mask", "mask.png"]
    assert run(["probe", *arguments, *mask, "--json", "rows.json"]) == 2
    captured = capsys.readouterr()
    assert words in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert not (folder / "rows.json").exists()
