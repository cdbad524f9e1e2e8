"""Simulated observers who take part in a served study through its real HTTP interface."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import httpx

from shading_model.errors import RelightlabError
from studies.observers import Observer, ObserverModel
from studies.simulation import DISPLAY
from studies.stimulus_recognition import StimulusBook, pixel_digest, stimulus_book
from studies.study_records import Study

ATTEMPTS = 8
FIRST_WAIT_SECONDS = 0.05
TIMEOUT_SECONDS = 60.0
AGAIN = frozenset({429, 500, 502, 503, 504})
"""Answers of a server that is busy or down for a moment: the request is sent again."""
ALREADY = 409
"""A trial that has an answer: the first one stands."""


@dataclass(frozen=True)
class HttpSimulation:
    """What came of simulated sessions.

    Parameters
    ----------
    codes : mapping of str to str
        Completion code by subject, of those who finished.
    unfinished : tuple of str
        Subjects who stopped before the end, as the model says.
    acknowledged : mapping of (str, int) to str
        The response that the server acknowledged, by subject and trial.
    milliseconds : tuple of float
        From sending an answer to its acknowledgement.
    repeats : int
        Requests that had to be sent again.
    """

    codes: Mapping[str, str]
    unfinished: tuple[str, ...]
    acknowledged: Mapping[tuple[str, int], str]
    milliseconds: tuple[float, ...]
    repeats: int


def simulate_http(
    base_url: str,
    study: Study,
    subjects: int,
    model: ObserverModel | None = None,
    *,
    seed: int = 0,
    at_once: int = 20,
    transport: httpx.AsyncBaseTransport | None = None,
) -> HttpSimulation:
    """Let simulated observers take part in a study that is served for them.

    They open sessions, fetch the pictures, answer every trial and the questionnaire, and ask for
    the completion code, sending again what a busy server does not take. Run again with the same
    seed, each observer finds the session finished, and nothing changes.

    Parameters
    ----------
    base_url : str
        Where ``relightlab study serve --simulated`` listens.
    study : Study
        The one that is served, with its pictures.
    subjects : int
    model : ObserverModel, optional
    seed : int
    at_once : int
        Sessions under way at the same time.
    transport : httpx.AsyncBaseTransport, optional
        Instead of the network.

    Returns
    -------
    HttpSimulation

    Raises
    ------
    RelightlabError
        If the server does not answer, takes no simulated sessions, serves another study or refuses
        a request.
    """
    book = stimulus_book(study)
    population = [Observer(study, model or ObserverModel(), seed, n) for n in range(subjects)]
    return asyncio.run(_run(base_url, book, population, at_once, transport))


@dataclass
class _Log:
    codes: dict[str, str] = field(default_factory=dict)
    unfinished: list[str] = field(default_factory=list)
    acknowledged: dict[tuple[str, int], str] = field(default_factory=dict)
    milliseconds: list[float] = field(default_factory=list)
    repeats: int = 0


class _Connection:
    """Requests to one server, each repeated while the server is busy."""

    def __init__(self, client: httpx.AsyncClient, log: _Log) -> None:
        self.client = client
        self.log = log
        self._digests: dict[str, asyncio.Task[str]] = {}

    async def send(self, method: str, path: str, body: object = None) -> httpx.Response:
        """Return the response to a request that the server took."""
        reason = ""
        for attempt in range(ATTEMPTS):
            if attempt:
                self.log.repeats += 1
                await asyncio.sleep(FIRST_WAIT_SECONDS * 2**attempt)
            try:
                response = await self.client.request(method, path, json=body)
            except httpx.TransportError as error:
                reason = str(error) or type(error).__name__
                continue
            if response.status_code in AGAIN:
                reason = f"it answered {response.status_code}"
                continue
            if response.is_error and response.status_code != ALREADY:
                raise RelightlabError(f"the server refused {method} {path}: {_detail(response)}")
            return response
        raise RelightlabError(
            f"the server at {self.client.base_url} did not take {method} {path} in {ATTEMPTS}"
            f" attempts ({reason}): start it with 'relightlab study serve --simulated'"
        )

    async def digest(self, path: str) -> str:
        """Return the digest of a stimulus, fetched once."""
        if path not in self._digests:
            self._digests[path] = asyncio.ensure_future(self._fetch(path))
        return await self._digests[path]

    async def _fetch(self, path: str) -> str:
        return pixel_digest((await self.send("GET", path)).content)


async def _run(
    base_url: str,
    book: StimulusBook,
    population: list[Observer],
    at_once: int,
    transport: httpx.AsyncBaseTransport | None,
) -> HttpSimulation:
    log = _Log()
    limits = httpx.Limits(max_connections=at_once)
    turn = asyncio.Semaphore(at_once)
    try:
        client = httpx.AsyncClient(
            base_url=base_url, transport=transport, limits=limits, timeout=TIMEOUT_SECONDS
        )
    except httpx.InvalidURL as error:
        raise RelightlabError(f"expected an address like http://127.0.0.1:8000: {error}") from error
    async with client:
        connection = _Connection(client, log)
        await _check_server(connection, book.study)

        async def one(observer: Observer) -> None:
            async with turn:
                await _take_part(connection, book, observer)

        await asyncio.gather(*(one(observer) for observer in population))
    return HttpSimulation(
        log.codes, tuple(log.unfinished), log.acknowledged, tuple(log.milliseconds), log.repeats
    )


async def _check_server(connection: _Connection, study: Study) -> None:
    served = (await connection.send("GET", "api/study")).json()
    if served.get("mode") != "simulated":
        raise RelightlabError(
            f"the server at {connection.client.base_url} takes {served.get('mode')} answers, which"
            " simulated ones must not get among: start it with --simulated"
        )
    if served.get("name") != study.name:
        raise RelightlabError(
            f"the server at {connection.client.base_url} serves the study {served.get('name')!r},"
            f" expected {study.name!r}: give the file of the study that is served"
        )


async def _take_part(connection: _Connection, book: StimulusBook, observer: Observer) -> None:
    session = await _open(connection, observer)
    subject, place = str(session["subject"]), f"api/sessions/{session['token']}"
    pictures = [
        (await connection.digest(trial["left"]), await connection.digest(trial["right"]))
        for trial in session["schedule"]
    ]
    task, shown = book.recognise(pictures)
    answers = observer.answers(task, shown)
    for index in range(answers.stops_after):
        response = answers.response[index]
        await _answer(connection, place, index, response, float(answers.reaction_ms[index]))
        connection.log.acknowledged[subject, index] = response
    if answers.stops_after < len(shown):
        connection.log.unfinished.append(subject)
        return
    if session["status"] != "complete":
        body = {"answers": observer.questionnaire()}
        await connection.send("PUT", f"{place}/questionnaire", body)
    done = (await connection.send("POST", f"{place}/completion")).json()
    connection.log.codes[subject] = done["code"]


async def _open(connection: _Connection, observer: Observer) -> dict[str, Any]:
    # The same ids open the same session again, so that a run that was cut off can be repeated.
    parameters = observer.study.recruitment.id_parameters
    ids = dict.fromkeys(parameters, f"simulated-{observer.name}")
    width, height = DISPLAY.values()
    display = {"width": width, "height": height, "pixel_ratio": 1.0}
    body = {"ids": ids, "mode": "simulated", "display": display}
    session: dict[str, Any] = (await connection.send("POST", "api/sessions", body)).json()
    return session


async def _answer(
    connection: _Connection, place: str, index: int, response: str, reaction_ms: float
) -> None:
    body = {"response": response, "shown_ms": reaction_ms, "reaction_ms": reaction_ms}
    started = time.perf_counter()
    await connection.send("PUT", f"{place}/trials/{index}", body | {"blur_events": 0} | DISPLAY)
    connection.log.milliseconds.append(1000 * (time.perf_counter() - started))


def _detail(response: httpx.Response) -> str:
    try:
        detail = response.json()["detail"]
    except (ValueError, KeyError, TypeError):
        return f"it answered {response.status_code}"
    return str(detail)[:200]
