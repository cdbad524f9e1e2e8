"""Tests of relightlab study analyze: files, marks, sources, and wrong use."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from reports.command_line import run
from reports.study_run import analyze_study
from shading_model.errors import RelightlabError
from studies.analysis.rates import RATE_COLUMNS
from studies.bare_study import bare_study
from studies.exporting import export_study
from studies.response_store import ResponseStore
from studies.simulation import simulate
from studies.study_file import load_study
from studies.tables import StudyData
from tests.studies.written_study import write_study

MAPPING = """
title = "Edits"
name = "edits"
groups = ["gender"]

[columns]
subject = "worker"
item = "question"
outcome = "chose"
side = "side"
left = "A"

[keep]
check = ["passed"]

[[models]]
name = "average"
kind = "gee-independence"
formula = "chose ~ gender"
"""


def foreign_rows() -> list[dict[str, str]]:
    """Return the rows of a foreign file: six workers, four questions, one who failed a check."""
    return [
        {
            "worker": f"w{worker}",
            "question": f"q{question}",
            "chose": str(int((worker + question) % 3 > 0)),
            "side": "AB"[(worker + question) % 2],
            "gender": "mf"[worker % 2],
            "check": "failed" if worker == 5 else "passed",
        }
        for worker in range(6)
        for question in range(4)
    ]


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    """A folder with a foreign file, and its mapping."""
    pd.DataFrame(foreign_rows()).to_csv(tmp_path / "answers.csv", index=False)
    (tmp_path / "mapping.toml").write_text(MAPPING, encoding="utf-8")
    return tmp_path


@pytest.fixture(scope="module")
def simulated() -> StudyData:
    """The answers of simulated observers to a bare study."""
    return simulate(bare_study(pairs=6, tasks=2), 24, seed=5)


def analyze(source: Path | str, folder: Path, *arguments: str) -> dict[str, Any]:
    """Run the command into a folder and return the JSON it writes."""
    file = folder / "result.json"
    out = ["--out", str(folder / "out"), "--json", str(file)]
    assert run(["study", "analyze", str(source), *out, *arguments]) == 0
    document: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return document


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run the command, expect exit code 2, and return the one sentence it fails with."""
    assert run(["study", "analyze", *arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith("relightlab: ")
    assert error.count("\n") == 1
    return error


def with_mapping(folder: Path) -> tuple[str, ...]:
    """Return the options that name the foreign file's mapping."""
    return ("--mapping", str(folder / "mapping.toml"), "--out", str(folder / "out"))


def test_a_foreign_file_by_its_mapping(foreign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The JSON has the agreed keys; exclusions, groups, side and the model are there."""
    document = analyze(foreign / "answers.csv", foreign, *with_mapping(foreign))
    assert all(tuple(row) == RATE_COLUMNS for row in document["rates"])
    levels = [(row["group"], row["level"], row["trials"]) for row in document["rates"]]
    assert levels[:3] == [("all", "all", 20), ("gender", "f", 8), ("gender", "m", 12)]
    assert [level for level in levels if level[0] == "side"] == [
        ("side", "left", 10),
        ("side", "right", 10),
    ]
    assert [tuple(row) for row in document["models"]] == [("model", "term", "estimate", "se")] * 3
    assert [row["term"] for row in document["models"]] == ["(Intercept)", "genderm", "nobs"]
    (step,) = document["exclusions"]
    assert (step["subjects"], step["trials"], step["remaining_subjects"]) == (1, 4, 5)
    assert document["simulated"] is False
    assert document["mark"] == ""
    printed = capsys.readouterr().out
    assert "left out: 1 subject, 4 trials: check is not passed" in printed
    files = {
        path.relative_to(foreign / "out").as_posix() for path in (foreign / "out").rglob("*.*")
    }
    assert {"study.json", "rates.csv", "models.csv", "exclusions.csv"} <= files
    assert {"report/index.html", "report/report.pdf", "figures/rates-plot-1.svg"} <= files


def test_simulated_answers_are_marked_everywhere(
    simulated: StudyData, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """From an export: in the JSON, in print, in each CSV file, each figure and on the page."""
    document = analyze(export_study(simulated, tmp_path / "export"), tmp_path)
    assert document["simulated"] is True
    assert document["mark"] == "SIMULATED"
    printed = capsys.readouterr().out
    assert printed.startswith("SIMULATED DATA: ")
    assert "SIMULATED DATA: not the result of a study" in printed
    tables = sorted((tmp_path / "out").glob("*.csv"))
    assert {"rates.csv", "models.csv", "tests.csv"} <= {path.name for path in tables}
    for path in tables:
        with path.open(encoding="utf-8") as stream:
            assert {row["mark"] for row in csv.DictReader(stream)} == {"SIMULATED"}
    figures = list((tmp_path / "out" / "figures").glob("*.svg"))
    assert figures
    assert all("SIMULATED" in path.read_text(encoding="utf-8") for path in figures)
    assert "SIMULATED DATA" in (tmp_path / "out/report/index.html").read_text(encoding="utf-8")


def test_an_exported_file_keeps_its_mark_under_a_mapping(
    simulated: StudyData, tmp_path: Path
) -> None:
    """The trials of simulated observers are marked even when read as a foreign file."""
    export_study(simulated, tmp_path / "export")
    mapping = '[columns]\nsubject = "subject"\nitem = "pair"\noutcome = "chose_target"\n'
    (tmp_path / "mapping.toml").write_text(mapping, encoding="utf-8")
    trials = tmp_path / "export" / "trials.csv"
    document = analyze(trials, tmp_path, "--mapping", str(tmp_path / "mapping.toml"))
    assert document["simulated"] is True
    assert document["mark"] == "SIMULATED"


def test_a_database_gives_what_its_export_gives(simulated: StudyData, tmp_path: Path) -> None:
    """Rates, models and tests are those of the export, value by value."""
    store = ResponseStore(tmp_path / "answers.sqlite")
    store.write(simulated)
    store.close()
    kept = analyze_study(str(tmp_path / "answers.sqlite"), None)
    exported = analyze_study(str(export_study(simulated, tmp_path / "export")), None)
    for part in ("rates", "models", "tests", "exclusions", "simulated"):
        assert kept[part] == exported[part]


def test_pilot_answers_are_apart_and_marked(simulated: StudyData, tmp_path: Path) -> None:
    """They count only where they are asked for, or are all there is, and say what they are."""
    subjects = simulated.subjects.copy()
    subjects["mode"] = ["pilot"] * 12 + ["live"] * 12
    both = StudyData(subjects, simulated.trials, simulated.questionnaires)
    folder = str(export_study(both, tmp_path / "export"))
    live, pilot = (analyze_study(folder, None, pilot=pilot) for pilot in (False, True))
    assert (live["mark"], pilot["mark"]) == ("", "PILOT")
    assert live["started"]["subjects"] == pilot["started"]["subjects"] == 12


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('item = "question"\n', "", "expected item to be a text"),
        ('outcome = "chose"', 'outcome = "chosen"', "'chosen'. Did you mean 'chose'?"),
        ('groups = ["gender"]', 'groups = ["sex"]', "Unknown column that the mapping names 'sex'"),
        ("[keep]", "[keeps]", "Unknown key in the mapping 'keeps'. Did you mean 'keep'?"),
        ('["passed"]', '["yes"]', "no row is left to analyse"),
        ('left = "A"', 'left = "L"', "Unknown value of the column 'side' 'L'"),
        ('outcome = "chose"', 'outcome = "gender"', "expected numbers from 0 to 1"),
        ("chose ~ gender", "chose gender", "expected a formula such as"),
        ("chose ~ gender", "chose ~ age", "Unknown column in the formula 'age'"),
        ("gee-independence", "gee", "Unknown kind in [[models]] average 'gee'"),
        ('title = "Edits"', "title = ", "is not TOML"),
    ],
)
def test_a_wrong_mapping_is_one_sentence(
    foreign: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, sentence: str
) -> None:
    """What the mapping names and the file does not have, and the like, is told by name."""
    assert old in MAPPING
    (foreign / "mapping.toml").write_text(MAPPING.replace(old, new), encoding="utf-8")
    assert sentence in refused(capsys, str(foreign / "answers.csv"), *with_mapping(foreign))


def test_sources_that_are_none(foreign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A missing file, a CSV without mapping, an empty database, and options that exclude."""
    assert "does not exist" in refused(capsys, str(foreign / "none.sqlite"))
    assert "give --mapping FILE" in refused(capsys, str(foreign / "answers.csv"))
    ResponseStore(foreign / "empty.sqlite").close()
    assert "there are no answers" in refused(capsys, str(foreign / "empty.sqlite"))
    both = (*with_mapping(foreign), "--pilot")
    assert "not both" in refused(capsys, str(foreign / "answers.csv"), *both)
    assert "cannot read" in refused(capsys, str(foreign / "no.csv"), *with_mapping(foreign))


def test_a_study_file_of_other_answers(simulated: StudyData, tmp_path: Path) -> None:
    """Answers to other tasks are refused; to another version of the file they are noted."""
    folder = str(export_study(simulated, tmp_path / "export"))
    example = write_study(tmp_path / "study")
    with pytest.raises(RelightlabError, match="give the study file they were collected with"):
        analyze_study(folder, example)
    own = simulate(load_study(example), 24, seed=1)
    subjects = own.subjects.assign(study_hash="another")
    other = StudyData(subjects, own.trials, own.questionnaires)
    notes = [
        analyze_study(str(export_study(data, tmp_path / name)), example)["notes"]
        for name, data in (("own", own), ("other", other))
    ]
    assert not any("another version" in note for note in notes[0])
    assert notes[1][0].startswith("24 of 24 subjects answered another version")
