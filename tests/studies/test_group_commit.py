"""Writers whose work is committed together: each succeeds or fails as if it were alone."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from sqlalchemy import Connection, event, text
from sqlalchemy.exc import OperationalError

from studies.group_commit import GroupCommit
from studies.store_engine import Database

WRITERS = 24


@pytest.fixture
def database(tmp_path: Path) -> Iterator[Database]:
    """A database with a table of numbers."""
    opened = Database(tmp_path / "a.sqlite")
    with opened.writing() as connection:
        connection.execute(text("CREATE TABLE numbers (number INTEGER UNIQUE)"))
    yield opened
    opened.close()


def insert(connection: Connection, number: int) -> None:
    """Write one row."""
    connection.execute(text("INSERT INTO numbers VALUES (:number)"), {"number": number})


def stored(database: Database) -> list[int]:
    """Return the numbers that are there."""
    with database.reading() as connection:
        return sorted(connection.scalars(text("SELECT number FROM numbers")))


def together(
    database: Database, writers: list[Callable[[Connection], None]]
) -> list[BaseException | None]:
    """Run writers so that they join one transaction; return what each of them met."""
    first_is_in, others_wait = threading.Event(), threading.Event()

    def run(which: int) -> BaseException | None:
        try:
            if which:
                first_is_in.wait(10)
            with database.writing() as connection:
                if not which:
                    first_is_in.set()
                    others_wait.wait(10)
                writers[which](connection)
        except (OperationalError, ValueError) as error:
            return error
        return None

    group = database._group
    assert group is not None
    with ThreadPoolExecutor(len(writers)) as pool:
        results = [pool.submit(run, which) for which in range(len(writers))]
        while group._waiting < len(writers) - 1:
            first_is_in.wait(0.01)
        others_wait.set()
        return [result.result() for result in results]


def commits(database: Database) -> list[Connection]:
    """Return a list that grows with every commit."""
    made: list[Connection] = []
    event.listen(database._engine, "commit", made.append)
    return made


def test_writers_who_come_at_once_share_a_commit(database: Database) -> None:
    """All that is written is there, after one commit for those who waited."""
    made = commits(database)
    writers = [lambda c, n=n: insert(c, n) for n in range(WRITERS)]  # type: ignore[misc]
    assert together(database, writers) == [None] * WRITERS
    assert stored(database) == list(range(WRITERS))
    assert len(made) - 1 <= WRITERS // 2  # the last is the reader's


def test_one_writers_fault_is_its_own(database: Database) -> None:
    """A part that fails leaves nothing, and the others' work is there."""

    def fail(connection: Connection) -> None:
        insert(connection, 99)
        raise ValueError("mine")

    met = together(database, [lambda c: insert(c, 0), fail, lambda c: insert(c, 2)])
    assert [type(one) for one in met] == [type(None), ValueError, type(None)]
    assert stored(database) == [0, 2]


def test_a_first_writers_fault_is_its_own(database: Database) -> None:
    """When the one who began fails, those behind begin anew."""

    def fail(connection: Connection) -> None:
        insert(connection, 99)
        raise ValueError("mine")

    met = together(database, [fail, lambda c: insert(c, 1), lambda c: insert(c, 2)])
    assert [type(one) for one in met] == [ValueError, type(None), type(None)]
    assert stored(database) == [1, 2]


def test_a_commit_that_fails_is_everybodys(database: Database) -> None:
    """If the disk does not take the commit, nobody is told that it did, and nothing is there."""

    def full(_connection: Connection) -> None:
        raise OperationalError("COMMIT", {}, Exception("disk full"))

    event.listen(database._engine, "commit", full)
    met = together(database, [lambda c, n=n: insert(c, n) for n in range(3)])  # type: ignore[misc]
    assert [type(one) for one in met] == [OperationalError] * 3
    event.remove(database._engine, "commit", full)
    assert stored(database) == []
    with database.writing() as connection:
        insert(connection, 7)
    assert stored(database) == [7]


def test_a_transaction_that_is_gone_is_told_to_all_of_it(database: Database) -> None:
    """A full disk ends SQLite's transaction: all who had joined are told, later ones not."""

    def lose(connection: Connection) -> None:
        connection.exec_driver_sql("ROLLBACK")  # as SQLite itself does
        insert(connection, 99)
        raise OperationalError("INSERT", {}, Exception("disk full"))

    # What follows is written outside any transaction, so it is not looked for.
    met = together(database, [lambda c: insert(c, 0), lose])
    assert [type(one) for one in met] == [OperationalError] * 2
    assert 0 not in stored(database)
    with database.writing() as connection:
        insert(connection, 1)
    assert 1 in stored(database)


def test_alone_means_that_no_transaction_is_open(database: Database) -> None:
    """What must have the database for itself waits for those who write."""
    group = database._group
    assert isinstance(group, GroupCommit)
    order: list[str] = []
    inside, go_on = threading.Event(), threading.Event()

    def write() -> None:
        with database.writing() as connection:
            inside.set()
            go_on.wait(10)
            insert(connection, 1)
            order.append("written")

    thread = threading.Thread(target=write)
    thread.start()
    inside.wait(10)
    threading.Timer(0.05, go_on.set).start()
    with group.alone():
        order.append("alone")
    thread.join()
    assert order == ["written", "alone"]


def test_a_slow_disk_is_shared(database: Database) -> None:
    """With a disk that takes 50 ms to flush, many writers wait for few flushes, not for each."""
    made = commits(database)
    event.listen(database._engine, "commit", lambda _: time.sleep(0.05))

    def write(number: int) -> None:
        with database.writing() as connection:
            insert(connection, number)

    with ThreadPoolExecutor(WRITERS) as pool:
        list(pool.map(write, range(4 * WRITERS)))
    assert stored(database) == list(range(4 * WRITERS))
    assert len(made) < 2 * WRITERS
