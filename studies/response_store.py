"""The answers of a study, in a database: nothing is acknowledged before it is on disk."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, delete, select, update
from sqlalchemy.exc import DBAPIError

from shading_model.errors import RelightlabError
from studies import store_rows as rows
from studies import store_statements as statements
from studies.completion_codes import completion_code
from studies.questionnaire_answers import subject_columns
from studies.secret_key import SecretKey, read_or_make_key
from studies.session_opening import ASSIGNMENT, open_or_resume
from studies.session_records import (
    Acknowledgement,
    Display,
    RefusedError,
    Session,
    TrialAnswer,
    iso,
    now,
)
from studies.store_engine import Database
from studies.store_schema import (
    VERSION,
    facts,
    metadata,
    questionnaires,
    recruits,
    subjects,
    trials,
)
from studies.study_records import Study
from studies.tables import MODES, StudyData

COUNTED = tuple(mode for mode in MODES if mode != "pilot")
"""The modes that are read by default."""


class ResponseStore:
    """The answers to one study or several, safe for many subjects at once.

    Parameters
    ----------
    address : str or Path
        ``sqlite:///FILE``, ``postgresql://USER@HOST/NAME`` or the path of a SQLite file; its
        tables are made where there are none.
    key_file : Path, optional
        The secret key; by default beside a SQLite file, else in the user's own folder. Made with
        a new database, and needed with an old one.
    clock : callable, optional
        Tells the instant; the only clock that is relied on.
    must_exist : bool
        Whether a SQLite file that is not there is a fault, rather than made.

    Raises
    ------
    RelightlabError
        If the database cannot be opened, is of another version, or has another key.

    Examples
    --------
    >>> import tempfile
    >>> store = ResponseStore(Path(tempfile.mkdtemp()) / "answers.sqlite")
    >>> len(store.read().trials)
    0
    >>> store.close()
    """

    def __init__(
        self,
        address: str | Path,
        *,
        key_file: Path | None = None,
        clock: Callable[[], datetime] = now,
        must_exist: bool = False,
    ) -> None:
        self.database = Database(address, must_exist=must_exist)
        self.clock = clock
        try:
            self.key = self._open(key_file or self.database.key_path())
        except DBAPIError as error:
            reason = str(error.orig).strip().splitlines()[0]
            raise RelightlabError(
                f"the database {self.database.url} cannot be opened: {reason}"
            ) from error

    def _open(self, key_file: Path) -> SecretKey:
        with self.database.writing() as connection:
            self.database.hold_everything(connection)
            metadata.create_all(connection)
            kept = dict(connection.execute(select(facts.c.name, facts.c.value)).all())
            if kept.get("version", VERSION) != VERSION:
                raise RelightlabError(
                    f"the database {self.database.url} is of version {kept['version']}, this"
                    f" program's is {VERSION}: export the answers with the program that made it"
                )
            key = read_or_make_key(key_file, may_make="key" not in kept)
            if kept.get("key", key.fingerprint) != key.fingerprint:
                raise RelightlabError(
                    f"{key_file} is not the key of the database {self.database.url}: name the"
                    " right one with --key"
                )
            own = {"version": VERSION, "key": key.fingerprint, ASSIGNMENT: ""}
            missing = [{"name": n, "value": v} for n, v in own.items() if n not in kept]
            statements.insert_new(connection, facts, missing)
        return key

    def close(self) -> None:
        """Close every connection to the database."""
        self.database.close()

    def open_session(
        self,
        study: Study,
        ids: Mapping[str, str] | None = None,
        mode: str = "live",
        display: Display | None = None,
    ) -> Session:
        """Open a session on the least filled schedule, or the worker's own again.

        A worker who comes back by the same link goes on where they were, on any device. Who
        comes by another link gets a new session, unless one is complete; the old one, which only
        its own token opens, is marked as returned.

        Parameters
        ----------
        study : Study
        ids : mapping of str to str, optional
            What the panel put into the link, by parameter; those of `study.recruitment` count.
        mode : {'live', 'pilot', 'simulated'}
            Sessions of one mode do not count in the balance of another.
        display : Display, optional

        Raises
        ------
        RefusedError
            If the worker has completed the study.
        """
        at = self.clock()
        hashes = self.hashed_ids(study, ids or {})
        with self.database.writing() as connection:
            return open_or_resume(connection, study, mode, hashes, at, display or Display())

    def hashed_ids(self, study: Study, ids: Mapping[str, str]) -> dict[str, str]:
        """Return the keyed hash of each id of the study's recruitment that is given."""
        return {
            parameter: self.key.digest("worker", parameter, ids[parameter])
            for parameter in study.recruitment.id_parameters
            if ids.get(parameter)
        }

    def session(self, token: str) -> Session:
        """Return the session that a token opens, as it stands.

        Raises
        ------
        UnknownSessionError
            If there is none.
        """
        with self.database.reading() as connection:
            return statements.session_of(connection, token, resumed=True)

    def record(self, token: str, trial: int, answer: TrialAnswer) -> Acknowledgement:
        """Keep the answer to a trial, once; when this returns, it is on disk.

        Parameters
        ----------
        token : str
        trial : int
            Place in the session's schedule, from 0; in any order.
        answer : TrialAnswer

        Raises
        ------
        UnknownSessionError
            If no session has the token.
        UnknownTrialError
            If the schedule has no such trial.
        """
        at = iso(self.clock())
        with self.database.writing() as connection:
            return statements.record_answer(connection, token, trial, answer, at)

    def record_event(
        self, token: str, event: str, detail: str | None = None, key: str | None = None
    ) -> bool:
        """Keep an event, once per key; return whether it was new. ``declined`` ends a session."""
        at = iso(self.clock())
        with self.database.writing() as connection:
            subject = statements.subject_of(connection, token)
            if event == "declined" and subject.status == "started":
                statements.set_status(connection, subject.subject, "returned", None)
            return statements.add_event(connection, subject.subject, event, detail, at, key)

    def record_questionnaire(self, token: str, answers: Mapping[str, str]) -> bool:
        """Keep the answers in place of earlier ones; return whether they differ from those.

        Parameters
        ----------
        token : str
        answers : mapping of str to str

        Raises
        ------
        RefusedError
            If the session is complete and the answers are others.
        """
        with self.database.writing() as connection:
            subject = statements.subject_of(connection, token)
            own = questionnaires.c.subject == subject.subject
            kept = connection.execute(
                select(questionnaires.c.question, questionnaires.c.answer).where(own)
            ).all()
            if dict(kept) == dict(answers):
                return False
            if subject.status == "complete":
                raise RefusedError("the study is complete: its questionnaire stands as it was")
            connection.execute(delete(questionnaires).where(own))
            given = [
                {"subject": subject.subject, "question": question, "answer": answer}
                for question, answer in answers.items()
            ]
            statements.insert_new(connection, questionnaires, given)
            this = subjects.c.subject == subject.subject
            connection.execute(update(subjects).where(this).values(subject_columns(answers)))
        return True

    def finish(self, token: str, required: Collection[str] = ()) -> str:
        """Complete a session and return its completion code; again the same if asked again.

        Parameters
        ----------
        token : str
        required : collection of str
            Questions that must have been answered.

        Raises
        ------
        RefusedError
            If a trial or a required question has no answer yet; `missing` and `questions` name
            them.
        """
        at = iso(self.clock())
        with self.database.writing() as connection:
            session = statements.session_of(connection, token, resumed=True)
            if session.status == "returned":
                raise RefusedError("this session was ended: open the study's link again")
            missing = statements.missing_trials(session.schedule, session.answered)
            questions = sorted(set(required) - set(session.questionnaire))
            if session.status != "complete":
                if missing or questions:
                    raise RefusedError(
                        "the study is not complete yet: some answers have not arrived",
                        missing=missing,
                        questions=questions,
                    )
                statements.set_status(connection, session.subject, "complete", at)
            return self._code(connection, session)

    def _code(self, connection: Connection, session: Session) -> str:
        own_trials = trials.c.subject == session.subject
        own_answers = questionnaires.c.subject == session.subject
        responses = connection.execute(
            select(trials.c.trial, trials.c.response).where(own_trials)
        ).all()
        answers = connection.execute(
            select(questionnaires.c.question, questionnaires.c.answer).where(own_answers)
        ).all()
        given = ([tuple(row) for row in rows] for rows in (responses, answers))
        return completion_code(self.key, session.subject, session.study_hash, *given)

    def read(self, modes: Collection[str] = COUNTED) -> StudyData:
        """Return the answers of these modes, subjects as they came; by default no pilots."""
        with self.database.reading() as connection:
            return rows.read_tables(connection, modes)

    def write(self, data: StudyData) -> dict[str, int]:
        """Add answers that came another way; what is there already stays. Return rows added.

        Parameters
        ----------
        data : StudyData

        Returns
        -------
        dict of str to int
            By table.
        """
        with self.database.writing() as connection:
            return rows.write_tables(connection, data)

    def subjects_of(self, worker: str) -> frozenset[str]:
        """Return the subjects that a panel's worker was, by any of the worker's ids."""
        with self.database.reading() as connection:
            parameters = connection.scalars(select(recruits.c.parameter).distinct()).all()
            hashes = [self.key.digest("worker", name, worker) for name in parameters]
            found = connection.scalars(
                select(recruits.c.subject).where(recruits.c.keyed_hash.in_(hashes))
            )
            return frozenset(found)

    def export_subject(self, subject: str) -> dict[str, list[dict[str, Any]]]:
        """Return all that is kept of one subject, by table; tokens are left out.

        Raises
        ------
        RelightlabError
            If there is no such subject.
        """
        with self.database.reading() as connection:
            kept = rows.rows_of_subject(connection, subject)
        if not kept["subjects"]:
            raise _no_subject(subject)
        return kept

    def delete_subject(self, subject: str) -> int:
        """Delete all that is kept of one subject and return how many rows that was.

        Raises
        ------
        RelightlabError
            If there is no such subject.
        """
        with self.database.writing() as connection:
            count = rows.delete_rows_of_subject(connection, subject)
        if not count:
            raise _no_subject(subject)
        self.database.forget_deleted()
        return count


def _no_subject(subject: str) -> RelightlabError:
    return RelightlabError(f"the database has no subject {subject!r}: see the table of subjects")
