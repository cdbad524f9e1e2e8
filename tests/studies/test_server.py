"""The web server of a study: what it takes, what it refuses, and what it never tells."""

from __future__ import annotations

import json
import re
import sqlite3
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sqlalchemy import event

from studies.request_limits import UNLIMITED
from studies.request_schemas import clean
from studies.response_store import ResponseStore
from studies.server import make_app
from studies.study_records import Study
from studies.tables import MODES
from tests.studies.small_study import IDS, answer
from tests.studies.web_client import TestClient

TRIALS = 6
SCRIPT = "<script>alert(1)</script><img src=x onerror=alert(2)>"


@pytest.fixture
def client(sqlite_store: ResponseStore, study: Study) -> Iterator[TestClient]:
    """A live server's client."""
    with TestClient(make_app(study, sqlite_store)) as opened:
        yield opened


def opened(client: TestClient, **body: Any) -> dict[str, Any]:
    """Open a session and return its document."""
    response = client.post("/api/sessions", json={"ids": IDS} | body)
    assert response.status_code == 200, response.text
    document: dict[str, Any] = response.json()
    return document


def put(client: TestClient, token: str, trial: int, **changes: Any) -> Any:
    """Send an answer and return the response."""
    return client.put(f"/api/sessions/{token}/trials/{trial}", json=answer(**changes))


def test_a_whole_session(client: TestClient, sqlite_store: ResponseStore) -> None:
    """A subject opens, answers, completes, and has the code that the stored data gives."""
    from studies.completion_codes import completion_codes

    session = opened(client, display={"width": 1440, "height": 900, "pixel_ratio": 2})
    assert (session["mode"], session["status"], session["answered"]) == ("live", "started", [])
    path = f"/api/sessions/{session['token']}"
    for trial in session["schedule"]:
        assert put(client, session["token"], trial["index"]).json() == {
            "trial": trial["index"],
            "state": "stored",
        }
    early = client.post(f"{path}/completion")
    assert (early.status_code, early.json()["questions"]) == (409, ["age"])
    answers = {"answers": {"age": 31, "expertise": "yes", "comment": SCRIPT, "gender": None}}
    assert client.put(f"{path}/questionnaire", json=answers).json() == {"state": "stored"}
    assert client.put(f"{path}/questionnaire", json=answers).json() == {"state": "repeated"}
    done = client.post(f"{path}/completion", json={}).json()
    assert done["redirect"] == f"https://panel.example/complete?cc={done['code']}"
    data = sqlite_store.read()
    assert completion_codes(sqlite_store.key, data) == {session["subject"]: done["code"]}
    assert SCRIPT in data.questionnaires["answer"].tolist()
    again = client.get(path).json()
    assert (again["status"], again["resumed"]) == ("complete", True)
    assert again["answered"] == list(range(TRIALS))


def test_the_page_is_not_told_whose_picture_is_which(client: TestClient, study: Study) -> None:
    """Nothing a subject gets names a condition, a task, a side, a file or a test of attention."""
    session = opened(client)
    told = json.dumps(session)
    for secret in ("target", "task-1", "ours", "qualification", "pair-1", "-a.png", "condition"):
        assert secret not in told
    addresses = [trial[side] for trial in session["schedule"] for side in ("left", "right")]
    assert len(set(addresses)) == 2 * TRIALS
    assert all(re.fullmatch(r"stimuli/[0-9a-f]{32}\.png", one) for one in addresses)
    assert [trial["part"] for trial in session["schedule"]] == ["main"] * 4 + ["closing"] * 2
    response = client.get("/" + addresses[0])
    assert response.headers["content-type"] == "image/png"
    assert "last-modified" not in response.headers
    assert client.get("/stimuli/" + "0" * 32 + ".png").status_code == 404
    for path in ("..%2fstudy.toml", "..", study.stimuli()[0].replace("/", "%2f")):
        assert client.get(f"/stimuli/{path}").status_code == 404


