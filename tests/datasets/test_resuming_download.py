"""The downloader that continues a file where it broke off."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import requests

from datasets.resuming_download import ResumingDownloader, UnusableAnswerError
from tests.datasets.repository_server import RepositoryServer, serving

CONTENT = bytes(range(256)) * 4


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[RepositoryServer]:
    """Serve one file of 1024 bytes."""
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    with serving(RepositoryServer({"file": CONTENT}.get)) as running:
        yield running


@pytest.fixture
def downloader(tmp_path: Path) -> Iterator[ResumingDownloader]:
    """Keep unfinished files in a folder that does not exist yet."""
    with requests.Session() as session:
        yield ResumingDownloader(session, tmp_path / "parts")


def _arrived(downloader: ResumingDownloader, url: str, part: bytes) -> Path:
    downloader.partial_folder.mkdir()
    path = downloader.partial_path(url)
    path.write_bytes(part)
    return path


@pytest.mark.parametrize("arrived", [0, 1, 511, 1023])
def test_resume_from_any_byte(
    tmp_path: Path, server: RepositoryServer, downloader: ResumingDownloader, arrived: int
) -> None:
    """Whatever part has arrived, exactly the rest is sent and the file is whole."""
    url = f"{server.url}/file"
    _arrived(downloader, url, CONTENT[:arrived])
    downloader(url, str(tmp_path / "out"), None)
    assert (tmp_path / "out").read_bytes() == CONTENT
    assert server.sent("file") == [1024 - arrived]
    assert list(downloader.partial_folder.iterdir()) == []


@pytest.mark.parametrize("length", [1024, 5000])
def test_part_that_is_too_long(
    tmp_path: Path, server: RepositoryServer, downloader: ResumingDownloader, length: int
) -> None:
    """A part as long as the file or longer is thrown away, and the next attempt starts anew."""
    url = f"{server.url}/file"
    part = _arrived(downloader, url, bytes(length))
    with pytest.raises(UnusableAnswerError, match=f"answered 416 to a request from byte {length}"):
        downloader(url, str(tmp_path / "out"), None)
    assert not part.exists()
    assert not (tmp_path / "out").exists()
    downloader(url, str(tmp_path / "out"), None)
    assert (tmp_path / "out").read_bytes() == CONTENT


def test_answer_of_another_range(
    tmp_path: Path, server: RepositoryServer, downloader: ResumingDownloader
) -> None:
    """An answer that starts at another byte than asked for is never joined to the part."""
    server.faults = {"file": ["wrong range"]}
    url = f"{server.url}/file"
    _arrived(downloader, url, CONTENT[:100])
    with pytest.raises(UnusableAnswerError, match="answered 206 to a request from byte 100"):
        downloader(url, str(tmp_path / "out"), None)
    downloader(url, str(tmp_path / "out"), None)
    assert (tmp_path / "out").read_bytes() == CONTENT


def test_refusal_keeps_the_part(
    tmp_path: Path, server: RepositoryServer, downloader: ResumingDownloader
) -> None:
    """A refusal of the server does not cost what has arrived."""
    server.faults = {"file": ["503"]}
    url = f"{server.url}/file"
    part = _arrived(downloader, url, CONTENT[:100])
    with pytest.raises(requests.HTTPError, match="503"):
        downloader(url, str(tmp_path / "out"), None)
    assert part.read_bytes() == CONTENT[:100]


def test_parts_of_different_addresses(downloader: ResumingDownloader) -> None:
    """Parts of files of the same name from different addresses do not meet."""
    one, two = (downloader.partial_path(f"http://{host}/file") for host in ("one", "two"))
    assert one != two
    assert one == downloader.partial_path("http://one/file")
