"""Answers to the closing questionnaire: held to its questions, and read as the subject's."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from shading_model.errors import RelightlabError, unknown_name
from studies.study_records import Question

Given = str | float | int | bool | None
YES = frozenset({"yes", "true", "1"})
NO = frozenset({"no", "false", "0"})


def checked_answers(questions: Sequence[Question], answers: Mapping[str, Given]) -> dict[str, str]:
    """Return the answers as texts, without the questions that were left open.

    Parameters
    ----------
    questions : sequence of Question
    answers : mapping of str to str or number or None
        By question; None and empty texts are no answer.

    Returns
    -------
    dict of str to str

    Raises
    ------
    RelightlabError
        If a question is unknown or required and left open, or an answer is not one of its options,
        a number outside its bounds, or too long.

    Examples
    --------
    >>> questions = [Question("age", "How old are you?", "number", minimum=18)]
    >>> checked_answers(questions, {"age": 31})
    {'age': '31'}
    >>> checked_answers(questions, {"age": "17"})
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: the answer to 'age' must be at least 18, got 17
    """
    known = {question.name: question for question in questions}
    for name in answers:
        if name not in known:
            raise unknown_name("question", name, known)
    texts = {name: _text(answer) for name, answer in answers.items()}
    given = {name: text for name, text in texts.items() if text.strip()}
    for question in questions:
        if question.name in given:
            _check(question, given[question.name])
        elif question.required:
            raise RelightlabError(f"the question {question.name!r} must be answered")
    return given


def subject_columns(answers: Mapping[str, str]) -> dict[str, Any]:
    """Return what the answers say about the subject: gender, age and expertise.

    Parameters
    ----------
    answers : mapping of str to str
        From `checked_answers`.

    Returns
    -------
    dict
        The three columns of the table of subjects; None where not answered.

    Examples
    --------
    >>> subject_columns({"gender": "Male", "age": "31", "expertise": "Yes"})
    {'gender': 'male', 'age': 31.0, 'expertise': True}
    """
    expertise = answers.get("expertise", "").strip().casefold()
    return {
        "gender": _gender(answers.get("gender", "")),
        "age": _number(answers.get("age", "")),
        "expertise": True if expertise in YES else False if expertise in NO else None,
    }


def _gender(answer: str) -> str | None:
    words = answer.strip().casefold()
    return None if not words or "not to say" in words else words


def _text(answer: Given) -> str:
    if isinstance(answer, bool):
        return "yes" if answer else "no"
    if isinstance(answer, float) and answer.is_integer():
        return str(int(answer))
    if isinstance(answer, float | int):
        return str(answer)
    return (answer or "").replace("\0", "")


def _check(question: Question, text: str) -> None:
    if question.kind == "choice" and text not in question.options:
        raise RelightlabError(
            f"the answer to {question.name!r} must be one of {', '.join(question.options)}"
        )
    if question.kind == "text" and len(text) > question.maximum_length:
        raise RelightlabError(
            f"the answer to {question.name!r} must have at most {question.maximum_length}"
            f" characters, got {len(text)}"
        )
    if question.kind == "number":
        _check_number(question, text)


def _check_number(question: Question, text: str) -> None:
    number = _number(text)
    if number is None:
        raise RelightlabError(f"the answer to {question.name!r} must be a number")
    if question.minimum is not None and number < question.minimum:
        raise RelightlabError(
            f"the answer to {question.name!r} must be at least {question.minimum:g}, got {number:g}"
        )
    if question.maximum is not None and number > question.maximum:
        raise RelightlabError(
            f"the answer to {question.name!r} must be at most {question.maximum:g}, got {number:g}"
        )


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) else None
