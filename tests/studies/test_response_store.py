"""The response store, on SQLite and PostgreSQL: each answer once, for good, and only one's own."""

from __future__ import annotations

import sqlite3
import tempfile
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shading_model.errors import RelightlabError
from studies.response_store import ResponseStore
from studies.session_opening import ABANDONED
from studies.session_records import (
    Display,
    RefusedError,
    Session,
    TrialAnswer,
    UnknownSessionError,
    UnknownTrialError,
)
from studies.study_records import Recruitment, Study
from studies.tables import MODES, TABLES, StudyData
from tests.studies.small_study import IDS, small_study

TRIALS = 6
LEFT = TrialAnswer("left", 900.5, 850.25, 1, 1280.0, 720.0, "2026-11-25T14:00:00Z")
RIGHT = replace(LEFT, response="right")
AGE = {"age": "31", "gender": "Female", "expertise": "Yes"}


def complete(store: ResponseStore, session: Session, answer: TrialAnswer = LEFT) -> str:
    """Do the rest of a session and return its code."""
    for trial in range(len(session.schedule.entries)):
        store.record(session.token, trial, answer)
    store.record_questionnaire(session.token, AGE)
    return store.finish(session.token, ["age"])


def test_answers_come_back_as_they_were_given(store: ResponseStore, study: Study) -> None:
    """What is read has the answer, the schedule's sides, the score and the place of each trial."""
    session = store.open_session(study, IDS, display=Display(1440.0, 900.0, 2.0))
    complete(store, session)
    data = store.read()
    (subject,) = data.subjects.to_dict("records")
    assert (subject["subject"], subject["status"], subject["mode"]) == (
        session.subject,
        "complete",
        "live",
    )
    assert (subject["gender"], subject["age"], subject["expertise"]) == ("female", 31.0, True)
    assert (subject["display_width"], subject["pixel_ratio"]) == (1440.0, 2.0)
    assert subject["started"] <= subject["finished"]
    assert data.trials["trial"].tolist() == list(range(TRIALS))
    for trial, entry in zip(data.trials.to_dict("records"), session.schedule.entries, strict=True):
        assert all(trial[name] == value for name, value in vars(entry).items())
        assert trial["chose_target"] == float(entry.target_side == "left")
        assert (trial["reaction_ms"], trial["blur_events"]) == (850.25, 1)
    for _, one in data.trials.groupby("kind"):
        assert sorted(one["position"]) == list(range(1, len(one) + 1))
    closing = data.trials[data.trials["kind"] == "closing"].set_index("pair")["chose_target"]
    assert subject["passed_spheres"] == (closing["spheres"] == 1.0)
    assert subject["passed_perspective"] == (closing["perspective"] == 1.0)


def test_the_first_answer_stands(store: ResponseStore, study: Study) -> None:
    """The same answer again is a repetition; another one becomes an event, once, and no answer."""
    token = store.open_session(study).token
    states = [store.record(token, 2, one).state for one in (LEFT, LEFT, RIGHT, RIGHT, LEFT)]
    assert states == ["stored", "repeated", "kept-first", "kept-first", "repeated"]
    data = store.read()
    assert data.trials["response"].tolist() == ["left"]
    assert data.events["event"].tolist() == ["second-answer"]
    assert '"response": "right"' in data.events["detail"][0]


@pytest.fixture(scope="module")
def lasting(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ResponseStore]:
    """A store that the examples of a property share."""
    store = ResponseStore(tmp_path_factory.mktemp("store") / "answers.sqlite")
    yield store
    store.close()


POSTS = st.lists(
    st.tuples(
        st.integers(0, TRIALS - 1),
        st.sampled_from(["left", "right", "tie"]),
        st.sampled_from([500.0, 501.5]),
    ),
    max_size=15,
)


