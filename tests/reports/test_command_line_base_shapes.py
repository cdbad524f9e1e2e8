"""Tests of ``relightlab evaluate base-shapes``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from datasets.synthetic import synthesize
from evaluation.base_shape_table import RULES
from evaluation.base_shapes import BASE_SHAPES, FITTED_SHAPES
from evaluation.published_table2 import PUBLISHED
from evaluation.study_variants import VARIANTS
from reports.base_shape_run import COLUMNS, finding_lines, study_lines
from reports.command_line import run
from tests.evaluation.sirfs.fake_fits import diverging_fit, pretend

KEYS = {
    *("dataset", "shape", "weights", "imse", "relative_imse", "low", "high", "objects", "cells"),
    *("difference", "difference_low", "difference_high"),
}


@pytest.fixture(scope="module")
def small_set(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a synthetic set of two small objects."""
    folder = tmp_path_factory.mktemp("set")
    synthesize(folder, size=40, samples=1, objects=["apple", "pear"], workers=1)
    return folder


@pytest.fixture(autouse=True)
def fake(monkeypatch: pytest.MonkeyPatch) -> None:
    """No test here fits in earnest."""
    pretend(monkeypatch)


def base_shapes(small_set: Path, *options: str) -> int:
    """Run the command in this process and return its exit code."""
    return run(["evaluate", "base-shapes", "--data", str(small_set), "--workers", "1", *options])


def document_of(path: Path) -> dict[str, Any]:
    """Return the document that the command wrote."""
    document: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return document


def test_the_table_is_printed_and_written(
    small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """There is a row for each shape and rule, with intervals, and what is printed is the same."""
    target = tmp_path / "t.json"
    assert base_shapes(small_set, "--json", str(target)) == 0
    document = document_of(target)
    assert [(row["weights"], row["shape"]) for row in document["rows"]] == [
        (rule, shape) for rule in RULES for shape in BASE_SHAPES
    ]
    assert all(set(row) == KEYS for row in document["rows"])
    assert {(row["objects"], row["cells"]) for row in document["rows"]} == {(2, 20)}
    shown = capsys.readouterr().out
    assert "Table 2: error by base shape on synthetic" in shown
    assert "mean of the photographs" in shown
    assert f"{document['rows'][0]['imse']:.5f}" in shown
    assert "0.0723" in shown


def test_quick_leaves_out_what_needs_sirfs(
    small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The shapes of SIRFS are not measured, and the title says so."""
    target = tmp_path / "t.json"
    assert base_shapes(small_set, "--quick", "--json", str(target)) == 0
    document = document_of(target)
    assert document["quick"]
    assert not {row["shape"] for row in document["rows"]} & set(FITTED_SHAPES)
    assert "QUICK" in capsys.readouterr().out


def test_every_variant_is_in_the_sensitivity(small_set: Path, tmp_path: Path) -> None:
    """Asked for all, the document tells of each variant by each rule."""
    target = tmp_path / "t.json"
    options = ("--variants", "all", "--shapes", "contour,flat", "--objects", "pear")
    assert base_shapes(small_set, *options, "--json", str(target)) == 0
    rows = document_of(target)["sensitivity"]
    assert [(row["variant"], row["weights"]) for row in rows] == [
        (variant, rule) for variant in VARIANTS for rule in RULES
    ]


def test_a_failed_fit_makes_the_table_incomplete(
    small_set: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The other shapes are there, the title says how many cells are missing, and the code is 3."""
    pretend(monkeypatch, diverging_fit)
    assert base_shapes(small_set, "--objects", "pear") == 3
    assert "INCOMPLETE, 20 cells missing" in capsys.readouterr().out


def test_rows_are_kept_and_resumed(
    small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A second run with the same store measures nothing, and a plan says what there would be."""
    options = ("--quick", "--objects", "pear", "--store", str(tmp_path / "store"))
    assert base_shapes(small_set, *options, "--plan") == 0
    assert base_shapes(small_set, *options) == 0
    assert "0 done, 40 to run" in capsys.readouterr().out
    assert base_shapes(small_set, *options) == 0
    assert "40 done, 0 to run" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--shapes", "contour,kinekt"), "Did you mean 'kinect'"),
        (("--variants", "leave-one"), "Unknown variant"),
        (("--objects", "teapot"), "Unknown object"),
        (("--channels", "grey"), "Did you mean 'gray'"),
        (("--dataset", "psm-uww"), "psm-uww"),
        (("--quick", "--shapes", "sirfs"), "no other base shape was asked for"),
    ],
)
def test_wrong_use_is_a_sentence(
    small_set: Path, options: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Names that do not exist end with code 2 and one sentence."""
    assert base_shapes(small_set, *options) == 2
    shown = capsys.readouterr().err
    assert words in shown
    assert "Traceback" not in shown


def test_a_set_that_is_not_here_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A data root without the wanted set is refused with the set's name."""
    (tmp_path / "hdri").mkdir()
    (tmp_path / "hdri" / "a.hdr").write_bytes(b"x")
    assert run(["evaluate", "base-shapes", "--dataset", "psm-uw", "--data", str(tmp_path)]) == 2
    assert "psm-uw" in capsys.readouterr().err


def test_lines_stand_under_their_columns() -> None:
    """Every line has the columns of the head; what is unknown is a dash."""
    row = dict.fromkeys(KEYS) | {"shape": "contour", "weights": "oracle", "imse": 0.02}
    (line,) = study_lines({"rows": [row], "published": [dict(one) for one in PUBLISHED]})
    assert len(line) == len(COLUMNS)
    assert line == ("contour", "oracle", "0.02000", "- to -", "-", "-", "- to -", "0.0295")


def test_findings_name_the_better_shape() -> None:
    """A pair that differs after correction is told with the better one first."""
    pair = {
        "weights": "oracle",
        "first": "contour",
        "second": "sirfs-stereo",
        "median_difference": 0.01,
        "p_holm": 0.004,
    }
    test = {"weights": "oracle", "p": 0.001, "objects": 20}
    (line,) = finding_lines({"tests": [test], "pairs": [pair]})
    assert line == "oracle: Friedman p 0.001 over 20 objects; sirfs-stereo below contour (p 0.004)"
    (line,) = finding_lines({"tests": [test], "pairs": [pair | {"p_holm": 0.2}]})
    assert line.endswith("no pair differs after Holm's correction")
