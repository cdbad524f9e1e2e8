"""Whole tables into a response store and out of it, and all that is kept of one subject."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import pandas as pd
from sqlalchemy import Connection, Select, delete, select

from studies.store_schema import OF_A_SUBJECT, TIDY, subjects
from studies.store_statements import insert_new
from studies.tables import TABLES, StudyData

_WITHIN_SUBJECT = {"trials": "trial", "questionnaires": "question", "events": "entry"}


def read_tables(connection: Connection, modes: Collection[str]) -> StudyData:
    """Return the tidy tables of all subjects of these modes, in the order they came.

    Parameters
    ----------
    connection : Connection
    modes : collection of str
    """
    return StudyData(**{name: _frame(connection, name, modes) for name in TABLES})


def _frame(connection: Connection, name: str, modes: Collection[str]) -> pd.DataFrame:
    table = TIDY[name]
    names = [column.name for column in TABLES[name]]
    wanted: Select[Any] = select(*(table.c[column] for column in names))
    if table is not subjects:
        wanted = wanted.join(subjects, subjects.c.subject == table.c.subject)
    wanted = wanted.where(subjects.c.mode.in_(modes)).order_by(subjects.c.entry)
    if name in _WITHIN_SUBJECT:
        wanted = wanted.order_by(table.c[_WITHIN_SUBJECT[name]])
    rows = [tuple(row) for row in connection.execute(wanted)]
    return pd.DataFrame(rows, columns=names, dtype=object)


def write_tables(connection: Connection, data: StudyData) -> dict[str, int]:
    """Add the rows that break no key and return how many those were, by table.

    Parameters
    ----------
    connection : Connection
    data : StudyData
    """
    there = set(connection.scalars(select(subjects.c.subject)))
    added = {}
    for name in TABLES:
        table = data.table(name)
        if name == "events":  # they have no key, so they come with their subject or not at all
            table = table[~table["subject"].isin(there)]
        added[name] = insert_new(connection, TIDY[name], records_of(table))
    return added


def records_of(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the rows of a table with None where a value is missing.

    Parameters
    ----------
    table : DataFrame

    Examples
    --------
    >>> records_of(pd.DataFrame({"subject": ["s1"], "age": [float("nan")]}))
    [{'subject': 's1', 'age': None}]
    """
    plain = table.astype(object).where(table.notna(), None)
    return [{str(name): value for name, value in row.items()} for row in plain.to_dict("records")]


def rows_of_subject(connection: Connection, subject: str) -> dict[str, list[dict[str, Any]]]:
    """Return every row that is kept of a subject, by table; tokens are left out.

    Parameters
    ----------
    connection : Connection
    subject : str
    """
    return {
        table.name: [
            dict(row)
            for row in connection.execute(
                select(table).where(table.c.subject == subject)
            ).mappings()
        ]
        for table in reversed(OF_A_SUBJECT)
        if table.name != "tokens"
    }


def delete_rows_of_subject(connection: Connection, subject: str) -> int:
    """Delete every row that is kept of a subject and return how many those were.

    Parameters
    ----------
    connection : Connection
    subject : str
    """
    return sum(
        connection.execute(delete(table).where(table.c.subject == subject)).rowcount
        for table in OF_A_SUBJECT
    )
