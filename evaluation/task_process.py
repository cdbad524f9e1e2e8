"""Tasks in a process of their own, whose end costs a task and never the process that asked.

A Dask worker does its tasks on threads, where no time limit can stop a task and a task that is
killed for memory takes the worker and its other tasks along. So each thread keeps one such process:
tasks run in its main thread, alone, on one BLAS thread. It ends by itself when its owner dies, or
when nothing was asked of it for a while.
"""

from __future__ import annotations

import os
import pickle
import queue
import subprocess
import sys
import threading
from collections.abc import Mapping
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from types import MappingProxyType
from typing import Any

from datasets.worker_processes import leave_interrupts_to_the_parent
from evaluation.code_version import code_hash
from shading_model.errors import RelightlabError

ONE_THREAD: Mapping[str, str] = MappingProxyType(
    dict.fromkeys(
        (
            *("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"),
            *("NUMBA_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"),
        ),
        "1",
    )
)
"""Environment of every worker process, read once when numerical libraries are imported."""
IDLE_SECONDS = 60.0
ATTEMPTS = 2
_DONE, _FAULT = "done", "fault"
_own = threading.local()


class TaskProcess:
    """A process that does one kind of work, item by item.

    Parameters
    ----------
    work : bytes
        A pickled callable of one item.
    code : str
        What `evaluation.code_version.code_hash` must be in the process.
    """

    def __init__(self, work: bytes, code: str) -> None:
        self._asked = (code, work)
        self._connection, other = Pipe()
        command = [sys.executable, "-m", "evaluation.task_process", str(other.fileno())]
        path = os.pathsep.join(filter(None, sys.path))
        self._process = subprocess.Popen(
            command,
            env={**os.environ, **ONE_THREAD, "PYTHONPATH": path},
            pass_fds=(other.fileno(),),
            stdin=subprocess.DEVNULL,
        )
        other.close()
        self._connection.send(self._asked)

    def serves(self, work: bytes, code: str) -> bool:
        """Return whether the process is alive and does this work.

        Parameters
        ----------
        work : bytes
        code : str
        """
        return self._process.poll() is None and self._asked == (code, work)

    def run(self, item: bytes) -> Any:
        """Return the result of one pickled item.

        Parameters
        ----------
        item : bytes

        Raises
        ------
        EOFError, OSError
            If the process died over it.
        RelightlabError
            If the process cannot do the work at all: other code, or a package that is missing.
        """
        self._connection.send_bytes(item)
        kind, result = self._connection.recv()
        if kind == _FAULT:
            raise RelightlabError(result)
        return result

    def close(self) -> None:
        """End the process."""
        self._connection.close()
        self._process.kill()
        self._process.wait()


def run_in_own_process(work: bytes, code: str, item: bytes) -> Any:
    """Do one item in the process of the calling thread, started if need be.

    Parameters
    ----------
    work : bytes
        A pickled callable of one item; its result is never None.
    code : str
        As `TaskProcess`.
    item : bytes
        Pickled.

    Returns
    -------
    object
        None if the process died over the item, and a fresh one did so again.

    Raises
    ------
    RelightlabError
        As `TaskProcess.run`.
    """
    for _ in range(ATTEMPTS):
        try:
            return _process_of_this_thread(work, code).run(item)
        except (EOFError, OSError):
            # It is dead, or can no longer be talked to; the next attempt starts another.
            _close_own()
    return None


def _process_of_this_thread(work: bytes, code: str) -> TaskProcess:
    process: TaskProcess | None = getattr(_own, "process", None)
    if process is None or not process.serves(work, code):
        _close_own()
        process = _own.process = TaskProcess(work, code)
    return process


def _close_own() -> None:
    process: TaskProcess | None = getattr(_own, "process", None)
    _own.process = None
    if process is not None:
        process.close()


def _serve(connection: Connection) -> None:
    """Do what is asked until nothing is; whatever the work prints goes to standard error."""
    os.dup2(2, 1)
    code, pickled = connection.recv()
    inbox: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_receive, args=(connection, inbox), daemon=True).start()
    try:
        work = _unpickled(pickled, code)
        while True:
            connection.send((_DONE, work(pickle.loads(inbox.get(timeout=IDLE_SECONDS)))))  # noqa: S301  our own bytes
    except queue.Empty:
        return
    except Exception as error:  # noqa: BLE001  whoever asked says it, in one sentence
        connection.send((_FAULT, f"{type(error).__name__}: {error}"))


def _unpickled(work: bytes, code: str) -> Any:
    if code != code_hash():
        raise RelightlabError("its relightlab is of another version than the one that asks")
    return pickle.loads(work)  # noqa: S301  our own bytes


def _receive(connection: Connection, inbox: queue.SimpleQueue[bytes]) -> None:
    """Take in items while the main thread works, and end the process when its owner is gone."""
    try:
        while True:
            inbox.put(connection.recv_bytes())
    except (EOFError, OSError):
        os._exit(1)


if __name__ == "__main__":
    leave_interrupts_to_the_parent()
    _serve(Connection(int(sys.argv[1])))
