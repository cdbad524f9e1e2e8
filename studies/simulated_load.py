"""Many subjects at once, through the real HTTP interface: how long posts take, and what is lost.

A subject here answers at random, sends some answers twice, and insists like the page does: what is
not acknowledged is sent again. What was acknowledged is compared with what is stored afterwards.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import httpx
import numpy as np

from shading_model.errors import RelightlabError
from shading_model.seeds import generator_for
from studies.completion_codes import completion_codes
from studies.secret_key import SecretKey
from studies.tables import StudyData

TEMPORARY = frozenset({429, 502, 503, 504})
DOUBLED_SHARE = 0.1
"""Share of answers that a subject sends twice."""
_FIRST_DELAY, _LONGEST_DELAY = 0.05, 1.0


@dataclass(frozen=True)
class LoadPlan:
    """Who comes, and how quickly they answer.

    Parameters
    ----------
    subjects : int
        All at once.
    think_seconds : float
        Mean time from one acknowledgement to the next answer; it varies by half to either side.
    seed : int
    patience_seconds : float
        How long a subject insists on one request.
    """

    subjects: int = 200
    think_seconds: float = 2.0
    seed: int = 0
    patience_seconds: float = 60.0


@dataclass
class SubjectLog:
    """What one subject has in hand at the end."""

    subject: str = ""
    acknowledged: dict[int, str] = field(default_factory=dict)
    milliseconds: list[float] = field(default_factory=list)
    repeats: int = 0
    code: str = ""


@dataclass(frozen=True)
class LoadResult:
    """What the subjects have in hand, held against what is stored.

    Parameters
    ----------
    subjects, posts : int
        Subjects who finished, and acknowledged posts of answers.
    repeats : int
        Requests that had to be sent again.
    seconds : float
        From the first request to the last.
    p50_ms, p95_ms, p99_ms : float
        Quantiles of the time from sending an answer to its acknowledgement.
    lost : int
        Acknowledged answers that are not stored as they were given.
    doubled : int
        Answers stored more than once, or that nobody gave.
    wrong_codes : int
        Completion codes that do not fit what is stored.
    """

    subjects: int
    posts: int
    repeats: int
    seconds: float
    p50_ms: float
    p95_ms: float
    p99_ms: float
    lost: int
    doubled: int
    wrong_codes: int


def run_load(address: str, plan: LoadPlan) -> tuple[list[SubjectLog], float]:
    """Let all subjects do the study at once; return their logs, and the seconds it took.

    Parameters
    ----------
    address : str
        Of a server of simulated sessions.
    plan : LoadPlan

    Raises
    ------
    RelightlabError
        If the server refuses what a subject sends, or does not answer for too long.
    """
    started = time.monotonic()
    logs = asyncio.run(_all_subjects(address, plan))
    return logs, time.monotonic() - started


def judge_load(
    logs: list[SubjectLog], seconds: float, data: StudyData, key: SecretKey
) -> LoadResult:
    """Return what the subjects have in hand, held against what is stored.

    Parameters
    ----------
    logs : list of SubjectLog
    seconds : float
    data : StudyData
        Everything the store holds of these subjects, and of no others.
    key : SecretKey
        The store's.
    """
    trials = data.trials
    stored = dict(
        zip(zip(trials["subject"], trials["trial"], strict=True), trials["response"], strict=True)
    )
    given = {(log.subject, trial): r for log in logs for trial, r in log.acknowledged.items()}
    codes = completion_codes(key, data)
    milliseconds = [one for log in logs for one in log.milliseconds] or [np.nan]
    p50, p95, p99 = np.percentile(milliseconds, [50, 95, 99])
    return LoadResult(
        subjects=sum(bool(log.code) for log in logs),
        posts=len(milliseconds),
        repeats=sum(log.repeats for log in logs),
        seconds=seconds,
        p50_ms=float(p50),
        p95_ms=float(p95),
        p99_ms=float(p99),
        lost=sum(stored.get(which) != response for which, response in given.items()),
        doubled=len(trials) - len(stored) + len(stored.keys() - given.keys()),
        wrong_codes=sum(codes.get(log.subject) != log.code for log in logs),
    )


async def _all_subjects(address: str, plan: LoadPlan) -> list[SubjectLog]:
    context = httpx.create_ssl_context()  # made once: it takes longer than a whole session
    return list(
        await asyncio.gather(
            *(_subject(address, plan, number, context) for number in range(plan.subjects))
        )
    )


async def _subject(address: str, plan: LoadPlan, number: int, context: Any) -> SubjectLog:
    generator = generator_for("load", plan.seed, number)
    log = SubjectLog()

    async def insist(send: Callable[[], Awaitable[httpx.Response]]) -> dict[str, Any]:
        return await _insist(send, plan.patience_seconds, log, generator)

    limits = httpx.Limits(max_connections=2)
    async with httpx.AsyncClient(
        base_url=address, timeout=15.0, verify=context, limits=limits
    ) as client:
        session = await insist(lambda: client.post("api/sessions", json={"mode": "simulated"}))
        log.subject, place = session["subject"], f"api/sessions/{session['token']}"
        for trial in session["schedule"]:
            await asyncio.sleep(plan.think_seconds * generator.uniform(0.5, 1.5))
            body = _random_answer(generator)
            for _ in range(1 + int(generator.random() < DOUBLED_SHARE)):
                await _send_answer(client, f"{place}/trials/{trial['index']}", body, insist, log)
            log.acknowledged[trial["index"]] = body["response"]
        answers = _any_answers(session["study"]["questionnaire"])
        await insist(lambda: client.put(f"{place}/questionnaire", json={"answers": answers}))
        done = await insist(lambda: client.post(f"{place}/completion", json={}))
        log.code = done["code"]
    return log


async def _send_answer(
    client: httpx.AsyncClient,
    path: str,
    body: Mapping[str, Any],
    insist: Callable[[Callable[[], Awaitable[httpx.Response]]], Awaitable[dict[str, Any]]],
    log: SubjectLog,
) -> None:
    async def send() -> httpx.Response:
        started = time.perf_counter()
        response = await client.put(path, json=body)
        if response.is_success:
            log.milliseconds.append(1000.0 * (time.perf_counter() - started))
        return response

    await insist(send)


async def _insist(
    send: Callable[[], Awaitable[httpx.Response]],
    patience: float,
    log: SubjectLog,
    generator: np.random.Generator,
) -> dict[str, Any]:
    until = time.monotonic() + patience
    delay = _FIRST_DELAY
    while True:
        try:
            response = await send()
        except httpx.TransportError as error:
            reason = str(error) or type(error).__name__
        else:
            if response.is_success:
                content: dict[str, Any] = response.json()
                return content
            reason = f"{response.status_code} {response.text[:200]}"
            if response.status_code not in TEMPORARY:
                raise RelightlabError(f"the server refused what a simulated subject sent: {reason}")
        if time.monotonic() > until:
            raise RelightlabError(f"the server did not take an answer for {patience:g} s: {reason}")
        log.repeats += 1
        await asyncio.sleep(delay * generator.uniform(0.75, 1.25))
        delay = min(2.0 * delay, _LONGEST_DELAY)


def _random_answer(generator: np.random.Generator) -> dict[str, Any]:
    reaction = float(np.round(generator.uniform(500.0, 5000.0), 1))
    return {
        "response": "left" if generator.random() < 0.5 else "right",
        "shown_ms": reaction,
        "reaction_ms": reaction,
        "blur_events": 0,
        "display_width": 1280.0,
        "display_height": 720.0,
    }


def _any_answers(questions: list[dict[str, Any]]) -> dict[str, str | float]:
    return {question["name"]: _any_answer(question) for question in questions}


def _any_answer(question: Mapping[str, Any]) -> str | float:
    if question["kind"] == "choice":
        return str(question["options"][0])
    if question["kind"] == "number":
        return float(question["minimum"] or question["maximum"] or 0.0)
    return "none"