@settings(max_examples=25)
@given(posts=POSTS)
def test_any_order_of_posts_keeps_every_first_answer(
    lasting: ResponseStore, study: Study, posts: list[tuple[int, str, float]]
) -> None:
    """However posts are repeated, reordered or contradicted, each trial has its first answer."""
    session = lasting.open_session(study)
    first: dict[int, tuple[str, float]] = {}
    for trial, response, reaction in posts:
        given = replace(LEFT, response=response, reaction_ms=reaction)
        state = lasting.record(session.token, trial, given).state
        if trial not in first:
            assert state == "stored"
        else:
            same = first[trial] == (response, reaction)
            assert state == ("repeated" if same else "kept-first")
        first.setdefault(trial, (response, reaction))
    rows = lasting.export_subject(session.subject)
    kept = {row["trial"]: (row["response"], row["reaction_ms"]) for row in rows["trials"]}
    assert kept == first
    assert lasting.session(session.token).answered == tuple(sorted(first))
    others = {(t, r, m) for t, r, m in posts if first[t] != (r, m)}
    assert len(rows["events"]) == len(others)


def test_simultaneous_posts_of_one_trial_store_one(store: ResponseStore, study: Study) -> None:
    """Of many different answers that arrive at once, exactly one is stored."""
    token = store.open_session(study).token
    answers = [replace(LEFT, reaction_ms=500.0 + number) for number in range(12)]
    with ThreadPoolExecutor(6) as pool:
        states = list(pool.map(lambda one: store.record(token, 0, one).state, answers))
    assert Counter(states) == {"stored": 1, "kept-first": 11}
    data = store.read()
    assert len(data.trials) == 1
    stored = answers[states.index("stored")]
    assert data.trials["reaction_ms"][0] == stored.reaction_ms


def test_simultaneous_openings_stay_balanced(store: ResponseStore, study: Study) -> None:
    """Who comes at once is spread over tasks and orders: no two differ by more than one."""
    with ThreadPoolExecutor(8) as pool:
        sessions = list(pool.map(lambda _: store.open_session(study), range(30)))
    assert len({session.subject for session in sessions}) == 30
    filled = Counter((one.schedule.task, one.schedule.order) for one in sessions)
    assert len(filled) == 12
    assert set(filled.values()) <= {2, 3}


def test_only_complete_and_recent_sessions_of_the_mode_count(tmp_path: Path, study: Study) -> None:
    """Pilots, given-up and abandoned sessions leave the balance as it was."""
    hour = [datetime(2026, 11, 25, 12, tzinfo=UTC)]
    store = ResponseStore(tmp_path / "answers.sqlite", clock=lambda: hour[0])
    first = store.open_session(study, mode="live")
    place = (first.schedule.task, first.schedule.order)
    pilot = store.open_session(study, mode="pilot")
    assert (pilot.schedule.task, pilot.schedule.order) == place
    complete(store, pilot)
    store.record_event(first.token, "declined")
    second = store.open_session(study)
    assert (second.schedule.task, second.schedule.order) == place
    hour[0] += ABANDONED + timedelta(seconds=1)
    third = store.open_session(study)
    assert (third.schedule.task, third.schedule.order) == place
    complete(store, third)
    fourth = store.open_session(study)
    assert fourth.schedule.task != place[0]
    store.close()


def test_a_clock_that_jumps_back_harms_nothing(tmp_path: Path, study: Study) -> None:
    """Sessions and answers go on when the server's clock is set back."""
    instants = iter(datetime(2026, 11, 25, 12, tzinfo=UTC) - timedelta(days=n) for n in range(99))
    store = ResponseStore(tmp_path / "answers.sqlite", clock=lambda: next(instants))
    sessions = [store.open_session(study) for _ in range(12)]
    assert len({(one.schedule.task, one.schedule.order) for one in sessions}) == 12
    assert complete(store, sessions[0])
    assert len(store.read().trials) == TRIALS
    store.close()


def test_a_session_is_resumed_by_its_token(store: ResponseStore, study: Study) -> None:
    """The token gives the schedule, the answered trials and the answered questions again."""
    opened = store.open_session(study)
    store.record(opened.token, 3, LEFT)
    store.record_questionnaire(opened.token, {"age": "20"})
    again = store.session(opened.token)
    assert again == replace(opened, answered=(3,), questionnaire=("age",), resumed=True)


