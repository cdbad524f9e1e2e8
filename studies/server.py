"""The web server of a study: its page, its stimuli, and the interface that takes the answers.

An answer is acknowledged after it is on disk. Whoever has a session's token is its subject; the
server tells nobody which picture is whose, and keeps no address.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import HTMLResponse, JSONResponse, Response
from fastapi.staticfiles import StaticFiles
from sqlalchemy.exc import SQLAlchemyError

from shading_model.errors import RelightlabError
from studies.questionnaire_answers import checked_answers
from studies.request_limits import UNLIMITED, Guard, RequestLimits
from studies.request_schemas import (
    AnswerSchema,
    CompletionSchema,
    EventSchema,
    OpeningSchema,
    QuestionnaireSchema,
)
from studies.response_store import ResponseStore
from studies.served_stimuli import ServedStimuli
from studies.session_documents import session_document, study_document
from studies.session_records import RefusedError, UnknownSessionError, UnknownTrialError
from studies.study_records import Study

_log = logging.getLogger(__name__)

RETRY_SECONDS = "1"
"""What a client waits before it sends again what a busy or full database did not take."""


def make_app(
    study: Study,
    store: ResponseStore,
    *,
    mode: str = "live",
    page: Path | None = None,
    limits: RequestLimits | None = None,
    require_ids: bool = True,
) -> FastAPI:
    """Return the server of a study as an ASGI application.

    Parameters
    ----------
    study : Study
    store : ResponseStore
    mode : {'live', 'pilot', 'simulated'}
        Of its sessions. A live server also opens pilot sessions; only a simulated one opens
        simulated ones, and no others.
    page : Path, optional
        Folder of the built page; without it only the interface is served.
    limits : RequestLimits, optional
        By default those for people; none of rate for simulated subjects.
    require_ids : bool
        Whether a live session needs the ids that the study's recruitment names.

    Returns
    -------
    FastAPI
    """
    app = FastAPI(title=study.title, docs_url=None, redoc_url=None, openapi_url=None)
    stimuli = ServedStimuli(study, store.key)
    _add_faults(app)
    _add_openings(app, study, store, stimuli, _ModeRule(mode), require_ids=require_ids)
    _add_answers(app, study, store)
    _add_files(app, stimuli, page)
    usual = UNLIMITED if mode == "simulated" else RequestLimits()
    app.add_middleware(Guard, limits=limits or usual)
    return app


class _ModeError(RelightlabError):
    """A mode that this server does not open sessions in."""


class _ModeRule:
    def __init__(self, served: str) -> None:
        self.served = served

    def of(self, asked: str | None) -> str:
        """Return the mode of a new session; nobody can make one count more than the server's."""
        if (asked == "simulated") != (self.served == "simulated") and asked is not None:
            raise _ModeError(
                f"this server opens {self.served} sessions: expected no other mode, got {asked}"
            )
        return "pilot" if asked == "pilot" else self.served


def _add_openings(
    app: FastAPI,
    study: Study,
    store: ResponseStore,
    stimuli: ServedStimuli,
    rule: _ModeRule,
    *,
    require_ids: bool,
) -> None:
    @app.get("/api/study")
    def describe() -> dict[str, Any]:
        return study_document(study) | {"mode": rule.served}

    @app.post("/api/sessions")
    def open_session(opening: OpeningSchema) -> dict[str, Any]:
        mode = rule.of(opening.mode)
        needed = study.recruitment.id_parameters if require_ids and mode == "live" else ()
        missing = [parameter for parameter in needed if not opening.ids.get(parameter)]
        if missing:
            raise RelightlabError(
                f"the link lacks {', '.join(missing)}: open the study by the link you were given"
            )
        session = store.open_session(study, opening.ids, mode, opening.window())
        return session_document(study, session, stimuli.address)

    @app.get("/api/sessions/{token}")
    def resume(token: str) -> dict[str, Any]:
        session = store.session(token)
        if session.study_hash != study.hash:
            raise RefusedError("the study was changed since you began: you cannot go on")
        return session_document(study, session, stimuli.address)