def test_a_second_answer_is_a_conflict(client: TestClient) -> None:
    """The same answer again is well; another is refused with 409 and changes nothing."""
    token = opened(client)["token"]
    states = [put(client, token, 0, response=one) for one in ("left", "left", "right", "left")]
    assert [one.status_code for one in states] == [200, 200, 409, 200]
    assert states[2].json()["state"] == "kept-first"


def test_sessions_are_each_others_secret(client: TestClient, sqlite_store: ResponseStore) -> None:
    """No token but one's own reads or writes a session, by any method."""
    mine = opened(client)
    other = opened(client, ids=IDS | {"PROLIFIC_PID": "other"})
    assert mine["token"] != other["token"]
    for wrong in (mine["subject"], mine["token"][:-1], "0", "%00", mine["token"].upper()):
        assert client.get(f"/api/sessions/{wrong}").status_code == 404
        assert put(client, wrong, 0).status_code == 404
        for method, last, body in (
            ("POST", "events", {"event": "blur"}),
            ("PUT", "questionnaire", {"answers": {"age": 31}}),
            ("POST", "completion", {}),
        ):
            response = client.request(method, f"/api/sessions/{wrong}/{last}", json=body)
            assert response.status_code == 404
    put(client, other["token"], 0)
    assert client.get(f"/api/sessions/{mine['token']}").json()["answered"] == []
    assert set(sqlite_store.read().trials["subject"]) == {other["subject"]}


@pytest.mark.parametrize(
    "changes",
    [
        {"response": "both"},
        {"response": None},
        {"reaction_ms": -1},
        {"reaction_ms": "850"},
        {"reaction_ms": 1e12},
        {"blur_events": 1.5},
        {"blur_events": True},
        {"display_width": 1e9},
        {"client_time": 5},
        {"client_time": "x" * 300},
        {"chose_target": 1},
        {"__proto__": {}},
    ],
)
def test_answers_of_another_form_are_refused(
    client: TestClient, sqlite_store: ResponseStore, changes: dict[str, Any]
) -> None:
    """A value of the wrong kind or size, or a field too many, is 422 and stores nothing."""
    response = put(client, opened(client)["token"], 0, **changes)
    assert response.status_code == 422
    assert next(iter(changes)) in response.json()["detail"]
    assert len(sqlite_store.read().trials) == 0


def test_an_answer_after_days_is_kept(client: TestClient) -> None:
    """A page that was left open over a long holiday still gives its answer."""
    month = 30 * 86_400_000.0
    response = put(client, opened(client)["token"], 0, shown_ms=900.0, reaction_ms=month)
    assert response.json()["state"] == "stored"


@pytest.mark.parametrize(
    "content",
    [b"", b"{", b"[]", b"null", b"\xff\xfe", b'{"response": NaN}', b'{"a":' * 5000],
)
def test_what_is_no_answer_at_all_is_refused(client: TestClient, content: bytes) -> None:
    """A body that is no JSON object is 422, told in one sentence."""
    token = opened(client)["token"]
    headers = {"content-type": "application/json"}
    path = f"/api/sessions/{token}/trials/0"
    response = client.put(path, content=content, headers=headers)
    assert response.status_code in {400, 422}
    assert isinstance(response.json()["detail"], str)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)


@pytest.fixture(scope="module")
def lasting(
    tmp_path_factory: pytest.TempPathFactory, study: Study
) -> Iterator[tuple[TestClient, str]]:
    """A client and a token that the examples of a property share."""
    store = ResponseStore(tmp_path_factory.mktemp("server") / "answers.sqlite")
    with TestClient(make_app(study, store, limits=UNLIMITED)) as client:
        yield client, opened(client)["token"]
    store.close()


