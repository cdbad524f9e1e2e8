"""The download of a set, against a server of this machine with every fault a network has."""

from __future__ import annotations

import hashlib
import logging
import os
import socket
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pooch
import pytest
import requests

from datasets.catalogue import mit_berkeley_files
from datasets.fetching import (
    PARTIAL_FOLDER,
    FetchProgress,
    FetchReport,
    fetch_mit_berkeley,
    repository_path,
)
from datasets.resuming_download import PIECE
from datasets.verification import verify_mit_berkeley
from shading_model.errors import RelightlabError
from tests.datasets.repository_server import RepositoryServer, serving

APPLE = "MIT-Berkeley-Laboratory/apple/diffuse.png"
NAMES = (
    APPLE,
    "MIT-Berkeley-Laboratory/apple/Z.mat",
    "MIT-Berkeley-Natural/apple/L.mat",
    "MIT-Berkeley-Natural/pear/diffuse.png",
    "natural_lights.mat",
)


def _content(name: str) -> bytes:
    seed = int.from_bytes(hashlib.sha256(name.encode()).digest()[:8], "big")
    # Longer than one piece of the downloader's reading, so that a drop falls within the file.
    return np.random.default_rng(seed).bytes(150_000 + seed % 1000)


CONTENTS = {name: _content(name) for name in NAMES}
RECORDED = {name: hashlib.sha256(content).hexdigest() for name, content in CONTENTS.items()}
SERVED = {repository_path(name): content for name, content in CONTENTS.items()}


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[RepositoryServer]:
    """Serve the small tree in the repository's layout, past any proxy of the machine."""
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    with serving(RepositoryServer(SERVED.get)) as running:
        yield running


def _fetch(root: Path, server: RepositoryServer, pauses: list[float] | None = None) -> FetchReport:
    record = [] if pauses is None else pauses
    return fetch_mit_berkeley(
        root, accept_licence=True, base_url=server.url, sha256=RECORDED, pause=record.append
    )


def _visible(root: Path) -> dict[str, bytes]:
    folder = root / "mit-berkeley"
    paths = [path for path in folder.rglob("*") if path.is_file()]
    names = {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}
    return {name: held for name, held in names.items() if not name.startswith(PARTIAL_FOLDER)}


def test_fetch_brings_every_file(tmp_path: Path, server: RepositoryServer) -> None:
    """A fetch leaves exactly the recorded files, byte for byte, and nothing unfinished."""
    report = _fetch(tmp_path, server)
    assert report == FetchReport(tmp_path / "mit-berkeley", downloaded=5, already_there=0)
    assert _visible(tmp_path) == CONTENTS
    assert verify_mit_berkeley(tmp_path, sha256=RECORDED).complete
    assert not (tmp_path / "mit-berkeley" / PARTIAL_FOLDER).exists()


def test_second_fetch_downloads_nothing(tmp_path: Path, server: RepositoryServer) -> None:
    """A fetch of a whole set asks the server for no file."""
    _fetch(tmp_path, server)
    server.requests.clear()
    report = _fetch(tmp_path, server)
    assert (report.downloaded, report.already_there) == (0, 5)
    assert server.requests == []


def test_fetch_completes_a_set(tmp_path: Path, server: RepositoryServer) -> None:
    """A fetch replaces a damaged file and adds a missing one, and leaves the whole ones alone."""
    _fetch(tmp_path, server)
    server.requests.clear()
    (tmp_path / "mit-berkeley" / APPLE).write_bytes(b"damaged")
    (tmp_path / "mit-berkeley" / "natural_lights.mat").unlink()
    assert _fetch(tmp_path, server).downloaded == 2
    assert _visible(tmp_path) == CONTENTS
    assert {r.path for r in server.requests} == {repository_path(APPLE), "natural_lights.mat"}


def test_files_are_readable_by_others(tmp_path: Path, server: RepositoryServer) -> None:
    """Fetched files have the permissions of any new file, not those of a private temporary one."""
    _fetch(tmp_path, server)
    ordinary = tmp_path / "ordinary"
    ordinary.touch()
    modes = {(tmp_path / "mit-berkeley" / name).stat().st_mode for name in NAMES}
    assert modes == {ordinary.stat().st_mode}


def test_damaged_once(tmp_path: Path, server: RepositoryServer) -> None:
    """A file that arrives damaged once is thrown away and fetched anew from its start."""
    server.faults = {repository_path(APPLE): ["damage"]}
    _fetch(tmp_path, server)
    assert _visible(tmp_path) == CONTENTS
    assert server.sent(repository_path(APPLE)) == [len(CONTENTS[APPLE])] * 2


