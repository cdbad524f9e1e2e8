"""Answers that the tests of the tables make up: fixed ones, and hypothesis strategies of any."""

from __future__ import annotations

from typing import Any

import pandas as pd
from hypothesis import strategies as st

from studies.tables import KINDS, MODES, STATUSES, StudyData

TEXTS = st.text(
    st.characters(exclude_categories=["Cs"], exclude_characters="\0"), min_size=1, max_size=12
)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
TIMES = st.datetimes().map(lambda moment: moment.isoformat() + "Z")


def subject_row(subject: str = "s1", **others: Any) -> dict[str, Any]:
    """A subject who has done everything."""
    fixed = {"study_hash": "0" * 64, "task": "real", "order": 0}
    return {"subject": subject, **fixed, "mode": "live", "status": "complete", **others}


def trial_row(subject: str = "s1", trial: int = 0, **others: Any) -> dict[str, Any]:
    """A main trial in which the target, on the left, was taken."""
    place = {"subject": subject, "task": "real", "kind": "main", "trial": trial}
    shown = {"position": trial + 1, "pair": f"pair-{trial}", "condition": "ours"}
    chosen = {"target_side": "left", "response": "left", "chose_target": 1.0}
    return {**place, **shown, **chosen, **others}


def answers(**of_subject: Any) -> StudyData:
    """The answers of one subject to two trials."""
    subjects = pd.DataFrame([subject_row(**of_subject)])
    return StudyData(subjects, pd.DataFrame([trial_row(), trial_row(trial=1)]))


@st.composite
def any_answers(draw: st.DrawFn) -> StudyData:
    """Any valid answers: texts of every kind, times, numbers, and gaps wherever they may be."""
    names = draw(st.lists(TEXTS, unique=True, max_size=3))
    subjects = [draw(_subject(name)) for name in names]
    trials = [
        draw(_trial(name, number)) for name in names for number in range(draw(st.integers(0, 2)))
    ]
    told = [
        {"subject": name, "question": question, "answer": draw(st.none() | TEXTS)}
        for name in names
        for question in draw(st.lists(TEXTS, unique=True, max_size=2))
    ]
    event = st.fixed_dictionaries({"event": TEXTS, "detail": st.none() | TEXTS, "at": TIMES})
    events = [
        {"subject": name, **draw(event)} for name in names for _ in range(draw(st.integers(0, 1)))
    ]
    return StudyData(*(pd.DataFrame(rows) for rows in (subjects, trials, told, events)))


def _subject(name: str) -> st.SearchStrategy[dict[str, Any]]:
    flag = st.none() | st.booleans()
    return st.fixed_dictionaries(
        {
            "subject": st.just(name),
            "study_hash": TEXTS,
            "task": TEXTS,
            "order": st.integers(-(2**53), 2**53),
            "mode": st.sampled_from(MODES),
            "status": st.sampled_from(STATUSES),
            "started": st.none() | TIMES,
            "gender": st.none() | TEXTS,
            "age": st.none() | NUMBERS,
            "expertise": flag,
            "passed_spheres": flag,
        }
    )


def _trial(name: str, number: int) -> st.SearchStrategy[dict[str, Any]]:
    sided = st.sampled_from(
        [("left", "left", 1.0), ("left", "right", 0.0), ("right", "tie", 0.5), (None, None, 1.0)]
    )
    rows = st.fixed_dictionaries(
        {
            "subject": st.just(name),
            "trial": st.just(number),
            "task": TEXTS,
            "kind": st.sampled_from(KINDS),
            "position": st.none() | st.integers(1, 20),
            "pair": TEXTS,
            "condition": TEXTS,
            "left": st.none() | TEXTS,
            "reaction_ms": st.none() | NUMBERS,
            "blur_events": st.none() | st.integers(0, 9),
            "answered": st.none() | TIMES,
        }
    )
    names = ("target_side", "response", "chose_target")
    return st.builds(lambda row, chosen: row | dict(zip(names, chosen, strict=True)), rows, sided)


def assert_same(first: StudyData, second: StudyData) -> None:
    """All four tables agree, in values, types, order and gaps."""
    for name in ("subjects", "trials", "questionnaires", "events"):
        pd.testing.assert_frame_equal(first.table(name), second.table(name))