@settings(max_examples=40)
@given(
    body=st.dictionaries(
        st.sampled_from(["event", "detail", "key", "ids", "mode", "answers", "x"]), JSON
    ),
    where=st.sampled_from(
        ["", "/{}/events", "/{}/questionnaire", "/{}/completion", "/{}/trials/0", "/{}/trials/x"]
    ),
    put_it=st.booleans(),
)
def test_no_body_breaks_the_server(
    lasting: tuple[TestClient, str], body: dict[str, Any], where: str, put_it: bool
) -> None:
    """Whatever JSON comes, the server answers with its own sentence, never with a fault."""
    client, token = lasting
    method = "PUT" if put_it else "POST"
    content = json.dumps(body).encode()
    headers = {"content-type": "application/json"}
    path = "/api/sessions" + where.format(token)
    response = client.request(method, path, content=content, headers=headers)
    assert response.status_code < 500
    response.json()


@pytest.mark.parametrize(
    "text", [SCRIPT, "'); DROP TABLE trials; --", "a\0b", "\ud800", "\U0001f600" * 400]
)
def test_texts_are_kept_as_texts(store: ResponseStore, study: Study, text: str) -> None:
    """Markup, SQL and odd characters in comments and events are kept as text, made whole."""
    with TestClient(make_app(study, store)) as client:
        token = opened(client)["token"]
        headers = {"content-type": "application/json"}
        body = json.dumps({"answers": {"age": 20, "comment": text}}).encode()
        path = f"/api/sessions/{token}"
        sent = client.put(f"{path}/questionnaire", content=body, headers=headers)
        noted = client.post(
            f"{path}/events",
            content=json.dumps({"event": "note", "detail": text, "key": text[:99]}).encode(),
            headers=headers,
        )
    assert (sent.status_code, noted.status_code) == (200, 200)
    data = store.read()
    kept = data.questionnaires.set_index("question")["answer"]["comment"]
    assert kept == data.events["detail"][0] == clean(text)
    assert len(data.subjects) == 1


@pytest.mark.parametrize(
    ("answers", "said"),
    [
        ({}, "'age' must be answered"),
        ({"age": "old"}, "must be a number"),
        ({"age": 17}, "at least 18"),
        ({"age": 500}, "at most 120"),
        ({"age": 31, "gender": "none"}, "one of male, female, other"),
        ({"age": 31, "comment": "x" * 501}, "at most 500 characters"),
        ({"age": 31, "weight": 80}, "Unknown question 'weight'"),
    ],
)
def test_questionnaires_are_held_to_the_questions(
    client: TestClient, answers: dict[str, Any], said: str
) -> None:
    """An answer that the study does not allow is 422 with a sentence."""
    path = f"/api/sessions/{opened(client)['token']}/questionnaire"
    response = client.put(path, json={"answers": answers})
    assert response.status_code == 422
    assert said in response.json()["detail"]


def test_a_tie_needs_the_studys_leave(sqlite_store: ResponseStore, study: Study) -> None:
    """Where no tie may be answered, none is taken."""
    strict = replace(study, settings=replace(study.settings, allow_tie=False))
    with TestClient(make_app(strict, sqlite_store)) as client:
        token = opened(client)["token"]
        assert put(client, token, 0, response="tie").status_code == 422
        assert put(client, token, 0).status_code == 200


def test_a_live_session_needs_the_panels_link(
    client: TestClient, sqlite_store: ResponseStore, study: Study
) -> None:
    """Without the ids that the study names no live session is opened; a pilot one is."""
    response = client.post("/api/sessions", json={"ids": {"PROLIFIC_PID": "5f3a"}})
    assert response.status_code == 400
    assert "lacks STUDY_ID, SESSION_ID" in response.json()["detail"]
    assert opened(client, ids={}, mode="pilot")["mode"] == "pilot"
    with TestClient(make_app(study, sqlite_store, require_ids=False)) as free:
        assert opened(free, ids={})["mode"] == "live"