def test_damaged_always(tmp_path: Path, server: RepositoryServer) -> None:
    """A file that always arrives damaged is named, never kept, and does not hold up the others."""
    server.faults = {repository_path(APPLE): ["damage*"]}
    with pytest.raises(RelightlabError, match=rf"4 of 5 .* {APPLE} \(its content .* SHA-256\)"):
        _fetch(tmp_path, server)
    assert _visible(tmp_path) == {n: c for n, c in CONTENTS.items() if n != APPLE}
    assert len(server.sent(repository_path(APPLE))) == 4


def test_dropped_connection_resumes_by_range(tmp_path: Path, server: RepositoryServer) -> None:
    """After a drop only the rest is sent: at most one piece crosses the wire twice."""
    server.faults = {repository_path(APPLE): ["drop"]}
    pauses: list[float] = []
    _fetch(tmp_path, server, pauses)
    size = len(CONTENTS[APPLE])
    before, after = server.sent(repository_path(APPLE))
    assert before == size // 2
    assert size <= before + after < size + PIECE
    assert _visible(tmp_path) == CONTENTS
    assert pauses == [0.5]


def test_dropped_connection_without_ranges(tmp_path: Path, server: RepositoryServer) -> None:
    """A server that knows no ranges sends the file from its start, and the file is whole."""
    server.ranges = False
    server.faults = {repository_path(APPLE): ["drop"]}
    _fetch(tmp_path, server)
    size = len(CONTENTS[APPLE])
    assert server.sent(repository_path(APPLE)) == [size // 2, size]
    assert _visible(tmp_path) == CONTENTS


def test_connection_that_always_drops(tmp_path: Path, server: RepositoryServer) -> None:
    """After four drops the fetch stops with one sentence; the next fetch goes on from there."""
    third = repository_path(sorted(NAMES)[2])
    server.faults = {third: ["drop*"]}
    pauses: list[float] = []
    with pytest.raises(RelightlabError, match=r"2 of 5 .*no connection to .* same command again"):
        _fetch(tmp_path, server, pauses)
    assert pauses == [0.5, 1.0, 2.0]
    assert set(_visible(tmp_path)) == set(sorted(NAMES)[:2])
    arrived = sum(server.sent(third))
    server.faults, server.requests[:] = {}, []
    assert _fetch(tmp_path, server).downloaded == 3
    (rest,) = server.sent(third)
    # Each of the four drops costs at most one piece.
    assert 0 <= arrived + rest - len(SERVED[third]) < 4 * PIECE


def test_missing_file_on_the_server(tmp_path: Path, server: RepositoryServer) -> None:
    """A file the server does not have is asked for once and named; the others arrive."""
    server.faults = {repository_path(APPLE): ["404*"]}
    with pytest.raises(RelightlabError, match=rf"4 of 5 .* {APPLE} \(the server answered 404"):
        _fetch(tmp_path, server)
    assert server.sent(repository_path(APPLE)) == [0]
    assert len(_visible(tmp_path)) == 4


def test_wrong_repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A server that has none of the files is given up after the fifth, not asked for all 521."""
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    with serving(RepositoryServer({}.get)) as empty:
        with pytest.raises(RelightlabError, match=r"^0 of 521 files"):
            fetch_mit_berkeley(tmp_path, accept_licence=True, base_url=empty.url)
        assert len(empty.requests) == 5


def test_server_in_trouble(tmp_path: Path, server: RepositoryServer) -> None:
    """A 503 is tried again, and stops the fetch at that file when it stays."""
    first = repository_path(min(NAMES))
    server.faults = {first: ["503"]}
    assert _fetch(tmp_path / "once", server).downloaded == 5
    server.faults, server.requests[:] = {first: ["503*"]}, []
    with pytest.raises(RelightlabError, match=r"0 of 5 .* 503 Service Unavailable"):
        _fetch(tmp_path / "always", server)
    assert {request.path for request in server.requests} == {first}
    assert len(server.requests) == 4


def test_no_server(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nothing answers, the fetch stops at the first file with a sentence naming the host."""
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    with socket.create_server(("127.0.0.1", 0)) as held:
        host = f"127.0.0.1:{held.getsockname()[1]}"
    pauses: list[float] = []
    with pytest.raises(RelightlabError, match=rf"0 of 5 .*no connection to {host}"):
        _fetch(tmp_path, RepositoryServer(SERVED.get, url=f"http://{host}"), pauses)
    assert len(pauses) == 3


@pytest.mark.parametrize("address", ["not an address", "http://"])
def test_wrong_address(tmp_path: Path, address: str) -> None:
    """An address that cannot be asked is told at once, without a second attempt."""
    pauses: list[float] = []
    with pytest.raises(RelightlabError, match="cannot be downloaded from"):
        _fetch(tmp_path, RepositoryServer(SERVED.get, url=address), pauses)
    assert pauses == []


@pytest.mark.parametrize("blocked", ["root", "root/mit-berkeley"])
def test_unwritable_output(tmp_path: Path, server: RepositoryServer, blocked: str) -> None:
    """Where a file stands in the folder's place, one sentence says it cannot be written."""
    (tmp_path / blocked).parent.mkdir(exist_ok=True)
    (tmp_path / blocked).write_text("a file")
    with pytest.raises(RelightlabError, match=r"cannot write into .*mit-berkeley"):
        _fetch(tmp_path / "root", server)
    assert (tmp_path / blocked).read_text() == "a file"


def test_full_disk(
    tmp_path: Path, server: RepositoryServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A disk that fills up is told in one sentence, and no file has its final name."""

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(RelightlabError, match=r"No space left on device; make room"):
        _fetch(tmp_path, server)
    assert _visible(tmp_path) == {}


def test_licence_not_accepted(tmp_path: Path, server: RepositoryServer) -> None:
    """Without consent the terms are shown, the server is not asked and nothing is written."""
    with pytest.raises(RelightlabError, match=r"Regents .* not-for-profit .* --accept-licence"):
        fetch_mit_berkeley(tmp_path, accept_licence=False, base_url=server.url, sha256=RECORDED)
    assert server.requests == []
    assert list(tmp_path.iterdir()) == []


def test_interrupted_within_a_file(
    tmp_path: Path, server: RepositoryServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An interruption within a file leaves whole files only, and the next fetch continues it."""
    pieces = requests.Response.iter_content
    broken_off = repository_path(sorted(NAMES)[1])

    def interrupted(answer: requests.Response, size: int) -> Iterator[bytes]:
        for piece in pieces(answer, size):
            yield piece
            if answer.url.endswith(broken_off):
                raise KeyboardInterrupt

    monkeypatch.setattr(requests.Response, "iter_content", interrupted)
    with pytest.raises(KeyboardInterrupt):
        _fetch(tmp_path, server)
    monkeypatch.setattr(requests.Response, "iter_content", pieces)
    first = min(NAMES)
    assert _visible(tmp_path) == {first: CONTENTS[first]}
    server.requests.clear()
    assert _fetch(tmp_path, server).downloaded == 4
    assert server.requests[0].range == f"bytes={PIECE}-"
    assert _visible(tmp_path) == CONTENTS


def test_interrupted_between_files(tmp_path: Path, server: RepositoryServer) -> None:
    """An interruption from the progress report keeps the files that are whole."""

    def interrupt(told: FetchProgress) -> None:
        if told.done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fetch_mit_berkeley(
            tmp_path, accept_licence=True, base_url=server.url, sha256=RECORDED, progress=interrupt
        )
    assert _visible(tmp_path) == {name: CONTENTS[name] for name in sorted(NAMES)[:2]}


def test_progress_counts_every_file(tmp_path: Path, server: RepositoryServer) -> None:
    """Progress is told once for each file, in order, whole files included."""
    for _ in range(2):
        told: list[FetchProgress] = []
        fetch_mit_berkeley(
            tmp_path,
            accept_licence=True,
            base_url=server.url,
            sha256=RECORDED,
            progress=told.append,
        )
        expected = [FetchProgress(name, k, 5) for k, name in enumerate(sorted(NAMES), start=1)]
        assert told == expected


def test_fetch_is_quiet(
    tmp_path: Path, server: RepositoryServer, capfd: pytest.CaptureFixture[str]
) -> None:
    """A fetch prints nothing itself and leaves the logging of pooch as it was."""
    level = pooch.get_logger().level
    _fetch(tmp_path, server)
    assert capfd.readouterr() == ("", "")
    assert pooch.get_logger().level == level != logging.WARNING


@pytest.mark.real_data
@pytest.mark.slow
def test_fetch_of_the_published_set(
    tmp_path: Path, mit_berkeley_root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The published set, served in its repository's layout, is fetched and verified in full."""
    names = {repository_path(name): name for name in mit_berkeley_files().sha256}

    def read(path: str) -> bytes | None:
        return (mit_berkeley_root / names[path]).read_bytes() if path in names else None

    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    with serving(RepositoryServer(read)) as published:
        report = fetch_mit_berkeley(tmp_path, accept_licence=True, base_url=published.url)
        assert (report.downloaded, len(published.requests)) == (521, 521)
        again = fetch_mit_berkeley(tmp_path, accept_licence=True, base_url=published.url)
        assert (again.downloaded, len(published.requests)) == (0, 521)
    verified = verify_mit_berkeley(tmp_path)
    assert (verified.whole, verified.complete, verified.extra) == (521, True, ())
