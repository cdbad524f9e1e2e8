"""Tests of the two published sets of answers."""

from __future__ import annotations

from pathlib import Path

import pytest

from shading_model.errors import RelightlabError
from studies.exporting import export_study, read_export
from studies.published_sets import (
    DYNAVECT,
    DYNAVECT_FILE,
    GENGAP,
    GENGAP_FILE,
    read_dynavect,
    read_gengap,
)
from studies.tables import StudyData
from tests.studies.study_answers import assert_same

DYNAVECT_ROWS = (
    "worker,question,position,prompt,image_A,image_B,baseline,ours_side,answer,chose_ours,"
    "work_time_s\n"
    "w01,q01,1,young,o.png,ours.png,styleclip_o,B,B,1,394\n"
    "w01,q02,2,young,ours.png,g.png,styleclip_g,A,B,0,394\n"
)
GENGAP_ROWS = (
    "subject,age_band,gender,validation_item,complete,conf_real,conf_fake,image,image_type,"
    "judged_real,correct,rt_s\n"
    "s001,50-59,female,künstlich generiert,1,sicher,neutral,real_01,real,1,1,6.65\n"
    "s001,50-59,female,künstlich generiert,1,sicher,neutral,fake_01,artificial,1,0,2.5\n"
    "s002,20-29,male,echt,0,sicher,neutral,real_01,real,0,0,1\n"
)


def written(path: Path, text: str) -> Path:
    """A file with this text."""
    path.write_text(text, encoding="utf-8")
    return path


def test_dynavect_rows_become_trials(tmp_path: Path) -> None:
    """Image A is on the left, our side the target's, the baseline the condition."""
    data = read_dynavect(written(tmp_path / "a.csv", DYNAVECT_ROWS))
    assert data.subjects["mode"].tolist() == ["imported"]
    wanted = ["trial", "position", "pair", "condition", "left", "target_side", "response"]
    assert data.trials[[*wanted, "chose_target"]].to_numpy().tolist() == [
        [0, 1.0, "q01", "styleclip_o", "o.png", "right", "right", 1.0],
        [1, 2.0, "q02", "styleclip_g", "ours.png", "left", "right", 0.0],
    ]
    assert data.questionnaires[["question", "answer"]].to_numpy().tolist() == [
        ["work_time_s", "394"]
    ]


def test_gengap_rows_become_trials(tmp_path: Path) -> None:
    """Judgements are main trials without sides; the attention check qualifies, last of all."""
    data = read_gengap(written(tmp_path / "a.csv", GENGAP_ROWS))
    assert data.subjects["gender"].tolist() == ["female", "male"]
    assert data.subjects["age"].tolist() == [55.0, 25.0]
    assert data.subjects["status"].tolist() == ["complete", "started"]
    main = data.trials[data.trials["kind"] == "main"]
    assert main["chose_target"].tolist() == [1.0, 0.0, 0.0]
    assert main["reaction_ms"].tolist() == [6650.0, 2500.0, 1000.0]
    assert main[["left", "target_side", "response", "position"]].isna().all(axis=None)
    checks = data.trials[data.trials["kind"] == "qualification"]
    assert checks["trial"].tolist() == [2, 1]
    assert checks["chose_target"].tolist() == [1.0, 0.0]


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("B,B,1", "C,B,1", "holds 'C' in the column 'ours_side' of row 1: expected one of A, B"),
        ("B,B,1", "B,B,2", "holds '2' in the column 'chose_ours' of row 1: expected one of 0, 1"),
        ("B,B,1", "B,B,0", "chose_target 0 in row 0, where the response is right"),
        ("B,B,1", "B,,1", "holds nothing in the column 'answer' of row 1"),
        (",baseline,", ",base,", "lacks the column baseline: it has worker, question"),
        ("q01,1,", "q01,x,", "holds 'x' in the column 'position' of row 1: expected a number"),
        ("q02,2,", "q02,1,", "trial 0 twice"),
        ("0,394", "0,395", "says otherwise about a subject in row 2 than in an earlier row"),
    ],
)
def test_damaged_rows_are_told(tmp_path: Path, old: str, new: str, sentence: str) -> None:
    """A word, number or column that is not the set's is one sentence with its place."""
    path = written(tmp_path / "a.csv", DYNAVECT_ROWS.replace(old, new, 1))
    with pytest.raises(RelightlabError) as told:
        read_dynavect(path)
    assert sentence in str(told.value)


@pytest.mark.real_data
def test_dynavect_has_its_published_rates(dynavect: StudyData) -> None:
    """60.34 % of 1576 and 58.88 % of 1571 trials chose ours, as the set's own notes say."""
    rates = dynavect.trials.groupby("condition")["chose_target"].agg(["mean", "size"])
    assert rates["size"].to_dict() == {"styleclip_g": 1576, "styleclip_o": 1571}
    assert (100 * rates["mean"]).round(2).to_dict() == {"styleclip_g": 60.34, "styleclip_o": 58.88}
    assert (len(dynavect.subjects), dynavect.trials["pair"].nunique()) == (58, 58)


@pytest.mark.real_data
def test_gengap_has_its_published_counts(gengap: StudyData) -> None:
    """120 people of four bands, 112 past the check, who are right in the published 87.0 %."""
    main = gengap.trials[gengap.trials["kind"] == "main"]
    check = gengap.trials[gengap.trials["kind"] == "qualification"]
    passed = check.loc[check["chose_target"] == 1, "subject"]
    assert (len(gengap.subjects), len(main), len(passed)) == (120, 7200, 112)
    assert main.groupby("condition").size().to_dict() == {"artificial": 3600, "real": 3600}
    assert gengap.subjects["gender"].value_counts().tolist() == [61, 58, 1]
    assert gengap.subjects["age"].value_counts().to_dict() == {55: 44, 25: 34, 35: 26, 65: 16}
    right = main.loc[main["subject"].isin(passed), "chose_target"].mean()
    assert round(100 * right, 1) == 87.0


@pytest.mark.real_data
def test_published_sets_survive_an_export(
    dynavect: StudyData, gengap: StudyData, tmp_path: Path
) -> None:
    """Both sets, exported and read again, are the same."""
    for data in (dynavect, gengap):
        assert_same(read_export(export_study(data, tmp_path / "export")), data)


@pytest.fixture(scope="module")
def dynavect(data_root: Path) -> StudyData:
    """The whole of one set; skips where it is not here."""
    return read_dynavect(needed(data_root / DYNAVECT / DYNAVECT_FILE))


@pytest.fixture(scope="module")
def gengap(data_root: Path) -> StudyData:
    """The whole of the other set; skips where it is not here."""
    return read_gengap(needed(data_root / GENGAP / GENGAP_FILE))


def needed(path: Path) -> Path:
    """The path of a file that is there; skips where it is not."""
    if not path.is_file():
        pytest.skip(f"{path} is not here")
    return path
