"""The commands that plan a study: example, design and power."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pytest

from reports.command_line import run
from tests.studies.written_study import changed, write_study


def test_the_example_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The file that is named is there, and can be designed with at once."""
    assert run(["study", "example", str(tmp_path / "example")]) == 0
    file = tmp_path / "example" / "study.toml"
    assert capsys.readouterr().out == f"written: {file}\n"
    assert run(["study", "design", str(file), "--summary"]) == 0
    out = capsys.readouterr().out
    assert "6 tasks, 4 qualification pairs, 2 closing pairs, 4 questions, 72 pictures" in out
    assert "left out: who did not finish, who chose a cartoon" in out


def test_the_balance_table_is_printed_and_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every pair has its counts in the output and the JSON, every trial a row in the CSV."""
    file = write_study(tmp_path)
    outputs = {name: tmp_path / "out" / name for name in ("d.json", "schedules.csv")}
    command = ["study", "design", str(file), "--json", str(outputs["d.json"])]
    assert run([*command, "--schedules", str(outputs["schedules.csv"])]) == 0
    out = capsys.readouterr().out
    for word in ("kitchen", "garden", "desk", "cartoon", "spheres", "perspective", "in a row"):
        assert word in out
    document = json.loads(outputs["d.json"].read_text(encoding="utf-8"))
    assert document["tasks"] == [
        {
            "task": "ours-real",
            "orders": 6,
            "trials": 5,
            "most_in_a_row": document["tasks"][0]["most_in_a_row"],
            "largest_difference": 0,
        }
    ]
    assert document["tasks"][0]["most_in_a_row"] <= 2
    kitchen = next(row for row in document["pairs"] if row["pair"] == "kitchen")
    assert (kitchen["shown"], kitchen["left"], kitchen["right"]) == (4, 2, 2)
    assert len(pd.read_csv(outputs["schedules.csv"])) == 6 * 5
    assert f"hash: {document['hash']}" in out


def test_exclusions_are_told_in_words(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each rule that the file sets is told with its number."""
    assert run(["study", "design", str(write_study(tmp_path)), "--summary"]) == 0
    assert (
        "who answered in less than 400 ms (median), who chose one side in more than 90% of trials,"
        " who left the window more than 3 times"
    ) in capsys.readouterr().out


def test_power_is_printed_drawn_and_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each aim has its sizes for both scopes, a curve with its error, and a panel of the plot."""
    file = write_study(tmp_path)
    figure, document = tmp_path / "power.svg", tmp_path / "power.json"
    options = ["--rate", "0.8", "--methods", "0.7,0.4", "--margin", "0.2", "--groups", "0.9,0.4"]
    options += ["--share", "0.5", "--item-sd", "0", "--draws", "100", "--loss", "0.5"]
    outputs = ["--figure", str(figure), "--json", str(document)]
    assert run(["study", "power", str(file), *options, *outputs]) == 0
    out = capsys.readouterr().out
    for title in (
        "difference: 0.8 from 0.5",
        "difference: 0.7 from 0.4, two tasks",
        "equivalence: 0.5 within 0.2 of 0.5",
        "subpopulations: 0.9 (50%) from 0.4",
    ):
        assert f"Power ± Monte-Carlo standard error, {title}" in out
        assert title in figure.read_text(encoding="utf-8")
    found = json.loads(document.read_text(encoding="utf-8"))
    assert found["model"]["shown"] == 2
    assert len(found["curves"]) == 8
    needed = next(one["needed"] for one in found["curves"] if one["scope"] == "these scenes")
    assert str(2 * needed) in out


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--rate", "1.5"], "expected one or two rates between 0 and 1"),
        (["--methods", "0.5"], "expected 2 numbers with commas between them for --methods"),
        (["--loss", "1"], "expected --loss to be a share from 0 to below 1, got 1"),
        (["--power", "2"], "expected a power from 0.05 to 0.999, got 2"),
        (["--subject-sd", "-1"], "expected subject_sd from 0 to 10, got -1"),
    ],
)
def test_wrong_numbers_of_power_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], words: str
) -> None:
    """One sentence on standard error and exit code 2."""
    assert run(["study", "power", str(write_study(tmp_path)), *options]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("command", ["design", "power"])
def test_a_wrong_study_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    """A key that is not known is told with the file and what was meant."""
    file = write_study(tmp_path, changed("allow_tie", "allow_ties"))
    assert run(["study", command, str(file)]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"relightlab: {file}: Unknown key in [trials] 'allow_ties'.")
    assert "Did you mean 'allow_tie'?" in error
