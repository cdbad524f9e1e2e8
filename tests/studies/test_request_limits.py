"""Limits of size and rate, at the door of the server."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from studies.request_limits import UNLIMITED, Buckets, RequestLimits
from studies.response_store import ResponseStore
from studies.server import make_app
from studies.study_records import Study
from tests.studies.small_study import answer
from tests.studies.web_client import TestClient

TIGHT = RequestLimits(2_000, 1.0, 3.0, 1.0, 12.0, 1.0, 4.0)


@pytest.fixture
def client(sqlite_store: ResponseStore, study: Study) -> Iterator[TestClient]:
    """A client of a server with tight limits."""
    app = make_app(study, sqlite_store, limits=TIGHT, require_ids=False)
    with TestClient(app) as opened:
        yield opened


def token_of(client: TestClient) -> str:
    """Open a session."""
    token: str = client.post("/api/sessions", json={}).json()["token"]
    return token


def test_a_bucket_refills_at_its_rate() -> None:
    """After a burst, requests are let through at the rate, and no more than a burst is saved."""
    seconds = [0.0]
    buckets = Buckets(2.0, 3.0, lambda: seconds[0])
    assert [buckets.wait("a") for _ in range(4)] == [0.0, 0.0, 0.0, 0.5]
    assert buckets.wait("b") == 0.0
    seconds[0] = 0.5
    assert [buckets.wait("a") for _ in range(2)] == [0.0, 0.5]
    seconds[0] = 1000.0
    assert [buckets.wait("a") > 0 for _ in range(4)] == [False, False, False, True]


def test_buckets_forget_the_least_used(monkeypatch: pytest.MonkeyPatch) -> None:
    """Memory is bounded, however many keys come."""
    monkeypatch.setattr("studies.request_limits.MOST_KEPT", 10)
    buckets = Buckets(1.0, 1.0, lambda: 0.0)
    for number in range(100):
        buckets.wait(str(number))
    assert len(buckets._kept) == 10


def test_one_session_cannot_flood(client: TestClient) -> None:
    """Beyond its burst a session is told when to come again; another session is not held up."""
    first, second = token_of(client), token_of(client)
    path = f"/api/sessions/{first}/events"
    answers = [client.post(path, json={"event": "blur"}) for _ in range(5)]
    assert [one.status_code for one in answers] == [200, 200, 200, 429, 429]
    assert int(answers[-1].headers["retry-after"]) >= 1
    assert client.put(f"/api/sessions/{second}/trials/0", json=answer()).status_code == 200


def test_one_address_cannot_open_without_end(client: TestClient) -> None:
    """Openings have a limit of their own."""
    codes = [client.post("/api/sessions", json={}).status_code for _ in range(6)]
    assert codes == [200] * 4 + [429] * 2


def test_tokens_cannot_be_guessed_without_end(client: TestClient) -> None:
    """Unknown tokens count against the address they come from."""
    codes = [client.get(f"/api/sessions/{number}").status_code for number in range(14)]
    assert codes == [404] * 12 + [429] * 2


def test_files_are_not_counted(client: TestClient) -> None:
    """A subject loads all pictures at once, and is not refused for it."""
    assert {client.get("/stimuli/none.png").status_code for _ in range(30)} == {404}


def test_large_bodies_are_refused(client: TestClient, sqlite_store: ResponseStore) -> None:
    """More than the limit is 413, whether the size is declared or not, and nothing is stored."""
    path = f"/api/sessions/{token_of(client)}/events"
    headers = {"content-type": "application/json"}
    large = b'{"event": "note", "detail": "' + b"x" * 2_000 + b'"}'
    assert client.post(path, content=large, headers=headers).status_code == 413

    def pieces() -> Iterator[bytes]:
        yield from (large[start : start + 100] for start in range(0, len(large), 100))

    assert client.post(path, content=pieces(), headers=headers).status_code == 413
    lied = headers | {"content-length": "-5"}
    assert client.post(path, content=b"{}", headers=lied).status_code == 413
    assert len(sqlite_store.read().events) == 0


def test_simulated_subjects_have_no_limit_of_rate(
    sqlite_store: ResponseStore, study: Study
) -> None:
    """A server of simulated sessions limits the size alone."""
    with TestClient(make_app(study, sqlite_store, mode="simulated")) as client:
        codes = {client.post("/api/sessions", json={}).status_code for _ in range(125)}
    assert codes == {200}
    assert UNLIMITED.body_bytes == RequestLimits().body_bytes
