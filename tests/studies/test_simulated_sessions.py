"""Tests of simulated subjects that take part over HTTP."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import httpx
import pytest

from shading_model.errors import RelightlabError
from studies import simulated_sessions
from studies.observers import ObserverModel
from studies.response_store import ResponseStore
from studies.server import make_app
from studies.simulated_sessions import simulate_http
from studies.stimulus_recognition import pixel_digest, stimulus_book
from studies.study_records import Study
from tests.studies.small_study import small_study

HOST = "http://study"
MODEL = ObserverModel(rate=0.9, subject_sd=0.1, item_sd=0.1, lapse=0, qualification=0.999)


@pytest.fixture
def server(study: Study, sqlite_store: ResponseStore) -> httpx.ASGITransport:
    """A server of simulated sessions, without a network."""
    return httpx.ASGITransport(make_app(study, sqlite_store, mode="simulated"))


def test_observers_answer_through_the_interface(
    study: Study, sqlite_store: ResponseStore, server: httpx.ASGITransport
) -> None:
    """What the server acknowledged is in the store, whole, as the observers chose, and marked."""
    done = simulate_http(HOST, study, 6, MODEL, transport=server)
    data = sqlite_store.read()
    stored = data.trials.set_index(["subject", "trial"])["response"].to_dict()
    assert stored == done.acknowledged
    assert data.simulated
    assert set(data.subjects["subject"]) == set(done.codes)
    assert (data.subjects["status"] == "complete").all()
    assert data.subjects["age"].notna().all()
    # Were left and right mixed up, most would take the other picture.
    assert data.trials["chose_target"].mean() > 0.75
    assert len(done.milliseconds) == len(data.trials)


def test_taking_part_again_changes_nothing(
    study: Study, sqlite_store: ResponseStore, server: httpx.ASGITransport
) -> None:
    """Observers who come back find their sessions finished, and get the same codes."""
    first = simulate_http(HOST, study, 3, MODEL, transport=server)
    before = sqlite_store.read()
    again = simulate_http(HOST, study, 3, MODEL, transport=server)
    assert again.codes == first.codes
    assert len(sqlite_store.read().trials) == len(before.trials)


def test_who_stops_has_no_code(study: Study, server: httpx.ASGITransport) -> None:
    """Observers who leave are unfinished, as the model says."""
    done = simulate_http(HOST, study, 3, replace(MODEL, dropout=1), transport=server)
    assert len(done.unfinished) == 3
    assert done.codes == {}


def test_pairs_are_known_by_their_pixels(study: Study, tmp_path: Path) -> None:
    """Each pair is recognised either way round; pictures of another study are one sentence."""
    book = stimulus_book(study)
    task = study.tasks[1]
    target, other = (book.digests[path] for path in (task.pairs[0].target, task.pairs[0].other))
    name, shown = book.recognise([(target, other), (other, target)])
    assert name == task.name
    assert [trial.target_side for trial in shown] == ["left", "right"]
    assert [trial.position for trial in shown] == [1, 2]
    with pytest.raises(RelightlabError, match="trial 0 of the server shows no pair of the study"):
        book.recognise([(target, target)])
    (tmp_path / "a.txt").write_text("no picture")
    with pytest.raises(RelightlabError, match="sent a stimulus that is no picture"):
        pixel_digest((tmp_path / "a.txt").read_bytes())


def test_a_server_of_people_is_left_alone(study: Study, sqlite_store: ResponseStore) -> None:
    """Simulated observers open no session among those of people."""
    live = httpx.ASGITransport(make_app(study, sqlite_store))
    with pytest.raises(RelightlabError, match="takes live answers, which simulated ones must not"):
        simulate_http(HOST, study, 1, transport=live)
    assert sqlite_store.read().subjects.empty


def test_another_study_is_told(server: httpx.ASGITransport, tmp_path: Path) -> None:
    """A server of another study than the file is one sentence."""
    other = replace(small_study(tmp_path), name="other")
    with pytest.raises(RelightlabError, match="serves the study 'small', expected 'other'"):
        simulate_http(HOST, other, 1, transport=server)


def answering(reply: Callable[[int], httpx.Response]) -> httpx.MockTransport:
    """A server that replies by the number of the request."""
    count = iter(range(10_000))
    return httpx.MockTransport(lambda _request: reply(next(count)))


def test_a_busy_server_is_asked_again(
    study: Study, server: httpx.ASGITransport, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Requests that a busy server does not take are sent again, and no answer is lost."""
    monkeypatch.setattr(simulated_sessions, "FIRST_WAIT_SECONDS", 0.0)

    class Busy(httpx.AsyncBaseTransport):
        count = 0

        async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
            self.count += 1
            if self.count % 3 == 0:
                return httpx.Response(503)
            if self.count % 7 == 0:
                raise httpx.ReadError("the line broke")
            return await server.handle_async_request(request)

    done = simulate_http(HOST, study, 2, MODEL, transport=Busy())
    assert len(done.codes) == 2
    assert done.repeats > 5


@pytest.mark.parametrize(
    ("reply", "sentence"),
    [
        (httpx.Response(503), r"did not take GET api/study in 8 attempts \(it answered 503\)"),
        (httpx.Response(404), "the server refused GET api/study: it answered 404"),
        (httpx.Response(400, json={"detail": "no such"}), "refused GET api/study: no such"),
    ],
)
def test_a_server_that_will_not_is_told(
    study: Study, reply: httpx.Response, sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A server that stays busy or refuses is one sentence."""
    monkeypatch.setattr(simulated_sessions, "FIRST_WAIT_SECONDS", 0.0)
    with pytest.raises(RelightlabError, match=sentence):
        simulate_http(HOST, study, 1, transport=answering(lambda _: reply))