def test_who_has_taken_part_is_told_so(client: TestClient) -> None:
    """A complete worker gets 409 by another link, and the code again by the same."""
    session = opened(client)
    path = f"/api/sessions/{session['token']}"
    for trial in range(TRIALS):
        put(client, session["token"], trial)
    client.put(f"{path}/questionnaire", json={"answers": {"age": 31}})
    code = client.post(f"{path}/completion").json()["code"]
    response = client.post("/api/sessions", json={"ids": IDS | {"STUDY_ID": "x"}})
    assert (response.status_code, "taken part" in response.json()["detail"]) == (409, True)
    again = opened(client)
    assert again["status"] == "complete"
    assert client.post(f"/api/sessions/{again['token']}/completion").json()["code"] == code


@pytest.mark.parametrize(
    ("served", "asked", "got"),
    [
        ("live", None, "live"),
        ("live", "pilot", "pilot"),
        ("live", "simulated", 403),
        ("pilot", None, "pilot"),
        ("pilot", "live", "pilot"),
        ("pilot", "simulated", 403),
        ("simulated", None, "simulated"),
        ("simulated", "simulated", "simulated"),
        ("simulated", "live", 403),
        ("simulated", "pilot", 403),
    ],
)
def test_no_session_counts_for_more_than_the_servers(
    sqlite_store: ResponseStore, study: Study, served: str, asked: str | None, got: str | int
) -> None:
    """A pilot server opens pilots only, and simulated sessions stay on servers of their own."""
    with TestClient(make_app(study, sqlite_store, mode=served)) as client:
        response = client.post("/api/sessions", json={"ids": IDS, "mode": asked})
    assert (response.json().get("mode") if response.status_code == 200 else 403) == got
    kept = sqlite_store.read(MODES).subjects["mode"].tolist()
    assert kept == ([got] if isinstance(got, str) else [])


def test_a_changed_study_does_not_go_on_with_old_sessions(
    client: TestClient, sqlite_store: ResponseStore, study: Study
) -> None:
    """After a change a session is not shown again, but what is under way is still kept."""
    token = opened(client)["token"]
    changed = replace(study, hash="6" * 64)
    with TestClient(make_app(changed, sqlite_store)) as later:
        assert later.get(f"/api/sessions/{token}").status_code == 409
        assert put(later, token, 0).json()["state"] == "stored"
        assert not opened(later)["resumed"]


def test_every_response_has_the_security_headers(client: TestClient) -> None:
    """Found or not, taken or refused: the policy allows no inline script and no other origin."""
    token = opened(client)["token"]
    for response in (
        client.get("/healthz"),
        client.get("/none"),
        client.get("/api/study"),
        put(client, token, 0),
        put(client, token, 99),
        client.post("/api/sessions", content=b"x" * 70_000),
    ):
        policy = response.headers["content-security-policy"]
        scripts = next(one for one in policy.split("; ") if one.startswith("script-src"))
        assert scripts == "script-src 'self'"
        assert "default-src 'none'" in policy
        assert response.headers["x-content-type-options"] == "nosniff"
        assert response.headers["referrer-policy"] == "no-referrer"
        assert "access-control-allow-origin" not in response.headers
    assert client.get("/api/study").headers["cache-control"] == "no-store"
    for path in ("/docs", "/redoc", "/openapi.json"):
        assert client.get(path).status_code == 404


def test_the_page_is_served_as_it_was_built(
    sqlite_store: ResponseStore, study: Study, tmp_path: Path
) -> None:
    """The index is at the root, its files under static, and nothing outside the folder."""
    page = tmp_path / "page"
    page.mkdir()
    (page / "index.html").write_text("<p>study</p>")
    (page / "study.js").write_text("1;")
    with TestClient(make_app(study, sqlite_store, page=page)) as client:
        assert client.get("/").text == "<p>study</p>"
        assert client.get("/static/study.js").text == "1;"
        for path in ("/static/../answers.sqlite", "/static/%2e%2e/answers.sqlite.key"):
            assert client.get(path).status_code == 404


