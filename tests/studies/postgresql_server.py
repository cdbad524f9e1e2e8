"""A PostgreSQL server of the tests' own: started in a folder for the time, and gone afterwards."""

from __future__ import annotations

import os
import pwd
import shutil
import subprocess
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

OWNER = "lab"
_QUICK = "-c fsync=on -c max_connections=60 -c shared_buffers=16MB -c listen_addresses=''"


def program_folder() -> Path | None:
    """Return where initdb and pg_ctl are, or None."""
    found = shutil.which("initdb")
    places = [Path(found).resolve().parent] if found else []
    places += sorted(Path("/usr/lib/postgresql").glob("*/bin"), reverse=True)
    return next((place for place in places if _complete(place)), None)


def _complete(place: Path) -> bool:
    return all((place / name).is_file() for name in ("initdb", "pg_ctl", "postgres"))


@dataclass
class PostgresqlServer:
    """A running server that only this machine's users reach, through a socket in its folder."""

    programs: Path
    folder: Path = field(default_factory=lambda: Path(tempfile.mkdtemp(prefix="relightlab-pg-")))

    def start(self) -> None:
        """Make the cluster and start it."""
        if self._account() is not None:
            os.chown(self.folder, *self._account() or (0, 0))
        data = str(self.folder / "data")
        options = ["-A", "trust", "-U", OWNER, "-E", "UTF8", "--locale=C", "--no-sync"]
        self._run("initdb", "-D", data, *options)
        self._control("start", "-o", f"{_QUICK} -k {self.folder}")

    def restart(self) -> None:
        """End the server at once, as a crash would, and start it again."""
        self._control("restart", "-m", "immediate")

    def stop(self) -> None:
        """End the server and remove its folder."""
        self._control("stop", "-m", "immediate")
        shutil.rmtree(self.folder, ignore_errors=True)

    def emptied_database(self) -> str:
        """Return the address of the database, with nothing in it."""
        import psycopg

        where = f"host={self.folder} user={OWNER} dbname=postgres"
        with psycopg.connect(where, autocommit=True) as connection:
            connection.execute("DROP SCHEMA public CASCADE")
            connection.execute("CREATE SCHEMA public")
        return f"postgresql://{OWNER}@/postgres?host={self.folder}"

    def _control(self, action: str, *options: str) -> None:
        log = str(self.folder / "log")
        self._run("pg_ctl", action, "-D", str(self.folder / "data"), "-w", "-l", log, *options)

    def _run(self, program: str, *options: str) -> None:
        uid_gid = self._account()
        as_whom = (
            {} if uid_gid is None else {"user": uid_gid[0], "group": uid_gid[1], "extra_groups": []}
        )
        # Output to a file: a server that inherits a pipe would keep it open.
        with (self.folder / f"{program}.out").open("a") as out:
            subprocess.run(
                [str(self.programs / program), *options],
                check=True,
                stdout=out,
                stderr=out,
                cwd=self.folder,
                timeout=60,
                **as_whom,  # type: ignore[call-overload]
            )

    @staticmethod
    def _account() -> tuple[int, int] | None:
        """Return who runs the server where we are root, which it refuses to run as."""
        if os.geteuid() != 0:
            return None
        names = {entry.pw_name: (entry.pw_uid, entry.pw_gid) for entry in pwd.getpwall()}
        return names.get("postgres") or names["nobody"]