def test_a_worker_is_resumed_by_the_same_link(store: ResponseStore, study: Study) -> None:
    """On another device the same link opens the same session; both tokens go on."""
    opened = store.open_session(study, IDS)
    store.record(opened.token, 0, LEFT)
    again = store.open_session(study, dict(reversed(IDS.items())) | {"utm": "x"})
    assert (again.subject, again.resumed, again.answered) == (opened.subject, True, (0,))
    assert again.token != opened.token
    store.record(opened.token, 1, LEFT)
    assert complete(store, again) == store.finish(opened.token)
    assert store.open_session(study, IDS).status == "complete"
    assert len(store.read().subjects) == 1


def test_another_link_of_a_worker_does_not_open_the_session(
    store: ResponseStore, study: Study
) -> None:
    """With the worker's id alone nobody reads or goes on with the worker's session."""
    opened = store.open_session(study, IDS)
    other = store.open_session(study, IDS | {"SESSION_ID": "guess"})
    assert other.subject != opened.subject
    statuses = store.read().subjects.set_index("subject")["status"]
    assert statuses.to_dict() == {opened.subject: "returned", other.subject: "started"}
    store.record(opened.token, 0, LEFT)  # what is under way is kept all the same
    with pytest.raises(RefusedError, match="was ended"):
        store.finish(opened.token)
    assert store.session(other.token).answered == ()


def test_nobody_takes_part_twice(store: ResponseStore, study: Study) -> None:
    """A worker with a complete session is refused by any other link, in live mode alone."""
    complete(store, store.open_session(study, IDS))
    with pytest.raises(RefusedError, match="already taken part"):
        store.open_session(study, IDS | {"SESSION_ID": "other"})
    assert not store.open_session(study, IDS | {"PROLIFIC_PID": "another"}).resumed
    pilots = [store.open_session(study, IDS | {"STUDY_ID": str(n)}, "pilot") for n in range(2)]
    assert not any(one.resumed for one in pilots)


def test_a_lone_id_is_no_secret(store: ResponseStore, study: Study) -> None:
    """Where the panel gives one id, knowing it does not open a session that is there."""
    lone = replace(study, recruitment=Recruitment("", ("worker",)))
    first = store.open_session(lone, {"worker": "A1"})
    second = store.open_session(lone, {"worker": "A1"})
    assert (second.resumed, second.subject == first.subject) == (False, False)


def test_tokens_and_trials_must_exist(store: ResponseStore, study: Study) -> None:
    """A token nobody has, or a trial the schedule lacks, stores nothing."""
    token = store.open_session(study).token
    for wrong in ("", token[:-1], token + "A", token.swapcase(), "' OR '1'='1", "\ud800"):
        with pytest.raises(UnknownSessionError, match="no session has this token"):
            store.record(wrong, 0, LEFT)
        with pytest.raises(UnknownSessionError, match="no session has this token"):
            store.session(wrong)
    for trial in (-1, TRIALS):
        with pytest.raises(UnknownTrialError, match=f"from 0 to {TRIALS - 1}"):
            store.record(token, trial, LEFT)
    assert len(store.read().trials) == 0


def test_completion_needs_every_answer(store: ResponseStore, study: Study) -> None:
    """The code is given when all trials and required questions are there, and stays the same."""
    session = store.open_session(study)
    for trial in (0, 1, 3, 4, 5):
        store.record(session.token, trial, LEFT)
    with pytest.raises(RefusedError) as refused:
        store.finish(session.token, ["age", "gender"])
    assert (refused.value.missing, refused.value.questions) == ((2,), ("age", "gender"))
    code = complete(store, session)
    assert store.finish(session.token, ["age"]) == code
    assert store.record(session.token, 0, RIGHT).state == "kept-first"
    with pytest.raises(RefusedError, match="stands as it was"):
        store.record_questionnaire(session.token, {"age": "99"})
    assert not store.record_questionnaire(session.token, AGE)
    assert store.finish(session.token) == code