def test_a_full_disk_loses_nothing(sqlite_store: ResponseStore, study: Study) -> None:
    """What a full database does not take is not acknowledged, and is taken when there is room."""
    pages = [1_000_000]

    def limit(connection: sqlite3.Connection, _record: object, _proxy: object) -> None:
        connection.execute(f"PRAGMA max_page_count={pages[0]}")

    event.listen(sqlite_store.database._engine, "checkout", limit)
    app = make_app(study, sqlite_store, limits=UNLIMITED, require_ids=False)
    with TestClient(app) as client:
        tokens = [opened(client, ids={})["token"] for _ in range(15)]
        pages[0] = 1  # SQLite takes it as the pages in use: not one more
        taken = {}
        posts = [(token, trial) for token in tokens for trial in range(TRIALS)]
        for token, trial in posts:
            taken[token, trial] = put(client, token, trial, client_time="x" * 200)
        statuses = Counter(response.status_code for response in taken.values())
        assert set(statuses) == {200, 503}
        refused = [which for which, response in taken.items() if response.status_code == 503]
        assert taken[refused[0]].headers["retry-after"] == "1"
        assert len(sqlite_store.read().trials) == statuses[200]
        pages[0] = 1_000_000
        for token, trial in posts:
            state = put(client, token, trial, client_time="x" * 200).json()["state"]
            assert state == ("stored" if (token, trial) in refused else "repeated")
    assert len(sqlite_store.read().trials) == len(posts)


def test_a_locked_database_is_waited_for_and_then_told(
    tmp_path: Path, study: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While another program holds the database, an answer is refused as temporary, not lost."""
    monkeypatch.setattr("studies.store_engine._SQLITE", ("PRAGMA busy_timeout=50",))
    path = tmp_path / "answers.sqlite"
    store = ResponseStore(path)
    with TestClient(make_app(study, store)) as client:
        token = opened(client)["token"]
        other = sqlite3.connect(path, isolation_level=None)
        other.execute("BEGIN IMMEDIATE")
        assert put(client, token, 0).status_code == 503
        other.execute("ROLLBACK")
        other.close()
        assert put(client, token, 0).json()["state"] == "stored"
    store.close()


@pytest.mark.parametrize("skew", ["1970-01-01T00:00:00Z", "2999-12-31T23:59:59Z", "yesterday"])
def test_the_subjects_clock_decides_nothing(
    client: TestClient, sqlite_store: ResponseStore, skew: str
) -> None:
    """An answer is dated by the server, whatever the subject's clock says."""
    session = opened(client)
    put(client, session["token"], 0, client_time=skew)
    answered = sqlite_store.read().trials["answered"][0]
    assert sqlite_store.read().subjects["started"][0] <= answered
    kept = sqlite_store.export_subject(session["subject"])["trials"][0]
    assert kept["client_time"] == skew


@pytest.mark.postgresql
def test_answers_go_on_after_a_restart_of_postgresql(
    study: Study, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """The database may crash and come back: what was acknowledged is there, and more is taken."""
    server = request.getfixturevalue("postgresql")
    store = ResponseStore(server.emptied_database(), key_file=tmp_path / "key")
    with TestClient(make_app(study, store)) as client:
        token = opened(client)["token"]
        assert put(client, token, 0).json()["state"] == "stored"
        server.restart()
        assert put(client, token, 0).json()["state"] == "repeated"
        assert put(client, token, 1).json()["state"] == "stored"
    assert store.read().trials["trial"].tolist() == [0, 1]
    store.close()


@pytest.mark.parametrize("make", [lambda s: s.close(), lambda s: s.database.close()])
def test_the_store_can_be_used_again_after_closing(
    sqlite_store: ResponseStore, study: Study, make: Callable[[ResponseStore], None]
) -> None:
    """Closing ends connections; the next use opens new ones."""
    make(sqlite_store)
    assert sqlite_store.open_session(study).status == "started"
