"""Download of the MIT-Berkeley set from its public repository: resumable, verified, whole.

The files come from one commit, each with a recorded SHA-256, so a set fetched today is the set
fetched in ten years.
"""

from __future__ import annotations

import logging
import shutil
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from http import HTTPStatus
from pathlib import Path
from urllib.parse import quote, urlsplit

import pooch
import requests

from datasets.catalogue import MIT_BERKELEY_LICENCE, mit_berkeley_files
from datasets.resuming_download import ResumingDownloader, UnusableAnswerError
from datasets.verification import verify_mit_berkeley
from shading_model.errors import RelightlabError

PARTIAL_FOLDER = ".unfinished-download"
"""Folder within the set's folder that keeps the parts of files that have arrived."""

ATTEMPTS = 4
FIRST_PAUSE = 0.5
MOST_FAILED_FILES = 5


@dataclass(frozen=True)
class FetchProgress:
    """How far a download has come, told after each file.

    Parameters
    ----------
    name : str
        The file that is now whole, or could not be fetched.
    done, total : int
        Files dealt with so far, and files of the set.
    """

    name: str
    done: int
    total: int


@dataclass(frozen=True)
class FetchReport:
    """What a complete download did.

    Parameters
    ----------
    folder : Path
        The set's folder, in which every file is whole.
    downloaded, already_there : int
        Files fetched now, and files that were whole before.
    """

    folder: Path
    downloaded: int
    already_there: int


@dataclass(frozen=True)
class _Failure:
    name: str
    reason: str
    # Whether the other files would fail likewise.
    general: bool


def repository_url() -> str:
    """Return the address of the set's repository at the recorded commit.

    Examples
    --------
    >>> repository_url().endswith("/bed9e590a18db1a56f057ee49cf05edeaa80ff9e")
    True
    """
    recorded = mit_berkeley_files()
    return f"https://raw.githubusercontent.com/{recorded.repository}/{recorded.commit}"


def repository_path(name: str) -> str:
    """Return where the repository keeps a file of the set.

    Examples
    --------
    >>> repository_path("MIT-Berkeley-Natural/apple/L.mat")
    'data/MIT-Berkeley-Natural/apple/L.mat'
    >>> repository_path("natural_lights.mat")
    'natural_lights.mat'
    """
    return f"data/{name}" if "/" in name else name


def fetch_mit_berkeley(
    root: Path,
    *,
    accept_licence: bool,
    base_url: str | None = None,
    sha256: Mapping[str, str] | None = None,
    progress: Callable[[FetchProgress], None] | None = None,
    pause: Callable[[float], None] = time.sleep,
) -> FetchReport:
    """Download the MIT-Berkeley set into ``root/mit-berkeley``, or complete it.

    Files that are whole are not downloaded again, a file that broke off is continued, and each
    gets its final name only when its SHA-256 is the recorded one. A dropped connection, a server
    in trouble and a damaged file are tried four times, with growing pauses.

    Parameters
    ----------
    root : Path
        A data root; made if it does not exist.
    accept_licence : bool
        Whether the user accepts `datasets.catalogue.MIT_BERKELEY_LICENCE`.
    base_url : str, optional
        Where the repository's tree is served; `repository_url` by default.
    sha256 : mapping of str to str, optional
        SHA-256 by relative name; those of the published set by default.
    progress : callable, optional
        Called after each file.
    pause : callable
        Waits the given seconds before a new attempt.

    Raises
    ------
    RelightlabError
        If the licence is not accepted, a file cannot be written, or files could not be fetched
        (named, with the reason; running again resumes).

    Examples
    --------
    >>> fetch_mit_berkeley(Path("data"), accept_licence=False)
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: The MIT-Berkeley intrinsic images are copyright of ...
    """
    if not accept_licence:
        raise RelightlabError(
            f"{MIT_BERKELEY_LICENCE} If you accept these terms, run again with --accept-licence."
        )
    folder = root / "mit-berkeley"
    recorded = dict(mit_berkeley_files().sha256 if sha256 is None else sha256)
    source = _source(folder, (base_url or repository_url()).rstrip("/"), recorded)
    whole_before = verify_mit_berkeley(root, sha256=recorded).whole
    with requests.Session() as session, _quiet_pooch():
        downloader = ResumingDownloader(session, folder / PARTIAL_FOLDER)
        failures = _fetch_all(source, downloader, progress, pause)
    if failures:
        raise _incomplete(root, recorded, failures)
    shutil.rmtree(folder / PARTIAL_FOLDER, ignore_errors=True)
    return FetchReport(folder, len(recorded) - whole_before, whole_before)


