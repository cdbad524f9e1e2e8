"""Tests of foreign CSV files that a mapping explains."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from shading_model.errors import RelightlabError
from studies.mapped_files import read_mapped
from studies.secret_key import SecretKey
from studies.tables import StudyData
from studies.trial_mapping import mapping_of

KEY = SecretKey(bytes(32))
COLUMNS = {"subject": "who", "item": "picture", "outcome": "won"}
MORE = COLUMNS | {"condition": "rival", "side": "where", "left": "L", "position": "place"}
ROWS = (
    "who,picture,won,rival,where,place,gender,mood\n"
    "a,p1,1,x,L,2,female,good\na,p2,0,y,R,1,female,bad\nb,p1,0.5,x,L,1,male,good\n"
)


def read(tmp_path: Path, columns: dict[str, str], **mapping: Any) -> StudyData:
    """The answers of the file by a mapping."""
    path = tmp_path / "a.csv"
    path.write_text(ROWS, encoding="utf-8")
    return read_mapped(path, mapping_of({"columns": columns, **mapping}), "lab", KEY)


def test_three_columns_are_enough(tmp_path: Path) -> None:
    """Subject, item and outcome make trials; what is not told is missing."""
    data = read(tmp_path, COLUMNS)
    assert data.trials["pair"].tolist() == ["p1", "p2", "p1"]
    assert data.trials["chose_target"].tolist() == [1.0, 0.0, 0.5]
    assert data.trials["trial"].tolist() == [0, 1, 0]
    assert data.trials[["position", "target_side", "response"]].isna().all(axis=None)
    assert data.subjects["mode"].tolist() == ["imported", "imported"]


def test_the_response_follows_from_side_and_outcome(tmp_path: Path) -> None:
    """A target on the left that won was answered left, one on the right that lost, too."""
    data = read(tmp_path, MORE)
    assert data.trials["target_side"].tolist() == ["left", "right", "left"]
    assert data.trials["response"].tolist() == ["left", "left", "tie"]
    assert data.trials["condition"].tolist() == ["x", "y", "x"]
    assert data.trials["position"].tolist() == [2.0, 1.0, 1.0]


def test_groups_of_subjects_become_answers(tmp_path: Path) -> None:
    """A group that is the same for all of a subject's rows is the subject's; a mood is not."""
    data = read(tmp_path, COLUMNS, groups=["gender", "mood"])
    assert data.subjects["gender"].tolist() == ["female", "male"]
    assert data.questionnaires["question"].tolist() == ["gender", "gender"]


def test_only_rows_asked_for_are_kept(tmp_path: Path) -> None:
    """Rows with other values are left out, and none left is one sentence."""
    assert len(read(tmp_path, COLUMNS, keep={"rival": ["x"]}).trials) == 2
    with pytest.raises(RelightlabError, match=r"no row of .* is kept: look at \[keep\]"):
        read(tmp_path, COLUMNS, keep={"rival": ["z"]})


def test_wrong_outcomes_and_columns_are_told(tmp_path: Path) -> None:
    """An outcome that is none, and a column that is not there, are each one sentence."""
    with pytest.raises(RelightlabError, match="holds 'good' in the column 'mood' of row 1"):
        read(tmp_path, COLUMNS | {"outcome": "mood"})
    with pytest.raises(RelightlabError, match="lacks the column worker: it has who, picture"):
        read(tmp_path, COLUMNS | {"subject": "worker"})
