"""Many writers of one SQLite file, whose work reaches the disk together.

Flushing to disk takes far longer than writing a row. So whoever comes while others write joins
their transaction, as a part that can fail alone; one of them commits it, and all of them wait for
that. Alone, a writer waits for nobody.
"""

from __future__ import annotations

import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from sqlalchemy import Connection, RootTransaction

MOST_TOGETHER = 64
"""Writers in one transaction."""
_PAUSE_SECONDS = 0.0005


@dataclass
class _Batch:
    connection: Connection
    transaction: RootTransaction
    size: int = 0
    error: BaseException | None = None
    done: threading.Event = field(default_factory=threading.Event)

    @property
    def alive(self) -> bool:
        """Whether SQLite still has the transaction: a full disk ends it at once."""
        driver = self.connection.connection.driver_connection
        return isinstance(driver, sqlite3.Connection) and driver.in_transaction

    def end(self) -> None:
        """Commit, or leave nothing; then let everybody know."""
        try:
            if self.error is None:
                self.transaction.commit()
            else:
                self.transaction.rollback()
        except BaseException as error:  # noqa: BLE001  raised by everyone who waits for it
            self.error = self.error or error
            # Whether it is still in its transaction is not known: nobody shall have it again.
            self.connection.invalidate()
        finally:
            self.connection.close()
            self.done.set()


class GroupCommit:
    """Transactions that are written one after another and committed together.

    Parameters
    ----------
    connect : callable
        Opens a connection whose transactions are allowed to write.
    """

    def __init__(self, connect: Callable[[], Connection]) -> None:
        self._connect = connect
        self._line = threading.Lock()
        self._count = threading.Lock()
        self._waiting = 0
        self._batch: _Batch | None = None

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """Run a block that writes; when this ends without an error, its work is on disk."""
        with self._in_line():
            batch, is_first = self._join()
            try:
                with batch.connection.begin_nested():
                    yield batch.connection
            except BaseException as error:
                self._part_failed(batch, error, is_first=is_first)
                raise
        if is_first:
            self._commit(batch)
        batch.done.wait()
        if batch.error is not None:
            raise batch.error

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Run a block while no transaction is open."""
        while True:
            with self._line:
                if self._batch is None:
                    yield
                    return
            time.sleep(_PAUSE_SECONDS)

    @contextmanager
    def _in_line(self) -> Iterator[None]:
        with self._count:
            self._waiting += 1
        with self._line:
            with self._count:
                self._waiting -= 1
            yield

    def _join(self) -> tuple[_Batch, bool]:
        is_first = self._batch is None
        if self._batch is None:
            connection = self._connect()
            try:
                self._batch = _Batch(connection, connection.begin())
            except BaseException:
                connection.close()
                raise
        self._batch.size += 1
        return self._batch, is_first

    def _part_failed(self, batch: _Batch, error: BaseException, *, is_first: bool) -> None:
        if is_first or not batch.alive:
            batch.error = error
            self._batch = None  # whoever comes next begins anew
        if is_first:  # nobody can have joined yet
            batch.end()

    def _commit(self, batch: _Batch) -> None:
        while True:
            with self._line:
                if batch.error or not self._waiting or batch.size >= MOST_TOGETHER:
                    if self._batch is batch:
                        self._batch = None
                    batch.end()
                    return
            time.sleep(_PAUSE_SECONDS)  # those in line come first