def _source(folder: Path, base_url: str, recorded: Mapping[str, str]) -> pooch.Pooch:
    urls = {name: f"{base_url}/{quote(repository_path(name))}" for name in recorded}
    return pooch.create(path=folder, base_url=base_url, registry=dict(recorded), urls=urls)


def _fetch_all(
    source: pooch.Pooch,
    downloader: ResumingDownloader,
    progress: Callable[[FetchProgress], None] | None,
    pause: Callable[[float], None],
) -> list[_Failure]:
    """Return the failures; stop early where the other files would fail likewise."""
    failures: list[_Failure] = []
    names = sorted(source.registry)
    for done, name in enumerate(names, start=1):
        failure = _fetch_file(source, name, downloader, pause)
        if failure is not None:
            failures.append(failure)
            if failure.general or len(failures) == MOST_FAILED_FILES:
                break
        if progress is not None:
            progress(FetchProgress(name, done, len(names)))
    return failures


def _fetch_file(
    source: pooch.Pooch,
    name: str,
    downloader: ResumingDownloader,
    pause: Callable[[float], None],
) -> _Failure | None:
    failure = None
    for attempt in range(ATTEMPTS):
        if attempt:
            pause(FIRST_PAUSE * 2 ** (attempt - 1))
        try:
            source.fetch(name, downloader=downloader)
        except requests.RequestException as error:
            failure = _connection_failure(name, source.get_url(name), error)
            if not _may_pass(error):
                return failure
        except ValueError:
            # How pooch tells that the SHA-256 is another; it has removed the file.
            failure = _Failure(
                name, "its content does not have the recorded SHA-256", general=False
            )
        except OSError as error:
            raise RelightlabError(
                f"cannot write into {source.abspath}: {error.strerror or error}; make room or"
                " choose another data root, then run again: whole files are kept"
            ) from error
        else:
            return None
    return failure


def _may_pass(error: requests.RequestException) -> bool:
    """Return whether a new attempt makes sense."""
    if isinstance(error, requests.HTTPError) and error.response is not None:
        status = error.response.status_code
        return (
            status in {HTTPStatus.REQUEST_TIMEOUT, HTTPStatus.TOO_MANY_REQUESTS}
            or status >= HTTPStatus.INTERNAL_SERVER_ERROR
        )
    dropped = requests.exceptions.ChunkedEncodingError
    return isinstance(error, requests.ConnectionError | requests.Timeout | dropped)


def _connection_failure(name: str, url: str, error: requests.RequestException) -> _Failure:
    if isinstance(error, requests.HTTPError) and error.response is not None:
        answer = f"{error.response.status_code} {error.response.reason}".strip()
        return _Failure(name, f"the server answered {answer}", general=_may_pass(error))
    if isinstance(error, UnusableAnswerError):
        return _Failure(name, str(error), general=False)
    if _may_pass(error):
        host = urlsplit(url).netloc
        return _Failure(name, f"no connection to {host} could be made or kept", general=True)
    return _Failure(name, f"{url} cannot be downloaded from", general=True)


def _incomplete(
    root: Path, recorded: Mapping[str, str], failures: list[_Failure]
) -> RelightlabError:
    whole = verify_mit_berkeley(root, sha256=recorded).whole
    reasons = ", ".join(f"{failure.name} ({failure.reason})" for failure in failures)
    return RelightlabError(
        f"{whole} of {len(recorded)} files of the MIT-Berkeley set are whole in"
        f" {root / 'mit-berkeley'}, but the download failed at {reasons}: run the same command"
        " again to go on where it stopped"
    )


@contextmanager
def _quiet_pooch() -> Iterator[None]:
    """Keep pooch from logging a line per file: the caller reports progress."""
    logger = pooch.get_logger()
    level = logger.level
    logger.setLevel(logging.WARNING)
    try:
        yield
    finally:
        logger.setLevel(level)
