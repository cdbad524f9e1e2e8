"""The tables of a response store: the tidy tables, and what is kept beside them.

The four tidy tables have the columns of `studies.tables`. Beside them lie the sessions with the
schedule each was given, the digests of their tokens, and, in a table of their own, the keyed
hashes of the ids that a panel gave its workers. No table holds an id, a token or an address.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sqlalchemy import (
    Boolean,
    Column,
    Double,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    Table,
    Text,
    UniqueConstraint,
)
from sqlalchemy.types import TypeEngine

from studies import tables
from studies.table_columns import Column as TidyColumn

VERSION = "1"
"""Of this schema; kept in the database and checked when it is opened."""

_TYPES: dict[str, type[TypeEngine[Any]]] = {
    "text": Text,
    "time": Text,
    "number": Double,
    "flag": Boolean,
    "whole": Integer,
}

metadata = MetaData()


def _tidy(columns: Sequence[TidyColumn], *keys: str) -> list[Column[Any]]:
    return [
        Column(
            column.name,
            _TYPES[column.kind](),
            *([_of_subject()] if column.name == "subject" and keys else []),
            nullable=column.missing,
            primary_key=column.name in keys,
        )
        for column in columns
    ]


def _of_subject() -> ForeignKey:
    return ForeignKey("subjects.subject", ondelete="CASCADE")


def _counter() -> Column[int]:
    return Column("entry", Integer, primary_key=True, autoincrement=True)


subjects = Table(
    "subjects",
    metadata,
    _counter(),
    *_tidy(tables.SUBJECTS),
    UniqueConstraint("subject"),
    Index("subjects_by_schedule", "study_hash", "mode", "task", "order"),
)
"""One row for each subject, in the order they came."""

trials = Table(
    "trials",
    metadata,
    *_tidy(tables.TRIALS, "subject", "trial"),
    Column("client_time", Text),
)
"""One row for each answered trial; `client_time` is what the subject's own clock said."""

questionnaires = Table(
    "questionnaires", metadata, *_tidy(tables.QUESTIONNAIRES, "subject", "question")
)
"""One row for each answered question."""

events = Table(
    "events",
    metadata,
    _counter(),
    *_tidy(tables.EVENTS),
    Column("key", Text),
    UniqueConstraint("subject", "key"),
)
"""What happened; an event sent again under the same `key` is the same event."""

sessions = Table(
    "sessions",
    metadata,
    Column("subject", Text, _of_subject(), primary_key=True),
    Column("study", Text, nullable=False),
    Column("schedule", Text, nullable=False),
)
"""The study's name and, as JSON, the schedule that a subject was given."""

tokens = Table(
    "tokens",
    metadata,
    Column("digest", Text, primary_key=True),
    Column("subject", Text, _of_subject(), nullable=False, index=True),
)
"""SHA-256 of every token that opens a session."""

recruits = Table(
    "recruits",
    metadata,
    Column("subject", Text, _of_subject(), primary_key=True),
    Column("parameter", Text, primary_key=True),
    Column("keyed_hash", Text, nullable=False, index=True),
)
"""Keyed hashes of a panel's ids; the key is not in the database."""

facts = Table(
    "facts",
    metadata,
    Column("name", Text, primary_key=True),
    Column("value", Text, nullable=False),
)
"""Version of the schema and fingerprint of the key; its rows also serve as locks."""

TIDY: dict[str, Table] = {
    "subjects": subjects,
    "trials": trials,
    "questionnaires": questionnaires,
    "events": events,
}
"""The tables behind `studies.tables.StudyData`."""

OF_A_SUBJECT = (recruits, tokens, sessions, events, questionnaires, trials, subjects)
"""Every table with rows of a subject, in the order in which they can be deleted."""