def _add_answers(app: FastAPI, study: Study, store: ResponseStore) -> None:
    @app.put("/api/sessions/{token}/trials/{trial}")
    def record(token: str, trial: int, body: AnswerSchema) -> JSONResponse:
        if body.response == "tie" and not study.settings.allow_tie:
            raise _UnfitError("expected the answer left or right, got tie")
        done = store.record(token, trial, body.answer())
        content: dict[str, Any] = {"trial": done.trial, "state": done.state}
        if done.state == "kept-first":
            content["detail"] = "the trial has another answer already, which stands"
            return JSONResponse(content, 409)
        return JSONResponse(content)

    @app.post("/api/sessions/{token}/events")
    def note(token: str, body: EventSchema) -> dict[str, bool]:
        return {"stored": store.record_event(token, body.event, body.detail, body.key)}

    @app.put("/api/sessions/{token}/questionnaire")
    def answer_questions(token: str, body: QuestionnaireSchema) -> dict[str, str]:
        try:
            answers = checked_answers(study.questionnaire, body.answers)
        except RelightlabError as error:
            raise _UnfitError(str(error)) from error
        return {"state": "stored" if store.record_questionnaire(token, answers) else "repeated"}

    @app.post("/api/sessions/{token}/completion")
    def complete(token: str, _body: CompletionSchema | None = None) -> dict[str, str]:
        required = [question.name for question in study.questionnaire if question.required]
        code = store.finish(token, required)
        return {"code": code, "redirect": study.recruitment.completion_url.replace("{code}", code)}


def _add_files(app: FastAPI, stimuli: ServedStimuli, page: Path | None) -> None:
    @app.get("/healthz")
    def healthy() -> dict[str, bool]:
        return {"ok": True}

    @app.get("/stimuli/{name}")
    def stimulus(name: str) -> Response:
        content = stimuli.content(name)
        if content is None:
            return JSONResponse({"detail": "there is no such stimulus"}, 404)
        headers = {"Cache-Control": "private, max-age=86400, immutable"}
        return Response(content, media_type="image/png", headers=headers)

    if page is not None:
        markup = (page / "index.html").read_text(encoding="utf-8")

        @app.get("/", response_class=HTMLResponse)
        def index() -> HTMLResponse:
            return HTMLResponse(markup, headers={"Cache-Control": "no-cache"})

        app.mount("/static", _PageFiles(directory=page))


class _PageFiles(StaticFiles):
    """The page's files, which a browser compares with the server's before it uses its own copy.

    After an upgrade the page names the hashes of the new ones, and an old one would not run.
    """

    def file_response(self, *args: Any, **options: Any) -> Response:
        response = super().file_response(*args, **options)
        response.headers["Cache-Control"] = "no-cache"
        return response


class _UnfitError(RelightlabError):
    """A well-formed body with a value that the study does not allow."""


_STATUS: tuple[tuple[type[RelightlabError], int], ...] = (
    (UnknownSessionError, 404),
    (UnknownTrialError, 404),
    (RefusedError, 409),
    (_ModeError, 403),
    (_UnfitError, 422),
    (RelightlabError, 400),
)


def _add_faults(app: FastAPI) -> None:
    handlers: dict[type[Exception], Callable[[Request, Any], JSONResponse]] = {
        RelightlabError: _told,
        RequestValidationError: _unfit,
        SQLAlchemyError: _unavailable,
    }
    for kind, handler in handlers.items():
        app.add_exception_handler(kind, handler)


def _told(_request: Request, error: RelightlabError) -> JSONResponse:
    status = next(status for kind, status in _STATUS if isinstance(error, kind))
    content: dict[str, Any] = {"detail": str(error)}
    if isinstance(error, RefusedError) and (error.missing or error.questions):
        content |= {"missing": error.missing, "questions": error.questions}
    return JSONResponse(content, status)


def _unfit(_request: Request, error: RequestValidationError) -> JSONResponse:
    # Where and what was expected, never the value: it is the client's, and may be anything.
    first = error.errors()[0]
    place = ".".join(str(part) for part in first["loc"])
    return JSONResponse({"detail": f"{place[:200]}: {first['msg']}"}, 422)


def _unavailable(_request: Request, error: SQLAlchemyError) -> JSONResponse:
    # Only what the database says: statements hold answers.
    _log.warning("the database refused: %s", getattr(error, "orig", type(error).__name__))
    sentence = "the database does not take this now: send it again"
    return JSONResponse({"detail": sentence}, 503, {"Retry-After": RETRY_SECONDS})
