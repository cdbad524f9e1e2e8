"""How a response store talks to its database: connections, durability and transactions."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import platformdirs
from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, NoSuchModuleError

from shading_model.errors import RelightlabError
from studies.group_commit import GroupCommit

BUSY_SECONDS = 10
"""How long a statement waits for another's lock before the request is refused, to be repeated."""

_OPENING = 0x72656C69  # a number that no other program's lock is likely to have
_POSTGRESQL = "-c synchronous_commit=on -c lock_timeout=10s -c statement_timeout=30s"
_SQLITE = (
    "PRAGMA journal_mode=WAL",
    "PRAGMA synchronous=FULL",
    "PRAGMA foreign_keys=ON",
    "PRAGMA secure_delete=ON",
    f"PRAGMA busy_timeout={BUSY_SECONDS * 1000}",
)


class Database:
    """A database that answers are written to: SQLite by default, PostgreSQL by its URL.

    A transaction that has ended is on disk: SQLite runs with a write-ahead log that is flushed at
    every commit, PostgreSQL with synchronous commits.

    Parameters
    ----------
    address : str or Path
        ``sqlite:///answers.sqlite``, ``postgresql://user@host/name``, or the path of a SQLite file.
    must_exist : bool
        Whether a SQLite file that is not there is a fault, rather than made.

    Raises
    ------
    RelightlabError
        If the address is of neither kind, or the driver for PostgreSQL is not installed.

    Examples
    --------
    >>> Database("mysql://host/answers")
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: expected a database sqlite:///FILE or
    postgresql://USER@HOST/NAME, got 'mysql://host/answers'
    """

    def __init__(self, address: str | Path, *, must_exist: bool = False) -> None:
        self.url = database_url(address)
        self.is_sqlite = self.url.get_backend_name() == "sqlite"
        if self.is_sqlite and must_exist and not Path(str(self.url.database)).is_file():
            raise RelightlabError(f"there is no database {self.url.database}: name another")
        self._engine = _sqlite(self.url) if self.is_sqlite else _postgresql(self.url)
        writer = self._engine.execution_options(begin="BEGIN IMMEDIATE")
        # SQLite would poll for its lock and flush for each writer; PostgreSQL does this by itself.
        self._group = GroupCommit(writer.connect) if self.is_sqlite else None

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """Run a transaction that writes; when the block has ended, it is on disk."""
        with self._group.writing() if self._group else self._engine.begin() as connection:
            yield connection

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Run a transaction that sees one state of the database throughout."""
        engine = self._engine
        if not self.is_sqlite:
            engine = engine.execution_options(isolation_level="REPEATABLE READ")
        with engine.begin() as connection:
            yield connection

    def hold_everything(self, connection: Connection) -> None:
        """Let no other transaction of this program's opening run until this one has ended."""
        if not self.is_sqlite:  # there, whoever writes is alone
            connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({_OPENING})")

    def forget_deleted(self) -> None:
        """Leave nothing of deleted rows in SQLite's log; they are overwritten in the file."""
        if self._group:
            with self._group.alone(), self._engine.connect() as connection:
                connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)")

    def key_path(self) -> Path:
        """Return where the key lies by default: beside a file, else in the user's own folder."""
        if self.is_sqlite and self.url.database:
            path = Path(self.url.database)
            return path.with_name(f"{path.name}.key")
        where = "-".join(str(part) for part in (self.url.host, self.url.port) if part)
        folder = platformdirs.user_data_path("relightlab", appauthor=False)
        return folder / f"{where or 'local'}-{self.url.database}.key"

    def close(self) -> None:
        """Close every connection."""
        self._engine.dispose()


def database_url(address: str | Path) -> URL:
    """Return the URL of a database that answers can be kept in.

    Parameters
    ----------
    address : str or Path
        A URL, or the path of a SQLite file.

    Raises
    ------
    RelightlabError
        If it is neither.

    Examples
    --------
    >>> print(database_url("answers.sqlite"), database_url("postgresql://lab@host/answers"))
    sqlite:///answers.sqlite postgresql+psycopg://lab@host/answers
    """
    text = str(address)
    try:
        url = make_url(text) if "://" in text else URL.create("sqlite", database=text)
    except (ArgumentError, ValueError) as error:
        raise _wrong(text) from error
    kind = url.get_backend_name()
    if kind == "sqlite" and url.database not in {None, "", ":memory:"}:
        return url
    if url.drivername in {"postgresql", "postgres", "postgresql+psycopg"}:
        return url.set(drivername="postgresql+psycopg")
    raise _wrong(text)


def _wrong(text: str) -> RelightlabError:
    return RelightlabError(
        f"expected a database sqlite:///FILE or postgresql://USER@HOST/NAME, got {text!r}"
    )


def _sqlite(url: URL) -> Engine:
    path = Path(str(url.database))
    if not path.parent.is_dir():
        raise RelightlabError(
            f"the folder {path.parent} does not exist: make it, or choose another"
        )
    # Comments are nobody else's to read; SQLite gives its other files the same permissions.
    path.touch(mode=0o600, exist_ok=True)
    engine = create_engine(
        url, pool_size=8, max_overflow=64, connect_args={"check_same_thread": False}
    )
    event.listen(engine, "connect", _prepare)
    event.listen(engine, "begin", _begin)
    return engine


def _prepare(connection: sqlite3.Connection, _record: object) -> None:
    connection.isolation_level = None  # transactions begin where we say so
    for pragma in _SQLITE:
        connection.execute(pragma)


def _begin(connection: Connection) -> None:
    options: dict[str, Any] = dict(connection.get_execution_options())
    connection.exec_driver_sql(options.get("begin", "BEGIN"))


def _postgresql(url: URL) -> Engine:
    try:
        return create_engine(
            url,
            pool_size=16,
            max_overflow=24,
            pool_pre_ping=True,
            connect_args={"connect_timeout": BUSY_SECONDS, "options": _POSTGRESQL},
        )
    except (ModuleNotFoundError, NoSuchModuleError) as error:
        raise RelightlabError(
            "a PostgreSQL database needs the driver psycopg: install relightlab[postgresql]"
        ) from error
