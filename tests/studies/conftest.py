"""What the tests of serving share: a study with pictures, and databases of both kinds."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from studies.response_store import ResponseStore
from studies.study_records import Study
from tests.studies.postgresql_server import PostgresqlServer, program_folder
from tests.studies.small_study import small_study


@pytest.fixture(scope="session")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    """A study of two tasks of three pairs, with pictures."""
    return small_study(tmp_path_factory.mktemp("study"))


@pytest.fixture(scope="session")
def postgresql() -> Iterator[PostgresqlServer]:
    """A PostgreSQL server of our own; skips where there are no programs of one."""
    programs = program_folder()
    if programs is None:
        pytest.skip("no initdb and pg_ctl here")
    server = PostgresqlServer(programs)
    server.start()
    yield server
    server.stop()


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.postgresql)])
def address(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """The address of an empty database, of either kind."""
    if request.param == "sqlite":
        return str(tmp_path / "answers.sqlite")
    server: PostgresqlServer = request.getfixturevalue("postgresql")
    return server.emptied_database()


@pytest.fixture
def store(address: str, tmp_path: Path) -> Iterator[ResponseStore]:
    """An empty store, in a database of either kind."""
    opened = ResponseStore(address, key_file=tmp_path / "answers.key")
    yield opened
    opened.close()


@pytest.fixture
def sqlite_store(tmp_path: Path) -> Iterator[ResponseStore]:
    """An empty store in a SQLite file."""
    opened = ResponseStore(tmp_path / "answers.sqlite")
    yield opened
    opened.close()
