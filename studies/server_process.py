"""A server in a process of its own, as load tests start it, end it, and start it again."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from shading_model.errors import RelightlabError
from studies.serving import READY


class ServerProcess:
    """The interface of a study, served by another process on this machine.

    Parameters
    ----------
    study_file : Path
    database : str
    port : int
        0 for one that is free; it is kept when the server is started again.
    mode : str
        Of its sessions.
    """

    def __init__(
        self, study_file: Path, database: str, port: int = 0, mode: str = "simulated"
    ) -> None:
        self._study_file, self._database, self._mode = study_file, database, mode
        self._port = port
        self._process: subprocess.Popen[str] | None = None
        self.address = ""

    def start(self) -> str:
        """Start the server and return its address once it is ready.

        Raises
        ------
        RelightlabError
            If it does not come up.
        """
        command = [sys.executable, "-m", "studies.serving", str(self._study_file), self._database]
        self._process = subprocess.Popen(
            [*command, str(self._port), self._mode], stdout=subprocess.PIPE, text=True
        )
        line = self._process.stdout.readline() if self._process.stdout else ""
        if not line.startswith(READY):
            self.kill()
            raise RelightlabError("the server did not start: see what it said above")
        self.address = line.removeprefix(READY).strip()
        self._port = int(self.address.rstrip("/").rsplit(":", 1)[1])
        return self.address

    def kill(self) -> None:
        """End the process at once, as ``kill -9`` does: it has no time to put anything away."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            if self._process.stdout:
                self._process.stdout.close()
            self._process = None


@contextmanager
def running_server(study_file: Path, database: str, mode: str = "simulated") -> Iterator[str]:
    """Serve a study while the block runs, and give the address.

    Parameters
    ----------
    study_file : Path
    database : str
    mode : str

    Yields
    ------
    str
    """
    server = ServerProcess(study_file, database, mode=mode)
    try:
        yield server.start()
    finally:
        server.kill()
