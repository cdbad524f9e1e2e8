"""Connections to the database: durable, in line, and to known kinds only."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from shading_model.errors import RelightlabError
from studies.response_store import ResponseStore
from studies.serving import bound_socket
from studies.store_engine import Database, database_url


@pytest.mark.parametrize(
    ("address", "url"),
    [
        ("a b.sqlite", "sqlite:///a b.sqlite"),
        ("sqlite:///x/a.sqlite", "sqlite:///x/a.sqlite"),
        ("postgresql://u@h/n", "postgresql+psycopg://u@h/n"),
        ("postgres://u@h:5433/n", "postgresql+psycopg://u@h:5433/n"),
        ("postgresql+psycopg://u:p@h/n", "postgresql+psycopg://u:***@h/n"),
    ],
)
def test_addresses_are_read(address: str, url: str) -> None:
    """Paths and the usual spellings of URLs are taken; a password is not shown."""
    assert str(database_url(address)) == url


@pytest.mark.parametrize(
    "address",
    ["mysql://h/n", "sqlite://", "sqlite:///:memory:", "postgresql+asyncpg://h/n", ":memory:"],
)
def test_other_addresses_are_refused(address: str) -> None:
    """A database that would forget, or that we do not speak to, is told in a sentence."""
    with pytest.raises(RelightlabError, match="expected a database sqlite"):
        database_url(address)


def test_a_missing_folder_is_told(tmp_path: Path) -> None:
    """A file in a folder that is not there is told before anything is tried."""
    with pytest.raises(RelightlabError, match="does not exist"):
        Database(tmp_path / "none" / "a.sqlite")


def test_every_commit_is_flushed(store: ResponseStore) -> None:
    """SQLite has its write-ahead log flushed at each commit; PostgreSQL commits synchronously."""
    names = (
        {"journal_mode": "wal", "synchronous": "2", "foreign_keys": "1", "secure_delete": "1"}
        if store.database.is_sqlite
        else {"synchronous_commit": "on", "fsync": "on"}
    )
    verb = "PRAGMA" if store.database.is_sqlite else "SHOW"
    with store.database.reading() as connection:
        found = {n: str(connection.exec_driver_sql(f"{verb} {n}").scalar()) for n in names}
    assert found == names


def test_a_failed_transaction_leaves_nothing(store: ResponseStore) -> None:
    """What a block wrote before it failed is not there."""
    from studies.store_schema import facts

    def fail() -> None:
        with store.database.writing() as connection:
            connection.execute(facts.insert(), {"name": "x", "value": "y"})
            raise KeyError("x")

    with pytest.raises(KeyError):
        fail()
    with store.database.reading() as connection:
        assert "x" not in [row.name for row in connection.execute(facts.select())]


def test_readers_do_not_wait_for_writers(store: ResponseStore) -> None:
    """While one writes, others read the state before."""
    from studies.store_schema import facts

    seen: list[int] = []

    def read() -> None:
        with store.database.reading() as connection:
            seen.append(len(connection.execute(facts.select()).all()))

    with store.database.writing() as connection:
        connection.execute(facts.insert(), {"name": "x", "value": "y"})
        thread = threading.Thread(target=read)
        thread.start()
        thread.join(10)
    read()
    assert seen == [3, 4]


def test_keys_lie_beside_files_and_else_with_the_user(tmp_path: Path) -> None:
    """The key of a SQLite file is beside it; that of a server's database in the user's folder."""
    assert Database(tmp_path / "a.sqlite").key_path() == tmp_path / "a.sqlite.key"
    path = Database("postgresql://lab@db.example:5433/answers").key_path()
    assert (path.name, path.parent.name) == ("db.example-5433-answers.key", "relightlab")


def test_a_taken_port_is_told() -> None:
    """A port that another program listens at, or that is none, is told with what to do."""
    with bound_socket("127.0.0.1", 0) as first:
        first.listen()
        with pytest.raises(RelightlabError, match="choose another with --port"):
            bound_socket("127.0.0.1", first.getsockname()[1])
    with pytest.raises(RelightlabError, match="cannot listen at"):
        bound_socket("127.0.0.1", 70_000)
