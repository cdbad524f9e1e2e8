"""Tests of exports of a study: files, marks, data dictionary."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings

from shading_model.errors import RelightlabError
from studies import exporting
from studies.bare_study import bare_study
from studies.exporting import (
    DICTIONARY,
    MANIFEST,
    export_study,
    marked_columns,
    marks_sentence,
    read_export,
)
from studies.simulation import simulate
from studies.tables import TABLES, StudyData
from tests.studies.study_answers import answers, any_answers, assert_same


@settings(max_examples=12)
@given(any_answers())
def test_any_answers_come_back(tmp_path_factory: pytest.TempPathFactory, data: StudyData) -> None:
    """What is exported reads back the same, from CSV and from Parquet, mark and all."""
    folder = export_study(data, tmp_path_factory.mktemp("export") / "answers")
    assert_same(read_export(folder), data)
    tables = {name: pd.read_parquet(folder / f"{name}.parquet") for name in TABLES}
    assert all("mode" in table for table in tables.values())
    own = {name: tables[name][[column.name for column in TABLES[name]]] for name in TABLES}
    assert_same(StudyData(**own), data)


def test_the_same_answers_give_the_same_files(tmp_path: Path) -> None:
    """Two exports of the same answers agree in every byte."""
    first, second = (export_study(answers(), tmp_path / name) for name in "ab")
    assert (first / MANIFEST).read_bytes() == (second / MANIFEST).read_bytes()


def test_every_file_of_simulated_answers_says_so(tmp_path: Path) -> None:
    """The mark is in every row of every CSV, in Parquet's metadata, the notes and the manifest."""
    data = simulate(bare_study(pairs=2), 3)
    folder = export_study(data, tmp_path / "a")
    for name in TABLES:
        table = pd.read_csv(folder / f"{name}.csv")
        assert (table["mode"] == "simulated").all()
        metadata = pq.read_schema(folder / f"{name}.parquet").metadata
        assert json.loads(metadata[b"relightlab"]) == {"marks": ["simulated"]}
    notes = (folder / "README.txt").read_text(encoding="utf-8")
    assert notes.startswith("Of the subjects' answers, 3 of 3 are simulated, not given by people.")
    assert json.loads((folder / MANIFEST).read_text())["marks"] == ["simulated"]
    assert read_export(folder).simulated


def test_answers_of_people_bear_no_mark(tmp_path: Path) -> None:
    """Nothing says simulated where nothing is."""
    folder = export_study(answers(), tmp_path / "a")
    assert marks_sentence(answers()) == ""
    assert "simulated" not in (folder / "trials.csv").read_text()
    assert json.loads((folder / MANIFEST).read_text())["marks"] == []


def test_the_dictionary_explains_every_column(tmp_path: Path) -> None:
    """The dictionary has one row for each column of each file, in order, with a meaning."""
    folder = export_study(answers(), tmp_path / "a")
    dictionary = pd.read_csv(folder / DICTIONARY, keep_default_na=False)
    for name in TABLES:
        own = dictionary[dictionary["table"] == name]
        assert own["column"].tolist() == list(pd.read_csv(folder / f"{name}.csv"))
        assert own["column"].tolist() == [column.name for column in marked_columns(name)]
        assert (own["meaning"].str.len() > 3).all()


def test_an_export_replaces_an_earlier_one_whole(tmp_path: Path) -> None:
    """The folder then holds the new answers alone, and nothing is left beside it."""
    folder = export_study(answers(), tmp_path / "a")
    (folder / "left over.txt").write_text("of before")
    export_study(answers(mode="pilot"), folder)
    assert read_export(folder).marks == ("pilot",)
    assert not (folder / "left over.txt").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_a_failed_export_leaves_the_earlier_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk in the middle is one sentence; the earlier export is whole, nothing beside it."""
    folder = export_study(answers(), tmp_path / "a")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(exporting, "_write_parquet", full)
    with pytest.raises(RelightlabError, match=r"cannot write .*: No space left on device"):
        export_study(answers(mode="pilot"), folder)
    assert_same(read_export(folder), answers())
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_a_folder_of_other_things_is_not_touched(tmp_path: Path) -> None:
    """A folder that holds something else is refused and stays."""
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(RelightlabError, match="holds something else than an export"):
        export_study(answers(), tmp_path)
    assert (tmp_path / "thesis.tex").exists()


def test_a_mark_cannot_be_edited_away(tmp_path: Path) -> None:
    """A file that was changed after the export is refused."""
    folder = export_study(answers(mode="simulated"), tmp_path / "a")
    path = folder / "subjects.csv"
    path.write_text(path.read_text().replace("simulated", "live"))
    with pytest.raises(RelightlabError, match=r"subjects\.csv is not as it was exported"):
        read_export(folder)


@pytest.mark.parametrize("manifest", [None, "", "[]", "{}", '{"relightlab_export": 1}'])
def test_what_is_no_export_is_told(tmp_path: Path, manifest: str | None) -> None:
    """A folder without a whole manifest is no export."""
    if manifest is not None:
        (tmp_path / MANIFEST).write_text(manifest)
    with pytest.raises(RelightlabError, match="is not an export: expected a folder that"):
        read_export(tmp_path)


def test_a_later_version_is_told(tmp_path: Path) -> None:
    """An export of a layout that is not known is refused."""
    (tmp_path / MANIFEST).write_text('{"relightlab_export": 2, "sha256": {}}')
    with pytest.raises(RelightlabError, match="an export of version 2, expected 1"):
        read_export(tmp_path)
