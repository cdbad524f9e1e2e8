"""Clients and servers of the tests: FastAPI's test client, and a server in a thread."""

from __future__ import annotations

import threading
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import uvicorn
from fastapi import FastAPI

from studies.serving import bound_socket

with warnings.catch_warnings():
    # It would rather have a successor of httpx, which it can do without.
    warnings.simplefilter("ignore")
    from fastapi.testclient import TestClient

__all__ = ["TestClient", "threaded_server"]


@contextmanager
def threaded_server(app: FastAPI) -> Iterator[str]:
    """Serve an application from a thread of the tests while the block runs; give the address."""
    with bound_socket("127.0.0.1", 0) as listening:
        listening.listen(128)
        server = uvicorn.Server(uvicorn.Config(app, access_log=False, log_level="error"))
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
        thread.start()
        try:
            while not server.started:
                time.sleep(0.01)
            yield f"http://127.0.0.1:{listening.getsockname()[1]}/"
        finally:
            server.should_exit = True
            thread.join()
