"""What the page is told of a study and of a session: enough to show it, nothing to guess by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from studies.schedules import ScheduledTrial
from studies.session_records import Session, iso, now
from studies.study_records import Study

_SETTINGS = (
    "question",
    "minimum_view_ms",
    "allow_tie",
    "minimum_width",
    "minimum_height",
    "allow_touch",
)


def study_document(study: Study) -> dict[str, Any]:
    """Return the texts and settings of a study that every subject may know.

    Parameters
    ----------
    study : Study

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> sorted(study_document(bare_study()))
    ['consent', 'id_parameters', 'instructions', 'name', 'questionnaire', 'settings', 'title']
    """
    return {
        "name": study.name,
        "title": study.title,
        "consent": study.consent,
        "instructions": study.instructions,
        "id_parameters": list(study.recruitment.id_parameters),
        "settings": {name: getattr(study.settings, name) for name in _SETTINGS},
        "questionnaire": [asdict(question) for question in study.questionnaire],
    }


def session_document(
    study: Study, session: Session, address: Callable[[str], str]
) -> dict[str, Any]:
    """Return a session as its subject's page gets it.

    The schedule says where the two pictures of each trial are. It does not say which is whose, nor
    which trials are there to tell who looks.

    Parameters
    ----------
    study : Study
    session : Session
    address : callable
        Where a stimulus is served.
    """
    questions = {pair.name: pair.question for pair in study.closing}
    return {
        "token": session.token,
        "subject": session.subject,
        "mode": session.mode,
        "status": session.status,
        "resumed": session.resumed,
        "study": study_document(study) | {"mode": session.mode},
        "schedule": [
            _trial(number, entry, address) | {"question": _question(study, questions, entry)}
            for number, entry in enumerate(session.schedule.entries)
        ],
        "answered": list(session.answered),
        "questionnaire_answered": bool(session.questionnaire) or not study.questionnaire,
        "server_time": iso(now()),
    }


def _trial(number: int, entry: ScheduledTrial, address: Callable[[str], str]) -> dict[str, Any]:
    part = "closing" if entry.kind == "closing" else "main"
    return {
        "index": number,
        "part": part,
        "left": address(entry.left),
        "right": address(entry.right),
    }


def _question(study: Study, questions: dict[str, str], entry: ScheduledTrial) -> str:
    own = questions.get(entry.pair, "") if entry.kind == "closing" else ""
    return own or study.settings.question
