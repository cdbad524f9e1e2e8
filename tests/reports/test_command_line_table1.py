"""Tests of the commands that measure Table 1, on a small synthetic set."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from datasets.synthetic import synthesize
from reports.command_line import run
from tests.evaluation.sirfs.fake_fits import pretend

KEYS = {
    *("dataset", "setting", "method", "detail_source", "weights"),
    *("imse", "relative_imse", "cells"),
}


@pytest.fixture(scope="module")
def small_set(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a synthetic set of two small objects."""
    folder = tmp_path_factory.mktemp("set")
    synthesize(folder, size=40, samples=1, objects=["apple", "pear"], workers=1)
    return folder


def rerendering(small_set: Path, target: Path, *options: str) -> dict[str, list[dict[str, object]]]:
    """Run ``evaluate rerendering`` and return the document it wrote."""
    command = ["evaluate", "rerendering", "--data", str(small_set), "--json", str(target)]
    assert run([*command, "--quick", *options]) == 0
    document: dict[str, list[dict[str, object]]] = json.loads(target.read_text())
    return document


def test_rows_are_one_per_entry(
    small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two settings, two sources and five rules give twenty rows; each number printed is one."""
    document = rerendering(small_set, tmp_path / "t.json", "--workers", "1")
    rows = document["rows"]
    assert len(rows) == 20
    assert all(set(row) >= KEYS for row in rows)
    assert {row["cells"] for row in rows} == {40}
    shown = capsys.readouterr().out
    assert all(f"{row['imse']:.5f}" in shown for row in rows)
    assert shown.count("left out by --quick") == 6
    assert all(f"{entry['imse']:.4f}" in shown for entry in document["published"])


@pytest.mark.slow
def test_workers_do_not_change_the_numbers(small_set: Path, tmp_path: Path) -> None:
    """One process and two give the same rows to the last bit."""
    one, two = (
        rerendering(small_set, tmp_path / f"{count}.json", "--workers", count) for count in "12"
    )
    assert one["rows"] == two["rows"]
    assert one["objects"] == two["objects"]
    assert one["intrinsic"] == two["intrinsic"]


def test_reported_objects_do_not_change_what_is_measured(small_set: Path, tmp_path: Path) -> None:
    """One object alone has the error it has in the whole table, also where rules are learned."""
    options = ("--workers", "1")
    both = rerendering(small_set, tmp_path / "both.json", *options)["objects"]
    alone = rerendering(small_set, tmp_path / "one.json", *options, "--objects", "pear")["objects"]
    assert alone == [row for row in both if row["object"] == "pear"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--objects", "paer"], "Did you mean 'pear'?"),
        (["--channels", "grey"], "Did you mean 'gray'?"),
        (["--workers", "0"], "at least one worker"),
    ],
)
def test_wrong_names_and_numbers(
    small_set: Path, options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Names and numbers out of range are refused in one sentence."""
    command = ["evaluate", "rerendering", "--data", str(small_set), "--workers", "1"]
    assert run([*command, "--quick", *options]) == 2
    assert words in capsys.readouterr().err


def test_a_dataset_that_is_not_here(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Asked for MIT-Berkeley where there is none, the command says where it looked."""
    (tmp_path / "hdri").mkdir()
    (tmp_path / "hdri" / "a.exr").touch()
    command = ["evaluate", "rerendering", "--dataset", "mit-berkeley", "--data", str(tmp_path)]
    assert run(command) == 2
    assert f"mit-berkeley was not found in {tmp_path}" in capsys.readouterr().err


def test_without_data_the_synthetic_set_is_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, small_set: Path
) -> None:
    """Where MIT-Berkeley is not found, the source says so and is the synthetic set."""
    from reports import table1_run

    (tmp_path / "hdri").mkdir()
    (tmp_path / "hdri" / "a.exr").touch()
    monkeypatch.setattr(table1_run, "synthetic_root", lambda **_: small_set)
    source = table1_run.open_source(tmp_path)
    assert source.dataset.name == "synthetic"
    assert "mit-berkeley was not found" in source.notice
    assert str(small_set) in source.notice
    assert len(source.lights) == 20


@pytest.mark.slow
def test_reproduce_writes_all_its_results(
    small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """JSON, CSV and page are written; the CSV has the rows of the JSON; five lines sum up."""
    out = tmp_path / "out"
    copy = tmp_path / "copy.json"
    command = ["reproduce", "--data", str(small_set), "--out", str(out), "--workers", "1"]
    assert run([*command, "--quick", "--json", str(copy)]) == 0
    results = out / "results" / "table1.json"
    assert copy.read_bytes() == results.read_bytes()
    document = json.loads(results.read_text())
    with (out / "results" / "table1.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["imse"]) for row in rows] == [row["imse"] for row in document["rows"]]
    assert "<html" in (out / "report" / "index.html").read_text(encoding="utf-8")[:200].lower()
    lines = capsys.readouterr().out.splitlines()
    assert lines[-5].startswith("synthetic: 2 objects under 20 lights")
    assert str(out / "report" / "report.pdf") in lines[-6]
    assert str(out / "report" / "index.html") in lines[-7]
    assert (out / "report" / "report.pdf").read_bytes().startswith(b"%PDF-")
    assert "160 cells done, 0 missing" in lines[-2]


@pytest.mark.slow
def test_reproduce_measures_table_2(
    small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """After Table 1 stands Table 2, on the page too, and its numbers are in files of their own."""
    out = tmp_path / "out"
    command = ["reproduce", "--data", str(small_set), "--out", str(out), "--workers", "1"]
    assert run([*command, "--quick"]) == 0
    shown = capsys.readouterr().out
    assert shown.index("Table 1: ") < shown.index("Table 2: error by base shape on synthetic")
    document = json.loads((out / "results" / "table2-synthetic.json").read_text())
    with (out / "results" / "table2-synthetic.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["imse"]) for row in rows] == [row["imse"] for row in document["rows"]]
    assert {row["shape"] for row in rows} == {"contour", "kinect", "ground-truth", "flat"}
    assert all(f"{row['imse']:.5f}" in shown for row in document["rows"])
    page = (out / "report" / "index.html").read_text(encoding="utf-8")
    assert 'id="table-2-synthetic-errors"' in page
    assert "table2-synthetic.json: rows, published" in page


@pytest.mark.slow
def test_reproduce_shows_sirfs(
    small_set: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without --quick, rows (b) and B+M are measured, and fits and their errors are shown."""
    pretend(monkeypatch)
    out = tmp_path / "out"
    assert run(["reproduce", "--data", str(small_set), "--out", str(out), "--workers", "1"]) == 0
    document = json.loads((out / "results" / "table1.json").read_text())
    assert (document["quick"], document["open"]) == (False, [])
    assert len(document["sirfs_rows"]) == 4
    assert {row["object"] for row in document["sirfs_summary"]} == {"all"}
    page = (out / "report" / "index.html").read_text(encoding="utf-8")
    assert "left out" not in page
    assert "from the left, fitted" in page
    assert 'id="sirfs-natural-colour"' in page


@pytest.mark.real_data
def test_the_measured_set_is_found_first(mit_berkeley_root: Path) -> None:
    """Where MIT-Berkeley is, it is taken with its own lights, and the notice says where."""
    from reports.table1_run import open_source

    source = open_source(mit_berkeley_root.parent)
    assert (source.dataset.name, len(source.dataset.objects)) == ("mit-berkeley", 20)
    assert source.notice == f"MIT-Berkeley found in {mit_berkeley_root}"
