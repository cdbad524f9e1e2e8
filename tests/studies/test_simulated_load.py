"""Load and sudden ends: many subjects at once on a real server, killed at random moments."""

from __future__ import annotations

import random
import shutil
import sqlite3
import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest

from shading_model.errors import RelightlabError
from studies.example_study import write_example
from studies.response_store import ResponseStore
from studies.server import make_app
from studies.server_process import ServerProcess, running_server
from studies.simulated_load import LoadPlan, SubjectLog, judge_load, run_load
from studies.study_file import load_study
from tests.studies.small_study import write_small_study
from tests.studies.web_client import threaded_server

TRIALS = 5


@pytest.fixture(scope="module")
def study_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a study of five trials."""
    return write_small_study(tmp_path_factory.mktemp("served"))


@pytest.fixture
def key_file(address: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Where the server's process finds the key: by the file, or in a user's folder of the test."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    from studies.store_engine import Database

    return Database(address).key_path()


def test_nothing_is_lost_or_doubled(address: str, key_file: Path, study_file: Path) -> None:
    """Every acknowledged answer of subjects who come at once is there once."""
    store = ResponseStore(address, key_file=key_file)
    app = make_app(load_study(study_file), store, mode="simulated")
    plan = LoadPlan(subjects=12, think_seconds=0.02)
    with threaded_server(app) as served:
        result = judge_load(*run_load(served, plan), store.read(), store.key)
    assert (result.lost, result.doubled, result.wrong_codes) == (0, 0, 0)
    assert result.subjects == plan.subjects
    assert result.posts >= len(store.read().trials) == TRIALS * plan.subjects
    assert 0.0 < result.p50_ms <= result.p95_ms <= result.p99_ms
    store.close()


@pytest.mark.nightly
def test_two_hundred_subjects_at_once(address: str, key_file: Path, tmp_path: Path) -> None:
    """With 200 subjects at the example study, 95% of posts are acknowledged within 100 ms."""
    store = ResponseStore(address, key_file=key_file)
    plan = LoadPlan(subjects=200, think_seconds=2.0)
    with running_server(write_example(tmp_path / "example"), address) as served:
        result = judge_load(*run_load(served, plan), store.read(), store.key)
    assert (result.lost, result.doubled, result.wrong_codes) == (0, 0, 0)
    assert result.subjects == plan.subjects
    assert result.p95_ms < 100.0
    store.close()


@pytest.mark.slow
def test_a_killed_server_has_every_acknowledged_answer_once(
    tmp_path: Path, study_file: Path
) -> None:
    """Kill -9 twice at random moments under load: all goes on afterwards, and nothing is lost."""
    address = str(tmp_path / "answers.sqlite")
    kill_under_load(address, Path(f"{address}.key"), study_file, kills=2)


@pytest.mark.nightly
def test_a_server_killed_twenty_times_has_every_acknowledged_answer_once(
    address: str, key_file: Path, study_file: Path
) -> None:
    """The same, on either database, for as long as it takes to kill the server 20 times."""
    kill_under_load(address, key_file, study_file, kills=20)


def kill_under_load(address: str, key_file: Path, study_file: Path, kills: int) -> None:
    """Kill and restart the server under load, then hold what is stored against what was said."""
    server = ServerProcess(study_file, address)
    served = server.start()
    done = threading.Event()
    count = [0]

    def harass() -> None:
        moments = random.Random(kills)
        while count[0] < kills and not done.wait(moments.uniform(0.2, 0.9)):
            server.kill()
            count[0] += 1
            server.start()

    thread = threading.Thread(target=harass)
    thread.start()
    logs: list[SubjectLog] = []
    try:
        while count[0] < kills:  # one wave of subjects after another, until all is done
            plan = LoadPlan(16, think_seconds=0.3, seed=len(logs), patience_seconds=120.0)
            logs += run_load(served, plan)[0]
    finally:
        done.set()
        thread.join()
        server.kill()
    assert count[0] == kills
    store = ResponseStore(address, key_file=key_file)
    result = judge_load(logs, 0.0, store.read(), store.key)
    assert (result.lost, result.doubled, result.wrong_codes) == (0, 0, 0)
    assert result.subjects == len(logs)
    assert result.repeats > 0
    store.close()
    if store.database.is_sqlite:
        with sqlite3.connect(address) as connection:
            assert connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        connection.close()


def test_a_loss_would_be_found(sqlite_store: ResponseStore, study_file: Path) -> None:
    """The judge counts what is not stored, stored otherwise, or stored and never given."""
    from tests.studies.test_response_store import LEFT

    session = sqlite_store.open_session(load_study(study_file), mode="simulated")
    for trial in (0, 1):
        sqlite_store.record(session.token, trial, LEFT)
    log = SubjectLog(session.subject, {0: "left", 1: "left"}, [1.0, 2.0])

    def judged(one: SubjectLog) -> tuple[int, int]:
        result = judge_load([one], 1.0, sqlite_store.read(), sqlite_store.key)
        return result.lost, result.doubled

    assert judged(log) == (0, 0)
    assert judged(replace(log, acknowledged={0: "left", 1: "right"})) == (1, 0)
    assert judged(replace(log, acknowledged={0: "left", 1: "left", 2: "left"})) == (1, 0)
    assert judged(replace(log, acknowledged={0: "left"})) == (0, 1)


def test_a_refusal_is_told(sqlite_store: ResponseStore, study_file: Path) -> None:
    """A live server takes no simulated subject, and where there is no server, that is told."""
    with (
        threaded_server(make_app(load_study(study_file), sqlite_store)) as served,
        pytest.raises(RelightlabError, match="refused what a simulated subject sent: 403"),
    ):
        run_load(served, LoadPlan(subjects=1))
    started = time.monotonic()
    with pytest.raises(RelightlabError, match=r"did not take an answer for 0\.2 s"):
        run_load(served, LoadPlan(subjects=1, patience_seconds=0.2))
    assert time.monotonic() - started < 10.0


def test_a_server_that_cannot_start_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A process that ends before it serves is told, not waited for."""
    monkeypatch.setattr("sys.executable", str(shutil.which("false")))
    with pytest.raises(RelightlabError, match="did not start"):
        ServerProcess(tmp_path / "none.toml", str(tmp_path / "a.sqlite")).start()
