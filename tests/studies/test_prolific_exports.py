"""Tests of the demographic files of Prolific."""

from __future__ import annotations

from pathlib import Path

import pytest

from shading_model.errors import RelightlabError
from studies.prolific_exports import join_prolific, read_prolific
from studies.response_store import ResponseStore
from studies.study_records import Study
from tests.studies.test_published_sets import written

HEADER = "Submission id,Participant id,Status,Age,Sex\n"
ROWS = "s0,p0,APPROVED,31,Female\ns1,p1,RETURNED,DATA_EXPIRED,Male\ns9,p9,APPROVED,40,Male\n"


def opened(store: ResponseStore, study: Study, number: int) -> str:
    """The token of a session that a participant opened by the panel's link."""
    ids = {"PROLIFIC_PID": f"p{number}", "STUDY_ID": "77", "SESSION_ID": f"s{number}"}
    return store.open_session(study, ids).token


def test_a_join_fills_in_and_repeats_to_nothing(
    store: ResponseStore, study: Study, tmp_path: Path
) -> None:
    """Ages and genders of those who took part are filled in, once; strangers are left out."""
    for number in range(3):
        opened(store, study, number)
    path = written(tmp_path / "a.csv", HEADER + ROWS)
    done = join_prolific(store, path)
    assert (done.rows, done.matched, done.filled, done.returned, done.answers) == (3, 2, 2, 1, 3)
    subjects = store.read().subjects
    assert subjects["gender"].fillna("-").tolist() == ["female", "male", "-"]
    assert subjects["age"].fillna(0).tolist() == [31.0, 0.0, 0.0]
    assert subjects["status"].tolist() == ["started", "returned", "started"]
    again = join_prolific(store, path)
    assert (again.matched, again.filled, again.returned, again.answers) == (2, 0, 0, 0)


def test_what_a_subject_said_stands(
    sqlite_store: ResponseStore, study: Study, tmp_path: Path
) -> None:
    """The subject's own age and gender are kept; the panel's are beside them, as answers."""
    token = opened(sqlite_store, study, 0)
    sqlite_store.record_questionnaire(token, {"age": "29", "gender": "other"})
    join_prolific(sqlite_store, written(tmp_path / "a.csv", HEADER + ROWS))
    data = sqlite_store.read()
    assert data.subjects[["age", "gender"]].to_numpy().tolist() == [[29.0, "other"]]
    told = data.questionnaires.set_index("question")["answer"].to_dict()
    assert told["prolific.age"] == "31"
    assert told["prolific.gender"] == "female"


def test_no_id_is_stored(sqlite_store: ResponseStore, study: Study, tmp_path: Path) -> None:
    """Neither a participant's nor a submission's id gets into any table."""
    opened(sqlite_store, study, 0)
    ids = ROWS.replace("p0", "5f3a9b7c").replace("s0", "c0ffee11")
    join_prolific(sqlite_store, written(tmp_path / "a.csv", HEADER + ids))
    content = (tmp_path / "answers.sqlite").read_bytes()
    assert b"5f3a9b7c" not in content
    assert b"c0ffee11" not in content


def test_withheld_values_are_missing(tmp_path: Path) -> None:
    """What may not be used any more is no value, and older names of columns are known."""
    text = "participant_id,age,Sex\np0,CONSENT_REVOKED,DATA_EXPIRED\np1,40,Male\n"
    table = read_prolific(written(tmp_path / "a.csv", text))
    assert table["age"].isna().tolist() == [True, False]
    assert table["gender"].isna().tolist() == [True, False]


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("Participant id", "Person", "lacks the column Participant id: it has Submission id"),
        ("APPROVED", "LOST", "holds 'LOST' in the column 'Status' of row 1"),
        ("31", "old", "holds 'old' in the column 'Age' of row 1: expected a number"),
        ("p0", "", "holds nothing in the column 'Participant id' of row 1"),
    ],
)
def test_wrong_exports_are_told(tmp_path: Path, old: str, new: str, sentence: str) -> None:
    """A column or value that is not the panel's is one sentence with its place."""
    path = written(tmp_path / "a.csv", (HEADER + ROWS).replace(old, new, 1))
    with pytest.raises(RelightlabError) as told:
        read_prolific(path)
    assert sentence in str(told.value)
