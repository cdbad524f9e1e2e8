"""A study's server as a process: bound to a port, told when it is ready, stopped by a signal."""

from __future__ import annotations

import contextlib
import socket
import sys
from collections.abc import Callable
from pathlib import Path

import uvicorn
from fastapi import FastAPI

from shading_model.errors import RelightlabError
from studies.response_store import ResponseStore
from studies.server import make_app
from studies.study_file import load_study

READY = "serving at "
"""How the line begins that says where a server is ready."""


def serve_app(
    app: FastAPI, host: str, port: int, when_ready: Callable[[str], None] = lambda _: None
) -> None:
    """Serve an application until the process is told to stop.

    Nothing is logged about requests: an address in a log would be kept, too.

    Parameters
    ----------
    app : FastAPI
    host : str
        Address to listen at; ``127.0.0.1`` for this machine alone.
    port : int
        0 for any that is free.
    when_ready : callable, optional
        Called with the page's address once connections are taken.

    Raises
    ------
    RelightlabError
        If the port cannot be had.
    """
    listening = bound_socket(host, port)
    listening.listen(1024)
    shown = f"[{host}]" if ":" in host else host
    when_ready(f"http://{shown}:{listening.getsockname()[1]}/")
    config = uvicorn.Config(
        app, access_log=False, log_level="warning", server_header=False, timeout_keep_alive=75
    )
    with contextlib.suppress(KeyboardInterrupt), listening:
        uvicorn.Server(config).run(sockets=[listening])


def bound_socket(host: str, port: int) -> socket.socket:
    """Return a socket bound to the address.

    Parameters
    ----------
    host : str
    port : int

    Raises
    ------
    RelightlabError
        If the address is not of this machine, or the port is taken or not allowed.

    Examples
    --------
    >>> with bound_socket("127.0.0.1", 0) as bound:
    ...     bound.getsockname()[1] > 0
    True
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    bound = socket.socket(family, socket.SOCK_STREAM)
    bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        bound.bind((host, port))
    except (OSError, OverflowError) as error:
        bound.close()
        reason = getattr(error, "strerror", None) or error
        raise RelightlabError(
            f"cannot listen at {host} port {port}: {reason}; choose another with --port"
        ) from error
    return bound


def main() -> None:
    """Serve the interface alone, for load tests: STUDY.toml DATABASE PORT MODE."""
    study_file, database, port, mode = sys.argv[1:]
    store = ResponseStore(database)
    app = make_app(load_study(Path(study_file)), store, mode=mode)

    def tell(address: str) -> None:
        sys.stdout.write(f"{READY}{address}\n")
        sys.stdout.flush()

    serve_app(app, "127.0.0.1", int(port), tell)


if __name__ == "__main__":
    main()
