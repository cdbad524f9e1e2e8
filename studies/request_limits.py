"""What every request meets first: a limit of size, a limit of rate, and headers on the way out."""

from __future__ import annotations

import hashlib
import json
import math
import secrets
import time
from collections import OrderedDict
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass
from typing import Any

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; style-src-attr 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self'; connect-src 'self'; form-action 'self'; "
    "base-uri 'none'; frame-ancestors 'none'"
)
"""No script but the page's own files; only single elements may carry a style."""
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=(), fullscreen=(self)",
    "X-Robots-Tag": "noindex, nofollow",
}
MOST_KEPT = 20_000
"""Buckets kept; the least used are forgotten, which is to say full again."""


@dataclass(frozen=True)
class RequestLimits:
    """How much and how often; beyond it a request is refused, to be repeated later.

    Parameters
    ----------
    body_bytes : int
        Of one request.
    session_rate, session_burst : float
        Requests per second of one session, and how many at once.
    address_rate, address_burst : float
        The same for one network address, which a whole laboratory may share.
    opening_rate, opening_burst : float
        The same for new sessions of one address.
    """

    body_bytes: int = 65_536
    session_rate: float = 5.0
    session_burst: float = 60.0
    address_rate: float = 200.0
    address_burst: float = 1000.0
    opening_rate: float = 2.0
    opening_burst: float = 400.0


UNLIMITED = RequestLimits(65_536, *[math.inf] * 6)
"""No limit of rate: for simulated subjects, who are quicker than people."""


class Buckets:
    """Token buckets by key: each fills at a rate, up to a burst, and a request takes one token.

    Parameters
    ----------
    rate, burst : float
    clock : callable
        Monotonic seconds.

    Examples
    --------
    >>> seconds = iter([0.0, 0.0, 0.0, 2.0])
    >>> buckets = Buckets(1.0, 2.0, lambda: next(seconds))
    >>> [buckets.wait("key") for _ in range(4)]
    [0.0, 0.0, 1.0, 0.0]
    """

    def __init__(
        self, rate: float, burst: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._rate, self._burst, self._clock = rate, burst, clock
        self._kept: OrderedDict[str, tuple[float, float]] = OrderedDict()

    def wait(self, key: str) -> float:
        """Take a token and return 0, or return the seconds until there is one."""
        if math.isinf(self._burst):
            return 0.0
        instant = self._clock()
        level, last = self._kept.pop(key, (self._burst, instant))
        level = min(self._burst, level + self._rate * (instant - last))
        enough = level >= 1.0
        self._kept[key] = (level - 1.0 if enough else level, instant)
        if len(self._kept) > MOST_KEPT:
            self._kept.popitem(last=False)
        return 0.0 if enough else (1.0 - level) / self._rate


class Guard:
    """The outermost layer of the server: sizes, rates and headers.

    Addresses are used as keys in memory, hashed with a salt of this process, and go nowhere else.

    Parameters
    ----------
    app : ASGI application
    limits : RequestLimits
    clock : callable
        Monotonic seconds.
    """

    def __init__(
        self,
        app: App,
        limits: RequestLimits = RequestLimits(),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._app, self._limits = app, limits
        self._salt = secrets.token_bytes(16)
        self._sessions = Buckets(limits.session_rate, limits.session_burst, clock)
        self._addresses = Buckets(limits.address_rate, limits.address_burst, clock)
        self._openings = Buckets(limits.opening_rate, limits.opening_burst, clock)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on if it is neither too large nor too soon."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        path = scope["path"]
        api = path.startswith("/api/")

        async def sending(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = _with_headers(message.get("headers", []), no_store=api)
            await send(message)

        seconds = self._wait(scope) if api else 0.0
        if seconds > 0.0:
            retry = {"Retry-After": str(max(1, math.ceil(seconds)))}
            await _refuse(sending, 429, "too many requests: wait a little", retry)
            return
        body = await _whole_body(scope, receive, self._limits.body_bytes)
        if body is None:
            sentence = f"expected at most {self._limits.body_bytes} bytes"
            await _refuse(sending, 413, sentence, {"Connection": "close"})
            return
        await self._app(scope, _replayed(body, receive), sending)

    def _wait(self, scope: Scope) -> float:
        address = str((scope.get("client") or ("",))[0]).encode()
        where = hashlib.blake2b(address, key=self._salt).hexdigest()
        waits = [self._addresses.wait(where)]
        if scope["path"].rstrip("/") == "/api/sessions":
            waits.append(self._openings.wait(where))
        elif scope["path"].startswith("/api/sessions/"):
            token = scope["path"].split("/")[3].encode("utf-8", "replace")
            waits.append(self._sessions.wait(hashlib.blake2b(token, key=self._salt).hexdigest()))
        return max(waits)


def _with_headers(
    headers: list[tuple[bytes, bytes]], *, no_store: bool
) -> list[tuple[bytes, bytes]]:
    added = HEADERS | ({"Cache-Control": "no-store"} if no_store else {})
    return [*headers, *((n.lower().encode(), v.encode()) for n, v in added.items())]


async def _refuse(send: Send, status: int, sentence: str, headers: dict[str, str]) -> None:
    content = json.dumps({"detail": sentence}).encode()
    plain = {"content-type": "application/json", "content-length": str(len(content))} | headers
    start = [(name.lower().encode(), value.encode()) for name, value in plain.items()]
    await send({"type": "http.response.start", "status": status, "headers": start})
    await send({"type": "http.response.body", "body": content})


async def _whole_body(scope: Scope, receive: Receive, most: int) -> bytes | None:
    """Return the body, or None as soon as it is larger than it may be."""
    declared = dict(scope["headers"]).get(b"content-length", b"0")
    if not declared.isdigit() or int(declared) > most:
        return None
    parts: list[bytes] = []
    size, more = 0, True
    while more and size <= most:
        message = await receive()
        if message["type"] == "http.disconnect":
            break
        parts.append(message.get("body", b""))
        size += len(parts[-1])
        more = message.get("more_body", False)
    return b"".join(parts) if size <= most else None


def _replayed(body: bytes, receive: Receive) -> Receive:
    given = False

    async def replay() -> Message:
        nonlocal given
        if given:
            return await receive()
        given = True
        return {"type": "http.request", "body": body, "more_body": False}

    return replay
