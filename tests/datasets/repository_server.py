"""A web server of this machine that serves a tree as the public repository does, with faults."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

Fault = str
"""``drop``, ``damage``, ``wrong range``, or a status code such as ``404``."""


@dataclass(frozen=True)
class Request:
    """One request: the path, the ``Range`` header or None, and the bytes of body sent."""

    path: str
    range: str | None
    sent: int


@dataclass
class RepositoryServer:
    """The served files, the faults still to come (one taken by each request), and a record."""

    read: Callable[[str], bytes | None]
    ranges: bool = True
    faults: dict[str, list[Fault]] = field(default_factory=dict)
    requests: list[Request] = field(default_factory=list)
    url: str = ""

    def sent(self, path: str) -> list[int]:
        """Return the bytes of body sent for `path`, request by request."""
        return [request.sent for request in self.requests if request.path == path]

    def next_fault(self, path: str) -> Fault | None:
        """Return the fault of this request; the last one listed stays when marked with ``*``."""
        waiting = self.faults.get(path, [])
        if not waiting:
            return None
        return waiting[0].removesuffix("*") if waiting[0].endswith("*") else waiting.pop(0)


@contextmanager
def serving(server: RepositoryServer) -> Iterator[RepositoryServer]:
    """Serve on a free port of the loopback address while the block runs."""
    web = ThreadingHTTPServer(
        ("127.0.0.1", 0), type("Handler", (_Handler,), {"repository": server})
    )
    server.url = f"http://127.0.0.1:{web.server_port}/owner/name/commit"
    thread = threading.Thread(target=web.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    try:
        yield server
    finally:
        web.shutdown()
        thread.join()
        web.server_close()


class _Handler(BaseHTTPRequestHandler):
    repository: RepositoryServer
    protocol_version = "HTTP/1.1"
    timeout = 5
    disable_nagle_algorithm = True

    def do_GET(self) -> None:
        path = self.path.removeprefix("/owner/name/commit/")
        fault, content = self.repository.next_fault(path), self.repository.read(path)
        if content is None:
            fault = "404"
        if fault is not None and fault.isdecimal():
            self._answer(path, int(fault), b"")
        elif content is not None:
            self._send(path, content, fault)

    def _send(self, path: str, content: bytes, fault: Fault | None) -> None:
        wanted = self.headers.get("Range")
        if fault == "damage":
            content = bytes(255 - byte for byte in content)
        start = int(wanted.removeprefix("bytes=").removesuffix("-")) if wanted else 0
        if not wanted or not self.repository.ranges:
            self._answer(path, 200, content, dropped=fault == "drop")
        elif start >= len(content):
            self._answer(path, 416, b"", f"bytes */{len(content)}")
        else:
            start = 0 if fault == "wrong range" else start
            place = f"bytes {start}-{len(content) - 1}/{len(content)}"
            self._answer(path, 206, content[start:], place, dropped=fault == "drop")

    def _answer(
        self, path: str, status: int, body: bytes, place: str = "", *, dropped: bool = False
    ) -> None:
        part = body[: len(body) // 2] if dropped else body
        self.repository.requests.append(Request(path, self.headers.get("Range"), len(part)))
        self.send_response(status)
        self.send_header("Content-Length", str(len(body)))
        if place:
            self.send_header("Content-Range", place)
        self.end_headers()
        self.wfile.write(part)
        self.close_connection = dropped

    def log_message(self, *_: object) -> None:
        """Keep quiet: the record of requests says it all."""
