"""The commands that run a study: serve, verify-codes, export-subject, delete-subject, load-test."""

from __future__ import annotations

import io
import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import httpx
import pytest

from reports.command_line import run
from studies.page_build import BUILT
from studies.response_store import ResponseStore
from studies.session_records import TrialAnswer
from studies.study_records import Study
from tests.studies.small_study import IDS, small_study, write_small_study

ANSWER = TrialAnswer("left", 900.5, 850.25, 1, 1280.0, 720.0)
START = [sys.executable, "-c", "from reports.command_line import main; main()", "study", "serve"]


@pytest.fixture
def study(tmp_path: Path) -> Study:
    """A study with pictures."""
    return small_study(tmp_path / "study")


@pytest.fixture
def answered(tmp_path: Path, study: Study) -> tuple[str, dict[str, str]]:
    """A database with two complete workers, anna and ben, and their codes."""
    database = tmp_path / "answers.sqlite"
    store = ResponseStore(database)
    codes = {}
    for worker in ("anna", "ben"):
        token = store.open_session(study, IDS | {"PROLIFIC_PID": worker}).token
        for trial in range(6):
            store.record(token, trial, ANSWER)
        store.record_questionnaire(token, {"age": "31"})
        codes[worker] = store.finish(token)
    store.close()
    return str(database), codes


