"""A demographic export of Prolific, joined to the subjects of a store by participant.

The ids of the export are compared by the keyed hashes that the store keeps; they are not stored.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from sqlalchemy import update

from studies.foreign_rows import ForeignFile, open_foreign
from studies.response_store import ResponseStore
from studies.store_rows import records_of
from studies.store_schema import questionnaires, subjects
from studies.store_statements import insert_new

NAMES = {
    "participant": ("Participant id", "participant_id"),
    "submission": ("Submission id", "session_id", "submission_id"),
    "status": ("Status", "status"),
    "age": ("Age", "age"),
    "sex": ("Sex", "Gender", "sex", "gender"),
}
"""The columns of an export, by their names over the years."""
WITHHELD = frozenset({"CONSENT_REVOKED", "DATA_EXPIRED"})
"""What stands in a cell whose value may not or no longer be used."""
RETURNED = frozenset({"RETURNED", "TIMED-OUT"})
STATUSES = (
    *sorted(RETURNED),
    "APPROVED",
    "AWAITING REVIEW",
    "ACTIVE",
    "REJECTED",
    "PARTIALLY PAID",
    "SCREENED OUT",
    "RESERVED",
    "UNKNOWN",
)
ORIGIN = "prolific."
"""Before the names of the questions that the panel answers: ``prolific.age``."""


@dataclass(frozen=True)
class ProlificJoin:
    """What a join did.

    Parameters
    ----------
    rows : int
        Of the export.
    matched : int
        Rows whose participant is a subject of the store.
    filled : int
        Subjects whose gender or age was not known and now is.
    returned : int
        Sessions that now count as returned.
    answers : int
        Rows added to the questionnaires.
    """

    rows: int
    matched: int
    filled: int
    returned: int
    answers: int

    def sentence(self) -> str:
        """Return this in words."""
        return (
            f"{self.matched} of {self.rows} participants are subjects: gender or age of"
            f" {self.filled} filled in, {self.returned} sessions returned, {self.answers} answers"
            " added"
        )


def read_prolific(path: Path) -> pd.DataFrame:
    """Return the participants of a demographic export.

    Parameters
    ----------
    path : Path
        The CSV as it is downloaded.

    Returns
    -------
    DataFrame
        ``participant, submission, status, age, gender``, one row for each submission; missing
        where withheld or not in the export. Age in years.

    Raises
    ------
    RelightlabError
        If the file cannot be read, has no participants, or holds what it should not.
    """
    file = open_foreign(path)
    names = {key: _name_in(file, key) for key in NAMES}
    file.need([names["participant"]])
    rows = file.rows.where(~file.rows.isin(WITHHELD))
    open_file = ForeignFile(path, rows)
    status = rows[names["status"]] if names["status"] in rows else pd.Series("UNKNOWN", rows.index)
    unknown = status.notna() & ~status.isin(STATUSES)
    if unknown.any():
        raise open_file.fault(names["status"], unknown, f"one of {', '.join(STATUSES)}")
    return pd.DataFrame(
        {
            "participant": open_file.texts(names["participant"]),
            "submission": open_file.optional(names["submission"]),
            "status": status,
            "age": open_file.numbers(names["age"]),
            "gender": open_file.optional(names["sex"]).str.lower(),
        }
    )


def join_prolific(store: ResponseStore, path: Path) -> ProlificJoin:
    """Add what a demographic export says to the subjects of a store; a second time adds nothing.

    What a subject said in the study itself stands. The panel's own words are kept beside it, as
    answers to ``prolific.age`` and ``prolific.gender``. A submission that was returned or timed out
    makes its session ``returned``, whether it is complete or not.

    Parameters
    ----------
    store : ResponseStore
    path : Path

    Returns
    -------
    ProlificJoin

    Raises
    ------
    RelightlabError
        As `read_prolific`.
    """
    table = read_prolific(path)
    matched = filled = returned = answers = 0
    for row in records_of(table):
        known = sorted(store.subjects_of(row["participant"]))
        matched += bool(known)
        told = {name: row[name] for name in ("gender", "age")}
        for subject in known:
            filled += _fill(store, subject, told)
            answers += _answer(store, subject, told)
        if row["status"] in RETURNED and row["submission"]:
            sessions = store.subjects_of(row["submission"]) & set(known)
            returned += sum(_return(store, subject) for subject in sorted(sessions))
    return ProlificJoin(len(table), matched, filled, returned, answers)


def _name_in(file: ForeignFile, key: str) -> str:
    return next((name for name in NAMES[key] if name in file.rows), NAMES[key][0])


def _fill(store: ResponseStore, subject: str, values: Mapping[str, object]) -> bool:
    """Set the columns that are not known yet, and return whether there were any."""
    done = 0
    with store.database.writing() as connection:
        for name, value in values.items():
            column = subjects.c[name]
            lacking = update(subjects).where(subjects.c.subject == subject, column.is_(None))
            if value is not None:
                done += connection.execute(lacking.values({name: value})).rowcount
    return done > 0


def _answer(store: ResponseStore, subject: str, values: Mapping[str, object]) -> int:
    rows = [
        {"subject": subject, "question": f"{ORIGIN}{name}", "answer": _text(value)}
        for name, value in values.items()
        if value is not None
    ]
    with store.database.writing() as connection:
        return insert_new(connection, questionnaires, rows)


def _return(store: ResponseStore, subject: str) -> int:
    other = update(subjects).where(subjects.c.subject == subject, subjects.c.status != "returned")
    with store.database.writing() as connection:
        return int(connection.execute(other.values(status="returned")).rowcount)


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
