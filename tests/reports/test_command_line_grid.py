"""Tests of the commands that look after the store of measured cells."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from datasets.synthetic import synthesize
from reports.command_line import run


@pytest.fixture(scope="module")
def small_set(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a synthetic set of one small object."""
    folder = tmp_path_factory.mktemp("set")
    synthesize(folder, size=40, samples=1, objects=["apple"], workers=1)
    return folder


@pytest.fixture(scope="module")
def store(small_set: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a store that holds half of the cells and their models."""
    folder = tmp_path_factory.mktemp("half") / "store"
    command = ["evaluate", "rerendering", "--data", str(small_set), "--workers", "1"]
    command.append("--quick")
    only = ["--only", "setting=natural", "--keep-models", "--store", str(folder)]
    assert run([*command, *only]) == 3
    return folder


def grid(command: str, store: Path, small_set: Path, target: Path) -> dict[str, Any]:
    """Run a command on the half store and return the document it wrote."""
    options = ["--store", str(store), "--data", str(small_set), "--json", str(target), "--quick"]
    assert run(["grid", command, *options]) == 0
    document: dict[str, Any] = json.loads(target.read_text())
    return document


def test_status(
    store: Path, small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Half of the cells are done; the same numbers are printed and written."""
    document = grid("status", store, small_set, tmp_path / "s.json")
    assert (document["cells"], document["done"], document["to_run"]) == (120, 60, 60)
    assert (document["blobs"], document["damaged_blobs"]) == (2, {})
    assert f"table-1 1 in {store}: 60 done, 60 to run" in capsys.readouterr().out


def test_status_of_a_store_that_is_not_there(small_set: Path, tmp_path: Path) -> None:
    """A folder without a store holds nothing, and is not made."""
    document = grid("status", tmp_path / "none", small_set, tmp_path / "s.json")
    assert (document["done"], document["to_run"]) == (0, 120)
    assert not (tmp_path / "none").exists()


def test_damage_is_told(
    store: Path, small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A damaged line and a deleted model are named, each with what happens next."""
    copy = tmp_path / "copy"
    assert run(["grid", "merge", str(copy), str(store)]) == 0
    with (copy / "rows.jsonl").open("ab") as stream:
        stream.write(b"nonsense\n")
    next((copy / "blobs").glob("*/*.npz")).write_bytes(b"")
    document = grid("status", copy, small_set, tmp_path / "s.json")
    assert document["damaged"] == [62]
    shown = capsys.readouterr().out
    assert "1 damaged lines (line 62) are measured again" in shown
    assert "its content does not fit its SHA-256; it is made again" in shown


def test_plan_is_the_same_wherever_it_is_asked_for(
    store: Path, small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """``grid plan`` and ``evaluate rerendering --plan`` agree, and run nothing."""
    before = (store / "rows.jsonl").read_bytes()
    document = grid("plan", store, small_set, tmp_path / "p.json")
    assert (document["to_run"], document["tasks"], document["measured"]) == (60, 1, 60)
    assert document["cpu_hours"] > 0
    assert document["blob_bytes"] > document["row_bytes"] > 0
    other = tmp_path / "e.json"
    command = ["evaluate", "rerendering", "--data", str(small_set), "--store", str(store)]
    assert run([*command, "--quick", "--plan", "--json", str(other)]) == 0
    assert json.loads(other.read_text()) == document
    assert (store / "rows.jsonl").read_bytes() == before
    assert capsys.readouterr().out.count("60 to run in 1 tasks") == 2


def test_reproduce_can_be_planned(
    small_set: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """``reproduce --plan`` says what it would measure, and writes nothing."""
    out = tmp_path / "out"
    assert run(["reproduce", "--data", str(small_set), "--out", str(out), "--quick", "--plan"]) == 0
    shown = capsys.readouterr().out
    assert "120 cells, 0 done, 120 to run in 2 tasks" in shown
    assert "base-shapes 1: 40 cells, 0 done, 40 to run in 1 tasks" in shown
    assert not out.exists()


def test_archive_verify_and_merge(
    store: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An archive is verified and merged elsewhere; merging it again adds nothing."""
    archive, target = tmp_path / "a.zip", tmp_path / "target"
    assert run(["grid", "archive", str(store), "--out", str(archive)]) == 0
    assert run(["grid", "verify", str(archive), "--json", str(tmp_path / "v.json")]) == 0
    assert run(["grid", "merge", str(target), str(archive)]) == 0
    assert run(["grid", "merge", str(target), str(archive), str(store)]) == 0
    shown = capsys.readouterr().out
    assert "is whole: 60 rows of table-1 1, 2 blobs" in shown
    assert "60 rows and 2 blobs added" in shown
    assert "0 rows and 0 blobs added" in shown
    assert json.loads((tmp_path / "v.json").read_text())["rows"] == {"table-1 1": 60}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["verify", "none.zip"], "no such file: none.zip"),
        (["archive", "none", "--out", "a.zip"], "none is no store: it has no rows.jsonl"),
        (["archive", "none", "--out", "a.tar"], "end in .zip"),
        (["merge", "target", "none"], "none is no store"),
        (["plan", "--channels", "grey"], "Did you mean 'gray'?"),
    ],
)
def test_wrong_use_is_one_sentence(
    small_set: Path, arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """What cannot be done is told in one sentence, with exit code 2."""
    data = ["--data", str(small_set), "--quick"] if arguments[0] == "plan" else []
    assert run(["grid", *arguments, *data]) == 2
    assert words in capsys.readouterr().err


def test_models_are_kept_in_a_store_only(
    small_set: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Asked to keep models without a store, the command says what is missing."""
    command = ["evaluate", "rerendering", "--data", str(small_set), "--workers", "1"]
    assert run([*command, "--quick", "--keep-models"]) == 2
    assert "give its folder with --store" in capsys.readouterr().err
