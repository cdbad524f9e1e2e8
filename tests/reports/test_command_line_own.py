"""Methods and parts of the user's own on the command line."""

from __future__ import annotations

import json
import shlex
import sys
from pathlib import Path

import pytest

from datasets.synthetic import synthesize
from reports.command_line import run
from reports.table1_text import INCOMPLETE

PARTS = "tests.evaluation.own_parts"


@pytest.fixture(scope="module")
def two_objects(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A synthetic set of two small objects."""
    folder = tmp_path_factory.mktemp("set")
    synthesize(folder, size=40, samples=1, objects=["apple", "pear"], workers=1)
    return folder


def rerendering(two_objects: Path, *options: str) -> int:
    """Run ``evaluate rerendering`` in this process and return its exit code."""
    command = ["evaluate", "rerendering", "--data", str(two_objects), "--workers", "1"]
    return run([*command, "--quick", *options])


def test_everything_at_once_has_its_rows(
    two_objects: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A method, a second model and a rule: rows, objects and counts of the document agree."""
    target = tmp_path / "t.json"
    given = ("--method", f"{PARTS}:ball", "--shape", "flat", "--weight-rule", f"{PARTS}:quarter")
    assert rerendering(two_objects, *given, "--json", str(target)) == 0
    document = json.loads(target.read_text(encoding="utf-8"))
    entries = [
        tuple(row[k] for k in ("setting", "method", "detail_source", "weights"))
        for row in document["rows"]
    ]
    assert len(set(entries)) == len(entries) == 2 * (2 * 2 * 6 + 1)
    assert {entry[1] for entry in entries} == {"ours", "ours + flat", f"{PARTS}:ball"}
    cells = 2 * 2 * 20
    assert document["provenance"]["cells_done"] == cells * (2 + 2 + 1)
    assert {row["method"] for row in document["own_objects"]} == {"ours + flat", f"{PARTS}:ball"}
    flat = next(row for row in document["baselines"] if row["setting"] == "natural")
    own = next(
        row
        for row in document["rows"]
        if (row["method"], row["weights"], row["detail_source"])
        == ("ours + flat", "coarse", "default")
    )
    assert own["imse"] == pytest.approx(flat["imse"], rel=1e-9)
    assert "its own" in capsys.readouterr().out


def test_a_failing_command_leaves_the_table_incomplete(
    two_objects: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its cells are named with the reason, the exit code says so, and ours are whole."""
    target = tmp_path / "t.json"
    words = [sys.executable, "-c", "import sys; sys.exit('no GPU')", "{inputs}", "{outputs}"]
    command = ("--method-command", shlex.join(words).replace("'{", "{").replace("}'", "}"))
    assert rerendering(two_objects, *command, "--json", str(target)) == INCOMPLETE
    told = capsys.readouterr().err
    assert "INCOMPLETE: 80 cells are missing" in told
    assert "the command ended with exit code 1; it said last: no GPU" in told
    rows = json.loads(target.read_text(encoding="utf-8"))["rows"]
    assert {row["cells"] for row in rows if row["method"] == "ours"} == {40}
    assert {row["imse"] for row in rows if row["method"] != "ours"} == {None}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--method", "paper-modle"], "Did you mean 'paper-model'?"),
        (["--method", f"{PARTS}:constant"], "relight returned the same image under two"),
        (["--shape", "contuor"], "Unknown base shape 'contuor'. Did you mean 'contour'?"),
        (["--detail-layer", "spars"], "Did you mean 'sparse'?"),
        (["--weight-rule", "oracle"], "stands in Table 1 already"),
        (["--method-command", "relight"], "expected {inputs} and {outputs}"),
        (
            ["--method-command", "a {inputs} {outputs}", "--method-seconds", "-1"],
            "expected a time limit above zero",
        ),
        (["--dataset", "mit-berkely"], "Did you mean 'mit-berkeley'?"),
    ],
)
def test_wrong_choices_are_told_before_anything_is_measured(
    two_objects: Path, options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """One sentence, exit code 2, no cell measured."""
    assert rerendering(two_objects, *options) == 2
    told = capsys.readouterr()
    assert words in told.err
    assert "measuring" not in told.out + told.err
