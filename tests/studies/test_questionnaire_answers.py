"""Answers to the questionnaire: held to the questions, and read as the subject's."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shading_model.errors import RelightlabError
from studies.questionnaire_answers import checked_answers, subject_columns
from studies.study_records import Question

QUESTIONS = (
    Question("gender", "?", "choice", ("Female", "Male")),
    Question("age", "?", "number", minimum=18, maximum=120),
    Question("comment", "?", "text", maximum_length=10, required=True),
)


def test_open_questions_are_left_out() -> None:
    """None, empty and blank texts are no answer, and numbers become texts."""
    given = {"gender": None, "age": 31.0, "comment": "fine"}
    assert checked_answers(QUESTIONS, given) == {"age": "31", "comment": "fine"}
    assert checked_answers(QUESTIONS, {"gender": " ", "age": "", "comment": "x"}) == {
        "comment": "x"
    }


@pytest.mark.parametrize(
    ("answers", "said"),
    [
        ({"comment": ""}, "'comment' must be answered"),
        ({"comment": "x" * 11}, "at most 10 characters, got 11"),
        ({"comment": "x", "age": "nan"}, "must be a number"),
        ({"comment": "x", "age": "inf"}, "must be a number"),
        ({"comment": "x", "age": 17.5}, r"at least 18, got 17\.5"),
        ({"comment": "x", "age": 121}, "at most 120, got 121"),
        ({"comment": "x", "gender": "female"}, "one of Female, Male"),
        ({"comment": "x", "agee": 1}, "Did you mean 'age'"),
    ],
)
def test_what_the_study_does_not_allow_is_told(answers: dict[str, Any], said: str) -> None:
    """An answer outside its question is told in a sentence that names the question."""
    with pytest.raises(RelightlabError, match=said):
        checked_answers(QUESTIONS, answers)


@given(number=st.floats(18, 120) | st.integers(18, 120))
def test_numbers_come_back(number: float) -> None:
    """A number within its bounds is read as the subject's age as it was given."""
    answers = checked_answers(QUESTIONS, {"comment": "x", "age": number})
    assert subject_columns(answers)["age"] == number


@pytest.mark.parametrize(
    ("answers", "columns"),
    [
        ({}, (None, None, None)),
        ({"gender": "Female", "age": "20", "expertise": "No"}, ("female", 20.0, False)),
        ({"gender": "I prefer not to say", "expertise": "yes"}, (None, None, True)),
        ({"gender": "Another", "age": "old", "expertise": "a little"}, ("another", None, None)),
    ],
)
def test_the_subjects_columns_are_read(
    answers: dict[str, str], columns: tuple[str | None, float | None, bool | None]
) -> None:
    """Gender in small letters, age as a number, expertise as yes or no; else not known."""
    assert tuple(subject_columns(answers).values()) == columns
