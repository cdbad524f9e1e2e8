"""Tests of the commands that record results and hold later ones to them."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from evaluation import gate_measurement
from reports.command_line import run
from shading_model.illumination import PointLights

ONE = ("--dataset", "synthetic", "--workers", "1")


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the gate measure two objects of 40 pixels under two lights."""
    monkeypatch.setattr(gate_measurement, "SYNTHETIC_SIZE", 40)
    monkeypatch.setattr(gate_measurement, "SYNTHETIC_SAMPLES", 1)
    monkeypatch.setattr(gate_measurement, "SYNTHETIC_OBJECTS", ("apple", "pear"))
    monkeypatch.setattr(gate_measurement, "LIGHTS", 2)
    for dataset in gate_measurement.SETS:
        monkeypatch.setitem(gate_measurement.FITTED, dataset, ())


@pytest.fixture
def records(small: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:  # noqa: ARG001
    """Return a folder with a record of the small set."""
    folder = tmp_path / "records"
    assert run(["gate", "record", *ONE, "--records", str(folder), "--reason", "at first"]) == 0
    shown = capsys.readouterr().out
    assert shown == f"written: {folder / 'synthetic.json'} (260 errors)\n"
    return folder


def check(records: Path, *options: str) -> int:
    """Run ``gate check`` against the records of a folder."""
    return run(["gate", "check", *ONE, "--records", str(records), *options])


def multiply(records: Path, factor: float) -> str:
    """Multiply the first error of the record by a factor, and return the name of its row."""
    path = records / "synthetic.json"
    document = json.loads(path.read_text(encoding="utf-8"))
    cell = "natural pear default oracle"
    document["errors"][cell][0] *= factor
    path.write_text(json.dumps(document), encoding="utf-8")
    return f"{cell} 00"


def test_recorded_then_checked(
    records: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Unchanged code passes; what was compared, and for how long, is printed and in the JSON."""
    target = tmp_path / "gate.json"
    assert check(records, "--json", str(target)) == 0
    shown = capsys.readouterr().out
    assert re.search(r"synthetic: 260 errors compared .* \d+ s: 0 worse, 0 better", shown)
    assert "(at first)" in shown
    (comparison,) = json.loads(target.read_text(encoding="utf-8"))["comparisons"]
    assert (comparison["passed"], comparison["compared"]) == (True, 260)


def test_a_worse_cell_fails(records: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Exit code 1, and the cell with old and new value."""
    cell = multiply(records, 0.8)
    assert check(records) == 1
    shown = capsys.readouterr().out
    assert "1 worse, 0 better" in shown
    assert re.search(rf"worse: {cell}: [\d.e-]+ -> [\d.e-]+ \(\+25%\)", shown)
    assert "results improved" not in shown


def test_a_degraded_stage_fails(
    records: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A point-light fit that is 1% too bright fails, and the worst cell comes first."""
    shade = PointLights.shade
    monkeypatch.setattr(PointLights, "shade", lambda *arguments: 1.01 * shade(*arguments))
    assert check(records) == 1
    lines = capsys.readouterr().out.splitlines()
    growth = [float(line.split("(+")[1].rstrip("%)")) for line in lines if "(+" in line]
    assert len(growth) == 10
    assert growth == sorted(growth, reverse=True)


def test_an_improvement_without_a_record_is_told(
    records: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 0, and the command that records the improvement; nothing is recorded."""
    cell = multiply(records, 2)
    before = (records / "synthetic.json").read_bytes()
    assert check(records) == 0
    shown = capsys.readouterr().out
    assert f"better: {cell}" in shown
    assert "results improved and the record does not say so" in shown
    assert (records / "synthetic.json").read_bytes() == before


def test_many_cells_are_counted(records: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No more than ten cells are shown, the others counted."""
    path = records / "synthetic.json"
    document = json.loads(path.read_text(encoding="utf-8"))
    document["errors"] = {key: [0.5 * x for x in row] for key, row in document["errors"].items()}
    path.write_text(json.dumps(document), encoding="utf-8")
    assert check(records) == 1
    shown = capsys.readouterr().out
    assert shown.count("worse: ") == 11
    assert "worse: 250 more, all with --json" in shown


def test_recording_again_says_what_changes(
    records: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before a record is replaced by a worse one, its worse cells are printed."""
    cell = multiply(records, 0.8)
    again = ["gate", "record", *ONE, "--records", str(records), "--reason", "a better protocol"]
    assert run(again) == 0
    shown = capsys.readouterr().out
    assert re.search(r"synthetic: 1 worse, 0 better than the record of .* \(at first\)", shown)
    assert shown.index(f"worse: {cell}") < shown.index("written: ")
    assert '"reason": "a better protocol"' in (records / "synthetic.json").read_text("utf-8")
    assert check(records) == 0


def test_recording_another_protocol_says_so(
    records: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A record that cannot be compared is refused by check, and replaced with a word."""
    path = records / "synthetic.json"
    text = path.read_text(encoding="utf-8")
    path.write_text(re.sub(r'"protocol": ".*"', '"protocol": "table-1 0"', text), "utf-8")
    assert check(records) == 2
    assert "it is of protocol table-1 0" in capsys.readouterr().err
    again = ["gate", "record", *ONE, "--records", str(records), "--reason", "a new protocol"]
    assert run(again) == 0
    assert "the earlier record is replaced unseen" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (["record"], "--reason"),
        (["record", "--reason", " "], "expected --reason to say why"),
        (["record", "--reason", "x", "--dataset", "sinthetic"], "Did you mean 'synthetic'?"),
        (["check", "--dataset", "mitberkeley"], "Did you mean 'mit-berkeley'?"),
        (["check", "--dataset", "synthetic", "--records", "no such folder"], "there is no record"),
    ],
)
def test_wrong_use(command: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Exit code 2 and one sentence, before anything is measured."""
    assert run(["gate", *command]) == 2
    shown = capsys.readouterr()
    assert words in shown.err
    assert shown.out == ""


def test_without_the_measured_set(
    records: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Asked for by name MIT-Berkeley must be there; else only the synthetic set is measured."""
    (tmp_path / "hdri").mkdir()
    (tmp_path / "hdri" / "a.exr").touch()
    there = ["--data", str(tmp_path), "--records", str(records), "--workers", "1"]
    assert run(["gate", "check", "--dataset", "mit-berkeley", *there]) == 2
    assert "mit-berkeley was not found" in capsys.readouterr().err
    assert run(["gate", "check", *there]) == 0
    shown = capsys.readouterr().out
    assert "only the synthetic set is measured" in shown
    assert "synthetic: 260 errors" in shown


@pytest.mark.slow
@pytest.mark.real_data
def test_the_measured_set_is_recorded_and_checked(
    small: None,  # noqa: ARG001
    mit_berkeley_root: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Chosen objects of MIT-Berkeley are recorded with their learned thresholds, and pass."""
    monkeypatch.setattr(gate_measurement, "MIT_OBJECTS", ("cup1", "sun"))
    options = ["--dataset", "mit-berkeley", "--data", str(mit_berkeley_root.parent)]
    options += ["--records", str(tmp_path), "--workers", "1"]
    assert run(["gate", "record", *options, "--reason", "a reason"]) == 0
    assert run(["gate", "check", *options]) == 0
    assert "mit-berkeley: 260 errors compared" in capsys.readouterr().out
