"""HTTP downloads that go on where they stopped.

`pooch` asks a downloader for one file, then checks its SHA-256 and moves it to its final name;
this downloader keeps what has arrived of a file until all of it has.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from http import HTTPStatus
from pathlib import Path

import requests

# What a drop can cost: a piece that has not arrived in full is not kept.
PIECE = 1 << 13


class UnusableAnswerError(requests.ConnectionError):
    """The server answered with another part of the file than asked for; asking anew may help."""


@dataclass(frozen=True)
class ResumingDownloader:
    """A downloader in `pooch`'s sense that continues an interrupted file by an HTTP range.

    What has arrived lies in `partial_folder`, under a name made from the address, and is moved to
    the output file when the answer is complete. A server that does not know ranges sends the file
    from its start. Nothing here knows whether the content is right: the caller checks its hash.
    Two processes must not download into one folder at once; the hash would tell if they did.

    Parameters
    ----------
    session : requests.Session
        Keeps the connection open between files.
    partial_folder : Path
        On the file system of the output files; made when needed.
    timeout : (float, float)
        Seconds to wait for a connection and between two pieces of an answer.
    """

    session: requests.Session
    partial_folder: Path
    timeout: tuple[float, float] = (10.0, 60.0)

    def __call__(self, url: str, output_file: str, pooch: object, **options: object) -> None:  # noqa: ARG002
        """Download `url` into `output_file`.

        Raises
        ------
        requests.RequestException
            If the connection fails, is dropped, or the server refuses.
        OSError
            If a file cannot be written.
        """
        partial = self.partial_path(url)
        partial.parent.mkdir(parents=True, exist_ok=True)
        self._receive(url, partial)
        partial.replace(output_file)

    def partial_path(self, url: str) -> Path:
        """Return where the part of `url` that has arrived is kept."""
        return self.partial_folder / f"{hashlib.sha256(url.encode()).hexdigest()[:32]}.part"

    def _receive(self, url: str, partial: Path) -> None:
        start = partial.stat().st_size if partial.exists() else 0
        # Compressed on the way, a range would not be one of the file's own bytes.
        headers = {"Accept-Encoding": "identity"}
        if start:
            headers["Range"] = f"bytes={start}-"
        with self.session.get(url, headers=headers, stream=True, timeout=self.timeout) as answer:
            append = _continues(answer, start, partial)
            with partial.open("ab" if append else "wb") as stream:
                for chunk in answer.iter_content(PIECE):
                    stream.write(chunk)
                stream.flush()
                os.fsync(stream.fileno())


def _continues(answer: requests.Response, start: int, partial: Path) -> bool:
    """Return whether the answer's body belongs after the `start` bytes that are there."""
    if answer.status_code == HTTPStatus.OK:
        return False
    if answer.status_code == HTTPStatus.PARTIAL_CONTENT and start:
        if answer.headers.get("Content-Range", "").startswith(f"bytes {start}-"):
            return True
    elif answer.status_code != HTTPStatus.REQUESTED_RANGE_NOT_SATISFIABLE:
        answer.raise_for_status()
    # What is there is longer than the file, or the server sent a part nobody asked for.
    partial.unlink(missing_ok=True)
    message = f"the server answered {answer.status_code} to a request from byte {start}"
    raise UnusableAnswerError(message)
