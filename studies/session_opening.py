"""How a session begins: the worker's own again, or a new one on the least filled schedule."""

from __future__ import annotations

import secrets
from collections import Counter
from collections.abc import Mapping
from datetime import datetime, timedelta
from typing import Any

from sqlalchemy import Connection, func, select

from studies.schedules import Schedule, least_filled
from studies.session_assignment import schedule_book
from studies.session_records import Display, RefusedError, Session, iso, schedule_to_text
from studies.store_schema import facts, recruits, sessions, subjects, tokens
from studies.store_statements import insert_new, session_of, set_status, token_digest
from studies.study_records import Study

ABANDONED = timedelta(hours=2)
"""A session that started longer ago and is not complete no longer counts in the balance."""
ASSIGNMENT = "assignment"
"""The row of `facts` that whoever assigns schedules holds."""


def open_or_resume(
    connection: Connection,
    study: Study,
    mode: str,
    hashes: Mapping[str, str],
    at: datetime,
    display: Display,
) -> Session:
    """Return the worker's session, or a new one on the least filled schedule.

    No other transaction opens a session until this one has ended, so that many who come at once
    are spread evenly, and a worker who comes twice at once gets one session.

    Parameters
    ----------
    connection : Connection
    study : Study
    mode : str
    hashes : mapping of str to str
        Keyed hashes of the worker's ids, by parameter.
    at : datetime
        The instant.
    display : Display

    Raises
    ------
    RefusedError
        If the worker has completed the study.
    """
    connection.execute(select(facts).where(facts.c.name == ASSIGNMENT).with_for_update())
    subject = _known_worker(connection, study, mode, hashes)
    if subject is not None:
        return session_of(connection, new_token(connection, subject), resumed=True)
    schedule = _assigned(connection, study, mode, at)
    subject = add_subject(connection, study.name, study.hash, mode, schedule, iso(at), display)
    recruited = [
        {"subject": subject, "parameter": parameter, "keyed_hash": keyed}
        for parameter, keyed in hashes.items()
    ]
    insert_new(connection, recruits, recruited)
    return session_of(connection, new_token(connection, subject), resumed=False)


def _known_worker(
    connection: Connection, study: Study, mode: str, hashes: Mapping[str, str]
) -> str | None:
    if next(iter(hashes), None) != next(iter(study.recruitment.id_parameters), ""):
        return None  # without the worker's own id nobody is recognised
    found = earlier_sessions(connection, study.name, mode, hashes)
    for subject, status, study_hash, same_link in found:
        # An id alone is no secret; together with the panel's own session it is.
        if same_link and len(hashes) > 1 and study_hash == study.hash and status != "returned":
            return subject
    if any(status == "complete" for _, status, _, _ in found) and mode == "live":
        raise RefusedError("you have already taken part in this study: thank you")
    for subject, status, _, _ in found:
        if status == "started":
            set_status(connection, subject, "returned", None)
    return None


def _assigned(connection: Connection, study: Study, mode: str, at: datetime) -> Schedule:
    complete = Counter(filled(connection, study.hash, mode, "complete"))
    since = iso(at - ABANDONED)
    started = filled(connection, study.hash, mode, "started", since)
    # Who is at it now will most likely finish: were only the complete counted, all who come
    # before the next one finishes would get the same task.
    return schedule_book(study)[least_filled(study, complete + Counter(started), started)]


def new_token(connection: Connection, subject: str) -> str:
    """Return a new token of the subject; its digest is kept, not the token.

    Parameters
    ----------
    connection : Connection
    subject : str
    """
    token = secrets.token_urlsafe(32)
    connection.execute(tokens.insert(), {"digest": token_digest(token), "subject": subject})
    return token


def filled(
    connection: Connection, study_hash: str, mode: str, status: str, since: str = ""
) -> dict[tuple[str, int], int]:
    """Return how many sessions of this status each task and order has.

    Parameters
    ----------
    connection : Connection
    study_hash, mode, status : str
        As in the table of subjects.
    since : str
        Only those that started then or later.
    """
    c = subjects.c
    counts = connection.execute(
        select(c.task, c.order, func.count())
        .where(c.study_hash == study_hash, c.mode == mode, c.status == status)
        .where(c.started >= since)
        .group_by(c.task, c.order)
    )
    return {(task, order): count for task, order, count in counts}


def add_subject(
    connection: Connection,
    study: str,
    study_hash: str,
    mode: str,
    schedule: Schedule,
    at: str,
    display: Display,
) -> str:
    """Add a subject with a schedule and return the subject's new name.

    Parameters
    ----------
    connection : Connection
    study, study_hash, mode : str
    schedule : Schedule
    at : str
        The instant.
    display : Display
    """
    subject = secrets.token_hex(8)
    row: dict[str, Any] = {
        "subject": subject,
        "study_hash": study_hash,
        "mode": mode,
        "status": "started",
    }
    row |= {"task": schedule.task, "order": schedule.order, "started": at}
    row |= {"display_width": display.width, "display_height": display.height}
    connection.execute(subjects.insert(), row | {"pixel_ratio": display.pixel_ratio})
    kept = {"subject": subject, "study": study, "schedule": schedule_to_text(schedule)}
    connection.execute(sessions.insert(), kept)
    return subject


def earlier_sessions(
    connection: Connection, study: str, mode: str, hashes: Mapping[str, str]
) -> list[tuple[str, str, str, bool]]:
    """Return the worker's sessions of a study: subject, status, hash, and whether all ids match.

    Parameters
    ----------
    connection : Connection
    study, mode : str
    hashes : mapping of str to str
        Keyed hashes by parameter; the first is the worker's own.
    """
    parameter, keyed = next(iter(hashes.items()))
    found = connection.execute(
        select(subjects.c.subject, subjects.c.status, subjects.c.study_hash)
        .join(recruits, recruits.c.subject == subjects.c.subject)
        .join(sessions, sessions.c.subject == subjects.c.subject)
        .where(recruits.c.parameter == parameter, recruits.c.keyed_hash == keyed)
        .where(sessions.c.study == study, subjects.c.mode == mode)
        .order_by(subjects.c.entry.desc())
    ).all()
    return [(*row, _hashes_of(connection, row.subject) == dict(hashes)) for row in found]


def _hashes_of(connection: Connection, subject: str) -> dict[str, str]:
    rows = connection.execute(
        select(recruits.c.parameter, recruits.c.keyed_hash).where(recruits.c.subject == subject)
    )
    return {row.parameter: row.keyed_hash for row in rows}
