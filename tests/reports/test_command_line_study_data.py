"""Tests of the commands that export, import and simulate the answers of studies."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from reports.command_line import run
from studies.exporting import read_export
from studies.response_store import ResponseStore
from tests.studies.test_published_sets import DYNAVECT_ROWS, written

STUDY = """
name = "tiny"
title = "Which?"
seed = 1
consent = "You may stop at any time."
instructions = "Choose."

[[tasks]]
name = "real"
title = "Ours against real pictures"
target = "ours"
other = "real"
target_files = "{pair}-a.png"
other_files = "{pair}-b.png"
pairs = ["p1", "p2"]
"""


@pytest.fixture
def study_file(tmp_path: Path) -> Path:
    """A study of two pairs."""
    from PIL import Image

    for number, name in enumerate(["p1-a", "p1-b", "p2-a", "p2-b"]):
        Image.new("RGB", (8, 8), (10 * number, 0, 0)).save(tmp_path / f"{name}.png")
    return written(tmp_path / "study.toml", STUDY)


def test_simulated_answers_bear_their_mark_from_end_to_end(
    study_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Simulated into a database, exported, imported into another: marked and said at each step."""
    first, second = (str(tmp_path / f"{name}.sqlite") for name in ("a", "b"))
    out = str(tmp_path / "export")
    steps = [
        ["simulate", str(study_file), "--subjects", "4", "--rate", "real=0.9", "--database", first],
        ["export", first, "--out", out],
        ["import", out, "--format", "export", "--database", second],
    ]
    for step in steps:
        assert run(["study", *step]) == 0
        assert "4 of 4 are simulated, not given by people" in capsys.readouterr().out
    assert read_export(Path(out)).simulated
    assert ResponseStore(second).read().marks == ("simulated",)


def test_simulating_again_changes_nothing(
    study_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The same seed gives the same subjects, who are there already."""
    command = ["study", "simulate", str(study_file), "--subjects", "2"]
    for added in (2, 0):
        assert run([*command, "--database", str(tmp_path / "a.sqlite")]) == 0
        assert f"{added} subjects, {2 * added} trials" in capsys.readouterr().out
    assert run([*command, "--out", str(tmp_path / "export")]) == 0
    assert len(read_export(tmp_path / "export").trials) == 4


def test_importing_twice_says_what_was_added(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The second import adds nothing, and the JSON says so."""
    file = written(tmp_path / "a.csv", DYNAVECT_ROWS)
    target = tmp_path / "added.json"
    command = ["study", "import", str(file), "--format", "dynavect-2afc"]
    command += ["--database", str(tmp_path / "a.sqlite"), "--json", str(target)]
    for subjects, trials in ((1, 2), (0, 0)):
        assert run(command) == 0
        assert f"{subjects} subjects, {trials} trials" in capsys.readouterr().out
        added = {"subjects": subjects, "trials": trials, "questionnaires": subjects, "events": 0}
        assert json.loads(target.read_text()) == {"added": added, "marks": []}


def test_a_mapping_tells_what_columns_mean(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Any CSV is imported by a mapping, and a panel's export joined to who is there."""
    file = written(tmp_path / "a.csv", "who,picture,won\na,p1,1\nb,p1,0\n")
    columns = '[columns]\nsubject = "who"\nitem = "picture"\noutcome = "won"\n'
    mapping = written(tmp_path / "a.toml", columns)
    database = ["--database", str(tmp_path / "a.sqlite")]
    by_mapping = ["--format", "csv", "--mapping", str(mapping)]
    assert run(["study", "import", str(file), *by_mapping, *database]) == 0
    assert "2 subjects, 2 trials" in capsys.readouterr().out
    panel = written(tmp_path / "p.csv", "Participant id,Age\nx,31\n")
    assert run(["study", "import", str(panel), "--format", "prolific", *database]) == 0
    assert "0 of 1 participants are subjects" in capsys.readouterr().out


def test_pilots_are_exported_apart(
    study_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An export has no pilots unless they are asked for, and then says that they are."""
    from studies.study_file import load_study

    store = ResponseStore(tmp_path / "a.sqlite")
    for mode in ("live", "pilot"):
        store.open_session(load_study(study_file), mode=mode)
    store.close()
    command = ["study", "export", str(tmp_path / "a.sqlite"), "--out", str(tmp_path / "export")]
    for more, modes in (([], ["live"]), (["--pilot"], ["pilot"])):
        assert run([*command, *more]) == 0
        assert ("of a pilot" in capsys.readouterr().out) is bool(more)
        assert read_export(tmp_path / "export").subjects["mode"].tolist() == modes


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["export", "no.sqlite", "--out", "x"], "no.sqlite"),
        (["import", "a.csv", "--format", "mturck", "--database", "b"], "Did you mean 'mturk'?"),
        (["import", "no.csv", "--format", "mturk", "--database", "b"], "cannot read no.csv"),
        (["simulate", "{study}", "--subjects", "2"], "expected one of --http URL, --database URL"),
        (["simulate", "{study}", "--subjects", "0", "--out", "x"], "expected from 1 to 100000"),
        (["simulate", "{study}", "--subjects", "1", "--rate", "rael=1", "--out", "x"], "'real'?"),
        (["simulate", "{study}", "--subjects", "1", "--rate", "x", "--out", "x"], "--rate TASK="),
        (
            ["simulate", "{study}", "--subjects", "1", "--rate", "2", "--out", "x"],
            "between 0 and 1",
        ),
        (["simulate", "{study}", "--subjects", "1", "--at-once", "0", "--out", "x"], "--at-once"),
    ],
)
def test_wrong_use_is_one_sentence(
    arguments: list[str],
    sentence: str,
    study_file: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What cannot be done is told in one line with exit code 2."""
    monkeypatch.chdir(tmp_path)
    given = [part.replace("{study}", str(study_file)) for part in arguments]
    assert run(["study", *given]) == 2
    told = capsys.readouterr().err
    assert sentence in told
    assert told.count("\n") == 1