def test_a_questionnaire_can_be_corrected_until_completion(
    store: ResponseStore, study: Study
) -> None:
    """Answers sent later replace those sent before, with what they say about the subject."""
    token = store.open_session(study).token
    assert store.record_questionnaire(token, {"age": "20", "comment": "x"})
    assert store.record_questionnaire(token, {"age": "30"})
    assert not store.record_questionnaire(token, {"age": "30"})
    data = store.read()
    assert data.questionnaires[["question", "answer"]].to_numpy().tolist() == [["age", "30"]]
    assert data.subjects["age"].tolist() == [30.0]


def test_events_are_kept_once_per_key_and_not_without_end(
    store: ResponseStore, study: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same key is the same event, no key is always a new one, and there is a most."""
    monkeypatch.setattr("studies.store_statements.MOST_EVENTS", 4)
    token = store.open_session(study).token
    sent = [
        ("blur", "k1"),
        ("blur", "k1"),
        ("blur", None),
        ("blur", None),
        ("x", "k2"),
        ("y", "k3"),
    ]
    kept = [store.record_event(token, event, "detail", key) for event, key in sent]
    assert kept == [True, False, True, True, True, False]
    assert store.read().events["event"].tolist() == ["blur", "blur", "blur", "x"]


def test_sessions_do_not_touch_each_other(store: ResponseStore, study: Study) -> None:
    """What one subject sends changes no row of another."""
    first, second = store.open_session(study), store.open_session(study)
    complete(store, first)
    before = store.export_subject(first.subject)
    complete(store, second, RIGHT)
    assert store.export_subject(first.subject) == before
    assert set(store.read().trials["response"]) == {"left", "right"}


def test_pilots_are_read_only_on_request(store: ResponseStore, study: Study) -> None:
    """Pilot answers stay out of what is read, unless their mode is named."""
    store.record(store.open_session(study, mode="pilot").token, 0, LEFT)
    assert len(store.read().subjects) == len(store.read().trials) == 0
    assert store.read(["pilot"]).marks == ("pilot",)


def test_writing_twice_changes_nothing(store: ResponseStore, study: Study) -> None:
    """Tables that were written come back the same, and writing them again adds no row."""
    complete(store, store.open_session(study))
    data = store.read()
    assert set(store.write(data).values()) == {0}
    foreign = StudyData(
        data.subjects.assign(subject="s1", mode="simulated", age=[float("nan")]),
        data.trials.assign(subject="s1"),
        data.questionnaires.assign(subject="s1"),
        pd.DataFrame({"subject": "s1", "event": ["blur", "blur"], "at": "2026-11-25T14:00:00Z"}),
    )
    assert store.write(foreign) == {
        "subjects": 1,
        "trials": TRIALS,
        "questionnaires": 3,
        "events": 2,
    }
    assert set(store.write(foreign).values()) == {0}
    back = store.read().of_subjects(["s1"])
    for name in TABLES:
        pd.testing.assert_frame_equal(back.table(name), foreign.table(name))


def test_one_subject_is_given_out_and_deleted(store: ResponseStore, study: Study) -> None:
    """All that is kept of a subject comes out, goes away, and leaves the others as they were."""
    session, other = store.open_session(study, IDS), store.open_session(study)
    complete(store, session)
    store.record_event(session.token, "blur")
    kept = store.export_subject(session.subject)
    assert {name: len(rows) for name, rows in kept.items()} == {
        "subjects": 1,
        "trials": TRIALS,
        "questionnaires": 3,
        "events": 1,
        "sessions": 1,
        "recruits": 3,
    }
    assert store.subjects_of(IDS["PROLIFIC_PID"]) == {session.subject}
    assert store.delete_subject(session.subject) == 1 + TRIALS + 3 + 1 + 1 + 3 + 1
    assert store.read().subjects["subject"].tolist() == [other.subject]
    assert store.subjects_of(IDS["PROLIFIC_PID"]) == frozenset()
    with pytest.raises(UnknownSessionError):
        store.session(session.token)
    for action in (store.export_subject, store.delete_subject):
        with pytest.raises(RelightlabError, match="no subject"):
            action(session.subject)


def test_the_file_holds_no_id_no_token_and_nothing_deleted(
    sqlite_store: ResponseStore, study: Study, tmp_path: Path
) -> None:
    """The bytes on disk have neither a worker's ids nor tokens, nor a deleted subject's words."""
    ids = {name: f"recognisable-{name}" for name in IDS}
    session = sqlite_store.open_session(study, ids)
    sqlite_store.record_questionnaire(session.token, {"comment": "a remarkable sentence"})

    def on_disk() -> bytes:
        return b"".join(path.read_bytes() for path in sorted(tmp_path.glob("answers.sqlite*")))

    assert b"a remarkable sentence" in on_disk()
    assert session.token.encode() not in on_disk()
    assert b"recognisable-" not in on_disk()
    sqlite_store.delete_subject(session.subject)
    assert b"a remarkable sentence" not in on_disk()
    assert session.subject.encode() not in on_disk()


def test_the_key_belongs_to_the_database(tmp_path: Path) -> None:
    """A database is not opened with another key, nor without the one it was made with."""
    path = tmp_path / "answers.sqlite"
    ResponseStore(path).close()
    key = tmp_path / "answers.sqlite.key"
    assert key.stat().st_mode & 0o777 == 0o600
    ResponseStore(path).close()
    text = key.read_text()
    key.unlink()
    with pytest.raises(RelightlabError, match="expected the key of the database"):
        ResponseStore(path)
    key.write_text("0" * 64)
    with pytest.raises(RelightlabError, match="is not the key of the database"):
        ResponseStore(path)
    (tmp_path / "elsewhere.key").write_text(text)
    ResponseStore(path, key_file=tmp_path / "elsewhere.key").close()


def test_another_version_is_refused(tmp_path: Path) -> None:
    """A database of another version of the schema is left alone."""
    path = tmp_path / "answers.sqlite"
    ResponseStore(path).close()
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE facts SET value = '0' WHERE name = 'version'")
    connection.close()
    with pytest.raises(RelightlabError, match="is of version 0, this program's is 1"):
        ResponseStore(path)


def test_what_is_no_database_is_told(tmp_path: Path) -> None:
    """A file that is no database, or none at all where one must be, is told in a sentence."""
    (tmp_path / "text").write_text("no database" * 100)
    with pytest.raises(RelightlabError, match="cannot be opened: file is not a database"):
        ResponseStore(tmp_path / "text")
    with pytest.raises(RelightlabError, match="there is no database"):
        ResponseStore(tmp_path / "none", must_exist=True)
    with pytest.raises(RelightlabError, match="cannot be opened"):
        ResponseStore("postgresql://lab@/none?host=/nowhere", key_file=tmp_path / "key")


def test_many_stores_open_a_new_database_at_once(address: str, tmp_path: Path) -> None:
    """Processes that start together agree on the tables and on one key."""

    def opened(_: int) -> str:
        store = ResponseStore(address, key_file=tmp_path / "answers.key")
        store.close()
        return store.key.fingerprint

    with ThreadPoolExecutor(4) as pool:
        assert len(set(pool.map(opened, range(8)))) == 1


def test_modes_are_those_of_the_tables() -> None:
    """Every mode but the pilot's is read by default."""
    from studies.response_store import COUNTED

    assert set(COUNTED) == set(MODES) - {"pilot"}


def test_schedules_outlive_a_change_of_the_study(sqlite_store: ResponseStore) -> None:
    """A session keeps its schedule, so that its answers fit it whatever becomes of the study."""
    with tempfile.TemporaryDirectory() as folder:
        session = sqlite_store.open_session(small_study(Path(folder), pairs=4))
    sqlite_store.record(session.token, 0, LEFT)
    assert sqlite_store.session(session.token).schedule == session.schedule
    assert len(session.schedule.entries) == 4 + 1 + 2
