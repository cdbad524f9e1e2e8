"""What a response store does inside one transaction: each function gets its connection."""

from __future__ import annotations

import hashlib
import hmac
import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, Row, Table, func, select, update
from sqlalchemy.dialects import postgresql, sqlite

from studies.schedules import Schedule, ScheduledTrial
from studies.session_records import (
    Acknowledgement,
    Session,
    TrialAnswer,
    UnknownSessionError,
    UnknownTrialError,
    schedule_from_text,
)
from studies.store_schema import (
    events,
    questionnaires,
    sessions,
    subjects,
    tokens,
    trials,
)
from studies.study_pairs import CLOSING_TESTS

MOST_EVENTS = 2000
"""Events kept of one subject; more are dropped."""

_SAME = ("response", "shown_ms", "reaction_ms", "blur_events")


def insert_new(connection: Connection, table: Table, rows: Sequence[Mapping[str, Any]]) -> int:
    """Insert the rows that break no key and return how many those were.

    Parameters
    ----------
    connection : Connection
    table : Table
    rows : sequence of mapping
        All with the same columns.
    """
    if not rows:
        return 0
    dialect = postgresql if connection.dialect.name == "postgresql" else sqlite
    statement = dialect.insert(table).on_conflict_do_nothing()
    counted = statement.execution_options(preserve_rowcount=True)
    return int(connection.execute(counted, [dict(row) for row in rows]).rowcount)


def token_digest(token: str) -> str:
    """Return what is kept of a token.

    Parameters
    ----------
    token : str

    Examples
    --------
    >>> len(token_digest("x")), token_digest("x") == token_digest("y")
    (64, False)
    """
    return hashlib.sha256(token.encode("utf-8", "replace")).hexdigest()


def subject_of(connection: Connection, token: str) -> Row[Any]:
    """Return the subject, its row locked until the transaction ends, with its schedule.

    Parameters
    ----------
    connection : Connection
    token : str

    Raises
    ------
    UnknownSessionError
        If no session has the token.
    """
    digest = token_digest(token)
    row = connection.execute(
        select(tokens.c.digest, sessions.c.schedule, subjects)
        .join(subjects, subjects.c.subject == tokens.c.subject)
        .join(sessions, sessions.c.subject == tokens.c.subject)
        .where(tokens.c.digest == digest)
        .with_for_update(of=subjects)
    ).one_or_none()
    if row is None or not hmac.compare_digest(row.digest, digest):
        raise UnknownSessionError("no session has this token: open the study's link again")
    return row


def session_of(connection: Connection, token: str, *, resumed: bool) -> Session:
    """Return the session as it stands.

    Parameters
    ----------
    connection : Connection
    token : str
    resumed : bool
        Whether it was there before.
    """
    row = subject_of(connection, token)
    answered = connection.scalars(select(trials.c.trial).where(trials.c.subject == row.subject))
    questions = connection.scalars(
        select(questionnaires.c.question).where(questionnaires.c.subject == row.subject)
    )
    return Session(
        token,
        row.subject,
        row.study_hash,
        row.mode,
        row.status,
        schedule_from_text(row.schedule),
        tuple(sorted(answered)),
        tuple(sorted(questions)),
        resumed,
    )


def record_answer(
    connection: Connection, token: str, trial: int, answer: TrialAnswer, at: str
) -> Acknowledgement:
    """Keep an answer unless the trial has one; another second answer becomes an event.

    Parameters
    ----------
    connection : Connection
    token : str
    trial : int
        Place in the subject's schedule.
    answer : TrialAnswer
    at : str
        The instant.

    Raises
    ------
    UnknownTrialError
        If the schedule has no such trial.
    """
    subject = subject_of(connection, token)
    entries = schedule_from_text(subject.schedule).entries
    if not 0 <= trial < len(entries):
        raise UnknownTrialError(f"expected a trial from 0 to {len(entries) - 1}, got {trial}")
    row = _trial_row(subject.subject, subject.task, entries, trial, answer) | {"answered": at}
    if insert_new(connection, trials, [row]):
        _note_on_subject(connection, subject, entries[trial], row)
        return Acknowledgement(trial, "stored")
    first = (
        connection.execute(
            select(trials).where(trials.c.subject == subject.subject, trials.c.trial == trial)
        )
        .mappings()
        .one()
    )
    if all(first[name] == row[name] for name in _SAME):
        return Acknowledgement(trial, "repeated")
    detail = json.dumps({"trial": trial} | {name: row[name] for name in _SAME}, sort_keys=True)
    add_event(connection, subject.subject, "second-answer", detail, at, detail)
    return Acknowledgement(trial, "kept-first")


def _trial_row(
    subject: str, task: str, entries: Sequence[ScheduledTrial], trial: int, answer: TrialAnswer
) -> dict[str, Any]:
    entry = entries[trial]
    tie = answer.response == "tie"
    row = {"subject": subject, "task": task, "trial": trial} | vars(entry) | vars(answer)
    return row | {
        "position": sum(one.kind == entry.kind for one in entries[: trial + 1]),
        "chose_target": 0.5 if tie else float(answer.response == entry.target_side),
    }


def _note_on_subject(
    connection: Connection, subject: Row[Any], entry: ScheduledTrial, row: Mapping[str, Any]
) -> None:
    values: dict[str, Any] = {}
    if entry.kind == "closing" and entry.pair in CLOSING_TESTS:
        values[f"passed_{entry.pair}"] = row["chose_target"] == 1.0
    if subject.display_width is None:
        values |= {name: row[name] for name in ("display_width", "display_height")}
    if values:
        this = subjects.c.subject == subject.subject
        connection.execute(update(subjects).where(this).values(values))


def add_event(
    connection: Connection, subject: str, event: str, detail: str | None, at: str, key: str | None
) -> bool:
    """Keep an event once per key, and return whether it was new and there was room.

    Parameters
    ----------
    connection : Connection
    subject, event : str
    detail : str or None
    at : str
        The instant.
    key : str or None
        What makes a repetition recognisable.
    """
    many = select(func.count()).select_from(events).where(events.c.subject == subject)
    if connection.scalars(many).one() >= MOST_EVENTS:
        return False
    row = {"subject": subject, "event": event, "detail": detail, "at": at, "key": key}
    return insert_new(connection, events, [row]) == 1


def set_status(connection: Connection, subject: str, status: str, finished: str | None) -> None:
    """Set how far a session went.

    Parameters
    ----------
    connection : Connection
    subject, status : str
    finished : str or None
        The instant of completion.
    """
    this = subjects.c.subject == subject
    values = {"status": status, "finished": finished}
    connection.execute(update(subjects).where(this).values(values))


def missing_trials(schedule: Schedule, answered: Iterable[int]) -> list[int]:
    """Return the trials of a schedule that have no answer yet.

    Parameters
    ----------
    schedule : Schedule
    answered : iterable of int

    Examples
    --------
    >>> missing_trials(Schedule("real", 0, ()), [])
    []
    """
    return sorted(set(range(len(schedule.entries))) - set(answered))
