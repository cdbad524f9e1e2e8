"""A study's answers as a folder of CSV and Parquet files with a data dictionary, and back.

A folder is whole or not there. Each file of it says by itself whether the answers are of a pilot or
made up: in a column ``mode``, and in the metadata of a Parquet file.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from shading_model.errors import RelightlabError
from studies.csv_files import read_csv, unmarked, write_csv
from studies.table_columns import KINDS, Column
from studies.tables import MODES, TABLES, StudyData

MANIFEST = "export.json"
DICTIONARY = "data_dictionary.csv"
NOTES = "README.txt"
VERSION = 1
"""Of the layout of an export; one of a later version is refused."""

MODE = Column("mode", "text", "how the subject's answers came about", choices=MODES)
_ARROW = {"text": pa.string(), "time": pa.string(), "number": pa.float64(), "flag": pa.bool_()}
_ARROW["whole"] = pa.int64()
_FLAGS = {"true": True, "false": False}


def export_study(data: StudyData, folder: Path) -> Path:
    """Write every table as CSV and Parquet, with a data dictionary and SHA-256 sums.

    Parameters
    ----------
    data : StudyData
    folder : Path
        New, empty or an earlier export, which is replaced as a whole.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    RelightlabError
        If the folder holds anything but an export, or cannot be written.

    Examples
    --------
    >>> folder = Path(tempfile.mkdtemp()) / "answers"
    >>> empty = StudyData(pd.DataFrame(), pd.DataFrame())
    >>> sorted(path.name for path in export_study(empty, folder).glob("*.csv"))
    ['data_dictionary.csv', 'events.csv', 'questionnaires.csv', 'subjects.csv', 'trials.csv']
    """
    _check_target(folder)
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        aside = Path(tempfile.mkdtemp(dir=folder.parent, prefix=f".{folder.name}-"))
        try:
            _write(data, aside / "new")
            _flush(aside / "new")
            if folder.exists():
                folder.replace(aside / "old")
            (aside / "new").replace(folder)
        finally:
            shutil.rmtree(aside)
    except OSError as error:
        raise RelightlabError(
            f"cannot write {folder}: {error.strerror or error}; choose another folder"
        ) from error
    return folder


def read_export(folder: Path) -> StudyData:
    """Return the answers that an export holds, from its CSV files.

    Parameters
    ----------
    folder : Path
        Made by `export_study`.

    Raises
    ------
    RelightlabError
        If it is not an export, is of a later version, or a file of it was changed.
    """
    manifest = _manifest(folder)
    for name, digest in manifest["sha256"].items():
        if not (folder / name).is_file() or _sha256(folder / name) != digest:
            raise RelightlabError(
                f"{folder / name} is not as it was exported: export the study again"
            )
    return StudyData(
        **{name: _read_table(folder, name, columns) for name, columns in TABLES.items()}
    )


def marked_table(data: StudyData, name: str) -> pd.DataFrame:
    """Return a table with a column ``mode``, so that made-up answers are never without their mark.

    Parameters
    ----------
    data : StudyData
    name : str
        A key of `studies.tables.TABLES`.

    Returns
    -------
    DataFrame
        New.
    """
    table = data.table(name)
    mode = table["subject"].map(data.subjects.set_index("subject")["mode"])
    return table.assign(mode=mode.astype("str"))


def marked_columns(name: str) -> tuple[Column, ...]:
    """Return the columns of a table as it is exported.

    Parameters
    ----------
    name : str
        A key of `studies.tables.TABLES`.

    Examples
    --------
    >>> [column.name for column in marked_columns("questionnaires")]
    ['subject', 'question', 'answer', 'mode']
    """
    columns = TABLES[name]
    return columns if any(column.name == MODE.name for column in columns) else (*columns, MODE)


def marks_sentence(data: StudyData) -> str:
    """Return in one sentence what these answers are not, empty for those of real subjects.

    Parameters
    ----------
    data : StudyData

    Examples
    --------
    >>> marks_sentence(StudyData(pd.DataFrame(), pd.DataFrame()))
    ''
    """
    modes = data.subjects["mode"]
    words = {"simulated": "simulated, not given by people", "pilot": "of a pilot, not of the study"}
    parts = [f"{(modes == mark).sum()} of {len(modes)} are {words[mark]}" for mark in data.marks]
    return f"Of the subjects' answers, {' and '.join(parts)}." if parts else ""


def _write(data: StudyData, folder: Path) -> None:
    folder.mkdir()
    for name in TABLES:
        columns, table = marked_columns(name), marked_table(data, name)
        cells = [_cells(table[column.name], column) for column in columns]
        header = [column.name for column in columns]
        texts = [_in_csv(values, column) for values, column in zip(cells, columns, strict=True)]
        write_csv(folder / f"{name}.csv", header, zip(*texts, strict=True))
        _write_parquet(folder / f"{name}.parquet", columns, cells, data.marks)
    write_csv(
        folder / DICTIONARY,
        ("table", "column", "kind", "missing", "values", "meaning"),
        _dictionary(),
    )
    (folder / NOTES).write_text(_notes(data), encoding="utf-8")
    document: dict[str, Any] = {
        "relightlab_export": VERSION,
        "marks": list(data.marks),
        "rows": {name: len(data.table(name)) for name in TABLES},
        "sha256": {path.name: _sha256(path) for path in sorted(folder.iterdir())},
    }
    (folder / MANIFEST).write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")


def _flush(folder: Path) -> None:
    for path in folder.iterdir():
        with path.open("rb+") as stream:
            os.fsync(stream.fileno())


def _cells(values: pd.Series[Any], column: Column) -> list[Any]:
    """Return a column's values as Python's own, None where missing."""
    kind = {"whole": int, "number": float, "flag": bool}.get(column.kind, str)
    absent = values.isna()
    return [None if no else kind(value) for value, no in zip(values, absent, strict=True)]


def _in_csv(values: list[Any], column: Column) -> list[Any]:
    if column.kind != "flag":
        return values
    return [None if value is None else str(value).lower() for value in values]


def _write_parquet(
    path: Path, columns: tuple[Column, ...], cells: list[list[Any]], marks: tuple[str, ...]
) -> None:
    fields = [
        pa.field(
            column.name,
            _ARROW[column.kind],
            nullable=column.missing,
            metadata={"meaning": column.meaning},
        )
        for column in columns
    ]
    schema = pa.schema(fields, metadata={"relightlab": json.dumps({"marks": marks})})
    arrays = [pa.array(values, field.type) for values, field in zip(cells, fields, strict=True)]
    pq.write_table(pa.Table.from_arrays(arrays, schema=schema), path)


def _dictionary() -> list[tuple[str, ...]]:
    return [
        (
            name,
            column.name,
            KINDS[column.kind],
            "may be missing" if column.missing else "never missing",
            " ".join(column.choices),
            column.meaning,
        )
        for name in TABLES
        for column in marked_columns(name)
    ]


def _notes(data: StudyData) -> str:
    counts = "\n".join(f"  {name}: {len(data.table(name))} rows" for name in TABLES)
    return (
        f"{marks_sentence(data) or 'Answers of a two-alternative forced-choice study.'}\n\n"
        f"{counts}\n\n"
        f"Each table is a CSV file (UTF-8, an empty cell is missing) and the same as Parquet.\n"
        f"{DICTIONARY} says what each column means; {MANIFEST} has the SHA-256 of each file.\n"
        "In the CSV files an apostrophe stands before texts that a spreadsheet would run.\n"
    )


def _check_target(folder: Path) -> None:
    if not folder.exists() or (folder / MANIFEST).is_file():
        return
    if not folder.is_dir() or any(folder.iterdir()):
        raise RelightlabError(
            f"{folder} holds something else than an export: choose a folder that is new or empty"
        )


def _manifest(folder: Path) -> Mapping[str, Any]:
    try:
        manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        version, sums = manifest["relightlab_export"], manifest["sha256"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise RelightlabError(
            f"{folder} is not an export: expected a folder that 'relightlab study export' made"
        ) from error
    needed = {f"{name}.csv" for name in TABLES}
    if version != VERSION or not isinstance(sums, dict) or not needed <= set(sums):
        raise RelightlabError(
            f"{folder} is an export of version {version}, expected {VERSION}: export it again"
        )
    return {"sha256": sums}


def _read_table(folder: Path, name: str, columns: tuple[Column, ...]) -> pd.DataFrame:
    texts = read_csv(folder / f"{name}.csv", may_be_empty=True)
    return pd.DataFrame({c.name: _values(texts[c.name], c) for c in columns})


def _values(texts: pd.Series[str], column: Column) -> pd.Series[Any]:
    parse: Mapping[str, Any] = {"number": float, "whole": int, "flag": _FLAGS.__getitem__}
    return texts.astype(object).map(parse.get(column.kind, unmarked), na_action="ignore")


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
