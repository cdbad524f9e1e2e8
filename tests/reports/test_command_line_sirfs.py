"""Tests of ``relightlab sirfs fit``."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from evaluation.sirfs import fit as fitting
from evaluation.sirfs.fit_files import load_fit
from reports.command_line import run
from tests.example_objects import disk, photograph_and_mask, write_picture


@pytest.fixture(autouse=True)
def few_evaluations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let fits end early."""
    monkeypatch.setattr(fitting, "EVALUATIONS", (40,))


def fit(folder: Path, *options: str) -> int:
    """Fit a small photograph in a folder."""
    photograph, mask = photograph_and_mask(folder)
    out = ["--out", str(folder / "fit.npz")]
    return run(["sirfs", "fit", str(photograph), "--mask", str(mask), *out, *options])


def test_fit_writes_what_was_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The file holds height, normals, albedo, shading, light and loss, and the loss is shown."""
    assert fit(tmp_path, "--light", "natural") == 0
    shown = capsys.readouterr()
    found = load_fit(tmp_path / "fit.npz")
    assert f"final loss {found.final_loss:.4f}" in shown.out
    assert "s left" in shown.err
    with np.load(tmp_path / "fit.npz") as stored:
        names = {"height", "normals", "albedo", "shading", "light", "final_loss"}
        assert names <= set(stored.files)
        assert stored["light"].shape == (9, 3)
    assert np.isfinite(found.height[disk()]).all()


def test_fit_in_gray_with_terms_left_out_and_depth(tmp_path: Path) -> None:
    """Gray fits, ablations and an external depth can be asked for."""
    np.save(tmp_path / "depth.npy", np.where(disk(), 3.0, np.nan))
    options = ("--channels", "gray", "--without", "slant", "--depth", str(tmp_path / "depth.npy"))
    assert fit(tmp_path, *options) == 0
    found = load_fit(tmp_path / "fit.npz")
    assert found.albedo.shape == (40, 40, 1)
    assert found.terms["slant"] == 0.0
    assert found.terms["depth"] > 0.0


def test_large_photographs_are_reduced_and_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A photograph of twenty megapixels is fitted at a reduced resolution, which is said."""
    rows, columns = 4000, 5000
    picture = np.full((rows, columns, 3), 120, np.uint8)
    picture[:, : columns // 2] = 90
    mask = np.zeros((rows, columns), np.uint8)
    cv2.ellipse(mask, (columns // 2, rows // 2), (2000, 1500), 0, 0, 360, 255, -1)
    photograph = write_picture(tmp_path / "large.png", picture)
    outline = write_picture(tmp_path / "large-mask.png", mask)
    out = str(tmp_path / "large.npz")
    command = ["sirfs", "fit", str(photograph), "--mask", str(outline), "--out", out]
    assert run([*command, "--max-pixels", "20000"]) == 0
    assert "of the photograph's resolution" in capsys.readouterr().out
    assert load_fit(tmp_path / "large.npz").mask.sum() <= 20000


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--light", "moon"), "Unknown light model 'moon'"),
        (("--channels", "sepia"), "Unknown channels 'sepia'"),
        (("--without", "slnt"), "Did you mean 'slant'?"),
        (("--depth", "nowhere.npy"), "cannot read the depth"),
    ],
)
def test_wrong_options_are_told(
    tmp_path: Path, options: tuple[str, ...], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each wrong option is one sentence and exit code 2, and nothing is written."""
    assert fit(tmp_path, *options) == 2
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "fit.npz").exists()


def test_a_mask_of_a_few_pixels_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Too few pixels to tell a shape from are refused in one sentence."""
    photograph, _ = photograph_and_mask(tmp_path)
    few = np.zeros((40, 40), np.uint8)
    few[20:23, 20:23] = 255
    mask = write_picture(tmp_path / "few.png", few)
    out = str(tmp_path / "fit.npz")
    assert run(["sirfs", "fit", str(photograph), "--mask", str(mask), "--out", out]) == 2
    assert "expected at least 64 pixels" in capsys.readouterr().err