def test_codes_are_verified(
    answered: tuple[str, dict[str, str]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Valid codes end with 0; a code of nobody, or of another worker, is named and ends with 1."""
    database, codes = answered
    export = tmp_path / "export.csv"
    rows = [f"{worker},{code}" for worker, code in codes.items()]
    export.write_text("\n".join(["Participant id,Completion code", *rows]))
    assert run(["study", "verify-codes", database, str(export)]) == 0
    assert capsys.readouterr().out.count("valid") == 2
    export.write_text(f"Participant id,Completion code\nben,{codes['anna']}\nanna,NOCODE\n")
    result = tmp_path / "codes.json"
    assert run(["study", "verify-codes", database, str(export), "--json", str(result)]) == 1
    shown = capsys.readouterr().out
    assert "of another worker" in shown
    assert "unknown" in shown
    document = json.loads(result.read_text())
    assert sorted(document["codes"].values()) == sorted(codes.values())
    assert [one["verdict"] for one in document["checked"]] == ["of another worker", "unknown"]


def test_codes_are_listed(
    answered: tuple[str, dict[str, str]], capsys: pytest.CaptureFixture[str]
) -> None:
    """Without a panel's export, every complete subject's code is listed."""
    database, codes = answered
    assert run(["study", "verify-codes", database]) == 0
    shown = capsys.readouterr().out
    assert all(code in shown for code in codes.values())


def test_a_pilots_code_earns_nothing(
    answered: tuple[str, dict[str, str]], study: Study, capsys: pytest.CaptureFixture[str]
) -> None:
    """The code of a pilot session in the same database is known only where pilots are asked for."""
    database, _ = answered
    store = ResponseStore(database)
    token = store.open_session(study, IDS | {"PROLIFIC_PID": "carl"}, "pilot").token
    for trial in range(6):
        store.record(token, trial, ANSWER)
    store.record_questionnaire(token, {"age": "31"})
    code = store.finish(token)
    store.close()
    assert run(["study", "verify-codes", database]) == 0
    assert code not in capsys.readouterr().out
    assert run(["study", "verify-codes", database, "--pilot"]) == 0
    assert code in capsys.readouterr().out


def test_nobody_else_reads_the_database(answered: tuple[str, dict[str, str]]) -> None:
    """The file of the answers can be read by its owner alone."""
    assert Path(answered[0]).stat().st_mode & 0o077 == 0


def test_one_subject_is_given_out_and_deleted(
    answered: tuple[str, dict[str, str]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the panel's id all that is kept of a subject is shown, and then deleted for good."""
    database, _ = answered
    assert run(["study", "export-subject", database, "--worker", "anna"]) == 0
    kept: dict[str, Any] = json.loads(capsys.readouterr().out)
    (subject,) = kept
    assert len(kept[subject]["trials"]) == 6
    file = tmp_path / "subject.json"
    assert run(["study", "export-subject", database, subject, "--json", str(file)]) == 0
    assert json.loads(file.read_text()) == kept
    assert run(["study", "delete-subject", database, "--worker", "anna", "--yes"]) == 0
    assert f"{subject}: " in capsys.readouterr().out
    store = ResponseStore(database)
    assert subject not in store.read().subjects["subject"].tolist()
    assert len(store.read().subjects) == 1
    store.close()


def test_nothing_is_deleted_unasked(
    answered: tuple[str, dict[str, str]],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Without --yes, and without an answer, the subject stays."""
    database, _ = answered
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    assert run(["study", "delete-subject", database, "--worker", "anna"]) == 130
    capsys.readouterr()
    assert run(["study", "export-subject", database, "--worker", "anna"]) == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["verify-codes", "none.sqlite"], "there is no database none.sqlite"),
        (["verify-codes", "mysql://h/n"], "expected a database sqlite"),
        (["export-subject", "DATABASE"], "name one of the two"),
        (["export-subject", "DATABASE", "x", "--worker", "y"], "name one of the two"),
        (["export-subject", "DATABASE", "x"], "has no subject 'x'"),
        (["delete-subject", "DATABASE", "--worker", "eve"], "no subject came with the id 'eve'"),
        (["delete-subject", "DATABASE", "x", "--yes"], "has no subject 'x'"),
        (["verify-codes", "DATABASE", "none.csv"], "none.csv: No such file"),
        (["verify-codes", "DATABASE", "--key", "none.key"], "expected the key of the database"),
        (["serve", "--pilot", "--simulated"], "choose one"),
        (["serve", "none.toml"], "none.toml"),
        (["load-test", "--database", "DATABASE"], "expected an empty database"),
    ],
)
def test_faults_are_told_in_one_sentence(
    answered: tuple[str, dict[str, str]],
    arguments: list[str],
    said: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """What the user can mend ends with 2 and one line that says what."""
    given = [answered[0] if one == "DATABASE" else one for one in arguments]
    assert run(["study", *given]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


@pytest.mark.slow
@pytest.mark.skipif(not (BUILT / "index.html").is_file(), reason="the page is not built")
@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM])
def test_a_study_is_served_until_a_signal(tmp_path: Path, end: signal.Signals) -> None:
    """The command says where it serves, serves the page there, and ends at Ctrl-C in peace."""
    file = write_small_study(tmp_path)
    process = subprocess.Popen(
        [*START, str(file), "--port", "0", "--pilot"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    lines = [process.stdout.readline() for _ in range(3)]
    address = lines[2].removeprefix("serving at ").split()[0]
    with httpx.Client(base_url=address) as client:
        assert "<html" in client.get("").text
        assert client.post("api/sessions", json={}).json()["mode"] == "pilot"
    process.send_signal(end)
    _, error = process.communicate(timeout=30)
    assert error == ""
    assert process.returncode in {0, -signal.SIGTERM}
    assert (tmp_path / "study-pilot.sqlite").is_file()
    assert (tmp_path / "study-pilot.sqlite.key").is_file()


@pytest.mark.slow
def test_a_load_test_says_what_it_measured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The table and the JSON have the quantiles and what was lost: nothing."""
    file, result = write_small_study(tmp_path), tmp_path / "load.json"
    few = ["--subjects", "3", "--think", "0.01", "--json", str(result)]
    assert run(["study", "load-test", str(file), *few]) == 0
    assert "p95 ms" in capsys.readouterr().out
    document = json.loads(result.read_text())
    assert (document["subjects"], document["lost"], document["doubled"]) == (3, 0, 0)
