"""Tests of result files of MTurk-style batches."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from shading_model.errors import RelightlabError
from studies.mturk_batches import read_mturk
from studies.secret_key import SecretKey
from studies.tables import StudyData

KEY = SecretKey(bytes(32))


def assignment(number: int, worker: str = "AWORKER", **others: Any) -> dict[str, Any]:
    """A row of a batch with one pair."""
    times = {
        "AcceptTime": "Tue Nov 24 10:12:33 PST 2026",
        "SubmitTime": f"Tue Nov 24 10:{20 + number}:00 PST 2026",
    }
    pair = {"Input.pair": f"p{number}", "Input.target_side": "left", "Answer.choice": "left"}
    ids = {"HITId": f"H{number}", "AssignmentId": f"{worker}-{number}", "WorkerId": worker}
    return {**ids, "AssignmentStatus": "Approved", **times, **pair, **others}


def read(tmp_path: Path, *rows: dict[str, Any], key: SecretKey = KEY) -> StudyData:
    """The answers of a batch with these rows."""
    path = tmp_path / "batch.csv"
    pd.DataFrame(rows).to_csv(path, index=False)
    return read_mturk(path, "lab", key)


def test_trials_are_in_the_order_of_submission(tmp_path: Path) -> None:
    """A worker's trials are numbered by time, whatever the order of rows, times being UTC."""
    data = read(tmp_path, assignment(2), assignment(1), assignment(1, "B"))
    mine = data.trials[data.trials["subject"] == data.subjects["subject"][0]]
    assert mine["pair"].tolist() == ["p1", "p2"]
    assert mine["position"].tolist() == [1.0, 2.0]
    assert mine["answered"].tolist() == ["2026-11-24T18:21:00Z", "2026-11-24T18:22:00Z"]
    assert data.subjects["started"][0] == "2026-11-24T18:12:33Z"


def test_an_assignment_may_hold_a_whole_session(tmp_path: Path) -> None:
    """Numbered columns are trials in their order, each of its kind and condition."""
    row = assignment(1)
    for number, (kind, side, choice) in enumerate(
        [("qualification", "A", "B"), ("main", "right", "tie"), ("closing", "left", "a")], start=1
    ):
        row |= {f"Input.kind_{number}": kind, f"Input.target_side_{number}": side}
        row |= {f"Answer.choice_{number}": choice, f"Input.pair_{number}": "spheres"}
        row |= {f"Answer.reaction_ms_{number}": 100 * number}
    for name in ("Input.pair", "Input.target_side", "Answer.choice"):
        del row[name]
    data = read(tmp_path, row)
    assert data.trials["kind"].tolist() == ["qualification", "main", "closing"]
    assert data.trials["chose_target"].tolist() == [0.0, 0.5, 1.0]
    assert data.trials["reaction_ms"].tolist() == [100.0, 200.0, 300.0]
    assert data.subjects["passed_spheres"].tolist() == [True]


def test_other_answers_are_the_questionnaire(tmp_path: Path) -> None:
    """Age, gender and expertise become the subject's; once is enough for several assignments."""
    told = {"Answer.age": "31", "Answer.gender": "female", "Answer.expertise": "Yes"}
    data = read(tmp_path, assignment(1, **told), assignment(2))
    (subject,) = data.subjects[["age", "gender", "expertise"]].to_numpy().tolist()
    assert subject == [31.0, "female", True]
    assert len(data.questionnaires) == 3


def test_answers_in_json_are_the_same(tmp_path: Path) -> None:
    """The platform's own form elements give the same answers as columns."""
    form = {"choice": {"left": False, "right": True}, "age": "31"}
    row = assignment(1) | {"Answer.taskAnswers": json.dumps([form])}
    del row["Answer.choice"]
    plain = read(tmp_path, assignment(1, **{"Answer.choice": "right", "Answer.age": "31"}))
    got = read(tmp_path, row)
    pd.testing.assert_frame_equal(got.trials, plain.trials)
    pd.testing.assert_frame_equal(got.questionnaires, plain.questionnaires)


def test_ids_are_hashed_with_the_key(tmp_path: Path) -> None:
    """No table holds a worker's id, and the name of a subject cannot be made without the key."""
    first = read(tmp_path, assignment(1))
    other = read(tmp_path, assignment(1), key=SecretKey(bytes([1] * 32)))
    assert first.subjects["subject"][0] != other.subjects["subject"][0]
    for name in ("subjects", "trials", "questionnaires"):
        assert "AWORKER" not in first.table(name).to_csv()


def test_one_rejection_makes_a_worker_returned(tmp_path: Path) -> None:
    """A worker one of whose assignments was rejected is not complete."""
    rejected = assignment(2, AssignmentStatus="Rejected")
    data = read(tmp_path, assignment(1), rejected, assignment(3), assignment(1, "B"))
    assert data.subjects["status"].tolist() == ["returned", "complete"]


def test_an_assignment_listed_twice_counts_once(tmp_path: Path) -> None:
    """Two downloads pasted together give no answer twice."""
    assert len(read(tmp_path, assignment(1), assignment(1)).trials) == 1


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"Answer.choice": "middle"}, "expected one of left, right, A, B, a, b, tie"),
        ({"Input.target_side": ""}, "holds nothing in the column 'Input.target_side' of row 1"),
        ({"AssignmentStatus": "Lost"}, "expected one of Submitted, Approved, Rejected"),
        (
            {"SubmitTime": "noon"},
            "holds 'noon' in the column 'SubmitTime' of row 1: expected a time",
        ),
        ({"Answer.taskAnswers": "{}"}, "what is not a list of one JSON object"),
        ({"Answer.taskAnswers": "[1]"}, "what is not a list of one JSON object"),
    ],
)
def test_wrong_cells_are_told(tmp_path: Path, wrong: dict[str, str], sentence: str) -> None:
    """A cell that is not as the platform writes it is one sentence with its place."""
    with pytest.raises(RelightlabError) as told:
        read(tmp_path, assignment(1, **wrong))
    assert sentence in str(told.value)


@pytest.mark.parametrize(
    ("column", "sentence"),
    [
        ("WorkerId", "lacks the column WorkerId: it has HITId, AssignmentId"),
        ("Answer.choice", "has no column of choices: expected Answer.choice, or Answer.choice_1"),
        ("Input.pair", "lacks the column Input.pair"),
    ],
)
def test_missing_columns_are_told(tmp_path: Path, column: str, sentence: str) -> None:
    """A batch without a needed column is one sentence."""
    row = assignment(1)
    del row[column]
    with pytest.raises(RelightlabError) as told:
        read(tmp_path, row)
    assert sentence in str(told.value)


def test_contradicting_answers_of_a_worker_are_told(tmp_path: Path) -> None:
    """A worker cannot have two ages."""
    first, second = (assignment(n, **{"Answer.age": str(30 + n)}) for n in (1, 2))
    with pytest.raises(RelightlabError, match="says otherwise about a subject in row 2"):
        read(tmp_path, first, second)
