"""Tests of the import of answers that were collected elsewhere."""

from __future__ import annotations

from pathlib import Path

import pytest

from shading_model.errors import RelightlabError
from studies.exporting import export_study
from studies.importing import FORMATS, ImportOptions, import_answers
from studies.response_store import ResponseStore
from studies.tables import StudyData
from studies.trial_mapping import mapping_of
from tests.studies.study_answers import answers, assert_same
from tests.studies.test_mapped_files import COLUMNS, ROWS
from tests.studies.test_mturk_batches import assignment
from tests.studies.test_published_sets import DYNAVECT_ROWS, GENGAP_ROWS, written


def source(file_format: str, folder: Path) -> Path:
    """A file of each format."""
    if file_format == "export":
        return export_study(answers(), folder / "export")
    row = assignment(1)
    batch = f"{','.join(row)}\n{','.join(row.values())}\n"
    texts = {"csv": ROWS, "mturk": batch, "dynavect-2afc": DYNAVECT_ROWS}
    return written(folder / "a.csv", (texts | {"gengap-realfake": GENGAP_ROWS})[file_format])


@pytest.mark.parametrize("file_format", FORMATS)
def test_importing_twice_changes_nothing(
    file_format: str, store: ResponseStore, tmp_path: Path
) -> None:
    """The second time no row is added, the store holds what was read, and no time has moved."""
    options = ImportOptions("lab", store.key, mapping_of({"columns": COLUMNS}))
    path = source(file_format, tmp_path)
    first = import_answers(path, file_format, options)
    assert store.write(first)["trials"] == len(first.trials) > 0
    before = store.read()
    again = import_answers(path, file_format, options)
    assert store.write(again) == {
        "subjects": 0,
        "trials": 0,
        "questionnaires": 0,
        "events": 0,
    }
    assert_same(store.read(), before)
    assert_same(by_key(before), by_key(first))


def by_key(data: StudyData) -> StudyData:
    """The same rows in one order; subjects come as they came."""
    trials = data.trials.sort_values(["subject", "trial"])
    told = data.questionnaires.sort_values(["subject", "question"])
    return StudyData(data.subjects.sort_values("subject"), trials, told)


def test_more_of_a_file_adds_only_what_is_new(sqlite_store: ResponseStore, tmp_path: Path) -> None:
    """A later download of the same batch adds the new assignments and leaves the old."""
    rows = [assignment(1), assignment(2), assignment(1, "B")]
    header = ",".join(rows[0])
    lines = [",".join(row.values()) for row in rows]
    options = ImportOptions("lab", sqlite_store.key)
    added = []
    for known in (1, 3):
        path = written(tmp_path / "a.csv", "\n".join([header, *lines[:known]]) + "\n")
        added.append(sqlite_store.write(import_answers(path, "mturk", options)))
    assert [one["subjects"] for one in added] == [1, 1]
    assert [one["trials"] for one in added] == [1, 2]


def test_the_same_worker_has_another_name_in_another_study(
    sqlite_store: ResponseStore, tmp_path: Path
) -> None:
    """Subjects of two studies cannot be linked by their names."""
    path = source("mturk", tmp_path)
    names = [
        import_answers(path, "mturk", ImportOptions(study, sqlite_store.key)).subjects["subject"][0]
        for study in ("one", "two")
    ]
    assert names[0] != names[1]


def test_a_folder_of_a_published_set_will_do(tmp_path: Path) -> None:
    """The folder is as good as the file in it."""
    written(tmp_path / "dynavect_trials.csv", DYNAVECT_ROWS)
    written(tmp_path / "gengap_trials.csv", GENGAP_ROWS)
    assert len(import_answers(tmp_path, "dynavect-2afc").subjects) == 1
    assert len(import_answers(tmp_path, "gengap-realfake").subjects) == 2


@pytest.mark.parametrize(
    ("file_format", "sentence"),
    [
        ("xlsx", "Unknown format 'xlsx'"),
        ("csv", "a CSV file needs a mapping that says what its columns mean"),
        ("mturk", "ids of workers are hashed with the key of a database"),
    ],
)
def test_what_is_lacking_is_told(file_format: str, sentence: str, tmp_path: Path) -> None:
    """An unknown format, no mapping and no key are each one sentence."""
    with pytest.raises(RelightlabError, match=sentence):
        import_answers(tmp_path / "a.csv", file_format)
