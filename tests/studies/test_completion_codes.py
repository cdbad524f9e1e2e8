"""Completion codes: bound to what is stored, checked without the server."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shading_model.errors import RelightlabError
from studies.completion_codes import check_codes, completion_code, completion_codes, read_codes
from studies.response_store import ResponseStore
from studies.secret_key import SecretKey
from studies.study_records import Study
from tests.studies.small_study import IDS
from tests.studies.test_response_store import RIGHT, complete

KEY = SecretKey(bytes(range(32)))
CONTENT = ("s1", "5" * 64, ((0, "left"), (1, "tie")), (("age", "31"),))


def test_codes_fit_the_stored_data_alone(sqlite_store: ResponseStore, study: Study) -> None:
    """The code handed out is that of the tables read later; incomplete sessions have none."""
    codes = {}
    for number in range(3):
        session = sqlite_store.open_session(study, IDS | {"PROLIFIC_PID": str(number)})
        codes[session.subject] = complete(sqlite_store, session)
    sqlite_store.open_session(study)
    assert completion_codes(sqlite_store.key, sqlite_store.read()) == codes
    assert len(set(codes.values())) == 3


@pytest.mark.parametrize(
    "changed",
    [
        ("s2", *CONTENT[1:]),
        ("s1", "6" * 64, *CONTENT[2:]),
        (*CONTENT[:2], ((0, "right"), (1, "tie")), CONTENT[3]),
        (*CONTENT[:2], ((0, "left"),), CONTENT[3]),
        (*CONTENT[:3], (("age", "32"),)),
        (*CONTENT[:3], ()),
    ],
)
def test_any_change_of_the_data_changes_the_code(changed: tuple[str, str, tuple, tuple]) -> None:  # type: ignore[type-arg]
    """Another subject, study, response or answer has another code, and so has another key."""
    code = completion_code(KEY, *CONTENT)
    assert completion_code(KEY, *changed) != code
    assert completion_code(SecretKey(bytes(32)), *CONTENT) != code


def test_the_code_of_a_session_is_its_own(sqlite_store: ResponseStore, study: Study) -> None:
    """A worker's code is valid once, and only from that worker."""
    ids = [IDS | {"PROLIFIC_PID": name} for name in ("anna", "ben")]
    codes = [complete(sqlite_store, sqlite_store.open_session(study, one)) for one in ids]
    known = {name: sqlite_store.subjects_of(name) for name in ("anna", "ben", "eve")}
    handed_in = [
        ("anna", f" {codes[0][:6].lower()}-{codes[0][6:]}"),
        ("ben", codes[0]),
        ("ben", codes[1]),
        ("eve", codes[1]),
        ("eve", "A" * 12),
    ]
    stored = completion_codes(sqlite_store.key, sqlite_store.read())
    verdicts = [one.verdict for one in check_codes(handed_in, stored, known)]
    assert verdicts == ["valid", "used twice", "valid", "used twice", "unknown"]
    alone = check_codes([("ben", codes[0]), ("eve", codes[1])], stored, known)
    assert [one.verdict for one in alone] == ["of another worker", "no such worker"]


def test_a_code_in_wrong_hands_stays_its_owners() -> None:
    """Who hands in another's code first takes nothing from the worker whose code it is."""
    known = {"anna": frozenset({"s1"}), "ben": frozenset({"s2"})}
    handed_in = [("ben", "ABC"), ("eve", "ABC"), ("anna", "ABC"), ("anna", "ABC")]
    verdicts = [one.verdict for one in check_codes(handed_in, {"s1": "ABC"}, known)]
    assert verdicts == ["of another worker", "no such worker", "valid", "used twice"]


def test_a_changed_answer_is_found_out(sqlite_store: ResponseStore, study: Study) -> None:
    """When an answer in the database is changed afterwards, the code no longer fits."""
    from sqlalchemy import update

    from studies.store_schema import trials

    code = complete(sqlite_store, sqlite_store.open_session(study), RIGHT)
    with sqlite_store.database.writing() as connection:
        # The whole row as it would have been, had the answer been the other.
        chosen = 1.0 - trials.c.chose_target
        connection.execute(update(trials).values(response="left", chose_target=chosen))
    stored = completion_codes(sqlite_store.key, sqlite_store.read())
    assert [one.verdict for one in check_codes([("", code)], stored)] == ["unknown"]


@given(code=st.text(max_size=20))
def test_no_text_is_taken_for_a_code(code: str) -> None:
    """Whatever is handed in as a code, there is a verdict, and no code that is not one is valid."""
    (checked,) = check_codes([("", code)], {"s1": "ABCDEFGHIJKL"})
    plain = "".join(code.split()).replace("-", "").upper()
    assert (checked.verdict == "valid") == (plain == "ABCDEFGHIJKL")


@pytest.mark.parametrize(
    ("header", "worker"),
    [("Participant id,Completion code", "w1"), ("code,WorkerId", "w1"), ("Code", "")],
)
def test_exports_of_several_panels_are_read(tmp_path: Path, header: str, worker: str) -> None:
    """The columns are found by the names panels give them."""
    values = {"code": " ABC ", "completion code": " ABC ", "participant id": "w1", "workerid": "w1"}
    row = ",".join(values[name.lower()] for name in header.split(","))
    path = tmp_path / "export.csv"
    path.write_text(f"\ufeff{header}\n{row}\n", encoding="utf-8")
    assert read_codes(path) == [(worker, "ABC")]


def test_an_export_without_codes_is_told(tmp_path: Path) -> None:
    """A file with no column for the code is told, with the names it might have."""
    path = tmp_path / "export.csv"
    path.write_text("a,b\n1,2\n")
    with pytest.raises(RelightlabError, match="no column for the code: expected one named"):
        read_codes(path)


def test_an_export_of_a_spreadsheet_is_read_or_told(tmp_path: Path) -> None:
    """Semicolons part cells as well as commas, and a file in another encoding is told."""
    path = tmp_path / "export.csv"
    path.write_text("WorkerId;Code;Note\n w1 ;ABC;\nw2;;late\n", encoding="utf-8")
    assert read_codes(path) == [("w1", "ABC")]
    path.write_bytes(b"code\n\xff\n")
    with pytest.raises(RelightlabError, match="not UTF-8"):
        read_codes(path)
