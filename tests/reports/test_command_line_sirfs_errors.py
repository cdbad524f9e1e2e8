"""Tests of the commands that measure SIRFS, on a small synthetic set and by fake fits."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from datasets.synthetic import synthesize
from evaluation.blob_store import BLOBS, blob_files
from reports.command_line import run
from reports.sirfs_run import COLUMNS, sirfs_lines, sirfs_title
from tests.evaluation.sirfs.fake_fits import diverging_fit, pretend

KEYS = {
    *("object", "setting", "channels", "z_mae", "n_mae", "s_mse", "r_mse", "rs_mse", "l_mse"),
    *("mean", "final_loss", "evaluations", "seconds"),
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


def sirfs(small_set: Path, *options: str) -> int:
    """Run ``evaluate sirfs`` in this process and return its exit code."""
    return run(["evaluate", "sirfs", "--data", str(small_set), "--workers", "1", *options])


def document_of(path: Path) -> dict[str, Any]:
    """Return the document that a command wrote."""
    document: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return document


def test_every_photograph_has_its_row(
    small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Both settings by default, in colour; what is printed is what is written."""
    target = tmp_path / "s.json"
    assert sirfs(small_set, "--json", str(target)) == 0
    document = document_of(target)
    rows = document["rows"]
    assert [(row["object"], row["setting"]) for row in rows] == [
        (name, setting) for setting in ("natural", "laboratory") for name in ("apple", "pear")
    ]
    assert all(set(row) == KEYS for row in rows)
    assert {row["channels"] for row in rows} == {"color"}
    assert [row["object"] for row in document["summary"]] == ["all", "all"]
    assert document["provenance"]["cells_done"] == 4
    assert document["protocol"]["light_models"] == {
        "natural": "natural",
        "laboratory": "laboratory",
    }
    shown = capsys.readouterr().out
    assert all(f"{row['z_mae']:.3f}" in shown for row in (*rows, *document["summary"]))
    assert "all (2)" in shown


def test_a_choice_of_objects_setting_and_channels(small_set: Path, tmp_path: Path) -> None:
    """One row; a term that was left out stands in the document."""
    target = tmp_path / "s.json"
    chosen = ("--objects", "pear", "--setting", "natural", "--channels", "gray")
    assert sirfs(small_set, *chosen, "--without", "slant,light", "--json", str(target)) == 0
    document = document_of(target)
    (row,) = document["rows"]
    assert (row["object"], row["setting"], row["channels"]) == ("pear", "natural", "gray")
    assert document["protocol"]["without"] == ["slant", "light"]
    assert row["final_loss"] == 3.5
    assert "without slant, light" in sirfs_title(document)


def test_a_run_goes_on_and_shares_its_fits_with_table_1(
    small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The store keeps rows and fits; both commands use the same fits, each made once."""
    store = tmp_path / "store"
    assert sirfs(small_set, "--store", str(store), "--setting", "natural") == 0
    fits = list(blob_files(store / BLOBS))
    assert len(fits) == 2
    assert sirfs(small_set, "--store", str(store)) == 0
    assert "2 done, 2 to run" in capsys.readouterr().out
    command = ["evaluate", "rerendering", "--data", str(small_set), "--workers", "1"]
    assert run([*command, "--store", str(store)]) == 0
    assert len(list(blob_files(store / BLOBS))) == 4
    assert set(fits) <= set(blob_files(store / BLOBS))


def test_plan(small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The number of fits, and nothing is run."""
    options = ("--plan", "--store", str(tmp_path / "none"), "--json", str(tmp_path / "p.json"))
    assert sirfs(small_set, *options) == 0
    assert "sirfs 1: 4 cells, 0 done, 4 to run in 4 tasks" in capsys.readouterr().out
    assert document_of(tmp_path / "p.json")["tasks"] == 4
    assert not (tmp_path / "none").exists()


def test_a_fit_that_fails(
    small_set: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Exit code 3, the reason on standard error, and the document all the same."""
    pretend(monkeypatch, diverging_fit)
    target = tmp_path / "s.json"
    assert sirfs(small_set, "--setting", "natural", "--json", str(target)) == 3
    document = document_of(target)
    assert [cell["object"] for cell in document["missing"]] == ["apple", "pear"]
    assert (document["rows"], document["summary"]) == ([], [])
    assert sirfs_lines(document) == []
    told = capsys.readouterr()
    assert "natural apple color: the fit diverged: its loss is not finite" in told.err
    assert "INCOMPLETE, 2 cells missing. SIRFS" in told.out


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--objects", "paer"], "Did you mean 'pear'?"),
        (["--setting", "nature"], "Did you mean 'natural'?"),
        (["--channels", "colour"], "Did you mean 'color'?"),
        (["--without", "slope"], "Unknown term 'slope'"),
        (["--workers", "0"], "at least one worker"),
    ],
)
def test_wrong_use_is_one_sentence(
    small_set: Path, options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Names and numbers out of range are refused, with exit code 2."""
    assert sirfs(small_set, *options) == 2
    assert words in capsys.readouterr().err


def test_lines_have_all_columns(small_set: Path, tmp_path: Path) -> None:
    """Numbers with fixed digits, a dash for what is not known."""
    target = tmp_path / "s.json"
    assert sirfs(small_set, "--json", str(target), "--setting", "natural") == 0
    document = document_of(target)
    document["rows"][0]["l_mse"] = None
    lines = sirfs_lines(document)
    assert [len(line) for line in lines] == [len(COLUMNS)] * 2 + [0, len(COLUMNS)]
    assert lines[0][COLUMNS.index("L-MSE")] == "-"


def test_table_1_with_sirfs_has_nothing_open(
    small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """All published entries are measured; a quick run leaves out those that need SIRFS."""
    counts = {}
    for name, options in (("whole", ()), ("quick", ("--quick",))):
        target = tmp_path / f"{name}.json"
        command = ["evaluate", "rerendering", "--data", str(small_set), "--workers", "1"]
        assert run([*command, "--json", str(target), *options]) == 0
        document = document_of(target)
        counts[name] = (
            *(len(document["rows"]), len(document["open"]), document["quick"]),
            *(document["provenance"]["cells_done"], document["provenance"]["cells_missing"]),
        )
    assert counts["whole"] == (32, 0, False, 320, 0)
    assert counts["quick"] == (20, 4, True, 160, 0)
    assert "sirfs" in capsys.readouterr().out


def test_status_of_a_quick_run(small_set: Path, tmp_path: Path) -> None:
    """With --quick the cells that need SIRFS are no part of the grid, else they are to run."""
    store = tmp_path / "store"
    command = ["evaluate", "rerendering", "--data", str(small_set), "--workers", "1", "--quick"]
    assert run([*command, "--store", str(store)]) == 0
    found = {}
    for name, options in (("whole", ()), ("quick", ("--quick",))):
        target = tmp_path / f"{name}.json"
        place = ("--store", str(store), "--data", str(small_set), "--json", str(target))
        assert run(["grid", "status", *place, *options]) == 0
        document = document_of(target)
        found[name] = (document["done"], document["to_run"], document["stale"])
        assert run(["grid", "plan", *place, *options]) == 0
        assert document_of(target)["to_run"] == document["to_run"]
    assert found == {"whole": (240, 160, 0), "quick": (240, 0, 0)}
