"""What importers of foreign answers have in common: opaque subjects, columns, outcomes in words."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from shading_model.errors import RelightlabError
from studies.csv_files import read_csv
from studies.secret_key import SecretKey

KEY_LENGTH = 16


@dataclass(frozen=True)
class ForeignFile:
    """A CSV file of answers that were collected elsewhere.

    Parameters
    ----------
    path : Path
    rows : DataFrame of str
        As `studies.csv_files.read_csv` gives them.
    """

    path: Path
    rows: pd.DataFrame

    def need(self, columns: Sequence[str]) -> None:
        """Check that the file has these columns.

        Raises
        ------
        RelightlabError
            If it lacks one.
        """
        lacking = [column for column in columns if column not in self.rows.columns]
        if lacking:
            raise RelightlabError(
                f"{self.path} lacks the column{'s' * (len(lacking) > 1)} {', '.join(lacking)}:"
                f" it has {', '.join(self.rows.columns)}"
            )

    def texts(self, column: str) -> pd.Series[str]:
        """Return a column none of whose cells may be empty."""
        self.need([column])
        values: pd.Series[str] = self.rows[column]
        if values.isna().any():
            raise self.fault(column, values.isna(), "a value")
        return values

    def optional(self, column: str) -> pd.Series[Any]:
        """Return a column with empty cells missing, all of them where there is no such column."""
        if column in self.rows:
            return self.rows[column]
        return pd.Series([None] * len(self.rows), dtype="str")

    def words(self, column: str, meaning: Mapping[str, Any]) -> pd.Series[Any]:
        """Return what each word of a column means; a word that is not in `meaning` is an error."""
        values = self.texts(column)
        wrong = ~values.isin(list(meaning))
        if wrong.any():
            raise self.fault(column, wrong, f"one of {', '.join(meaning)}")
        return values.map(dict(meaning))

    def numbers(self, column: str, *, scale: float = 1.0) -> pd.Series[float]:
        """Return a column of numbers times a scale, NaN where empty."""
        values = self.optional(column)
        numbers = pd.to_numeric(values, errors="coerce").astype("float64")
        wrong = values.notna() & ~np.isfinite(numbers)
        if wrong.any():
            raise self.fault(column, wrong, "a number")
        return numbers * scale

    def fault(self, column: str, wrong: pd.Series[bool], expected: str) -> RelightlabError:
        """Return the error for the first cell that is marked as wrong."""
        row = int(np.flatnonzero(wrong.to_numpy(dtype=bool))[0])
        cell = self.rows[column].iloc[row]
        came = "nothing" if pd.isna(cell) else repr(str(cell)[:40])
        return RelightlabError(
            f"{self.path} holds {came} in the column {column!r} of row {row + 1}:"
            f" expected {expected}"
        )


def open_foreign(path: Path, columns: Sequence[str] = ()) -> ForeignFile:
    """Return a CSV file of answers after a look at its columns.

    Parameters
    ----------
    path : Path
    columns : sequence of str
        Those it must have.

    Raises
    ------
    RelightlabError
        If it cannot be read or lacks a column.
    """
    opened = ForeignFile(path, read_csv(path))
    opened.need(columns)
    return opened


def subject_namer(source: str, key: SecretKey | None) -> Callable[[str], str]:
    """Return the function that gives a worker an opaque name, always the same one.

    Parameters
    ----------
    source : str
        The set or study: the same worker has other names in others.
    key : SecretKey or None
        What ids are hashed with, so that nobody without it can try out ids; None for published
        sets, whose ids are opaque already and whose names then agree everywhere.

    Examples
    --------
    >>> subject_namer("dynavect-2afc", None)("w01")
    'e36fa5763a56e71a'
    """

    def name(worker: str) -> str:
        if key is not None:
            return key.digest("imported", source, worker)[:KEY_LENGTH]
        return hashlib.sha256(f"{source}\x1f{worker}".encode()).hexdigest()[:KEY_LENGTH]

    return name


def foreign_hash(source: str) -> str:
    """Return what stands for the study's hash where the study is not ours.

    Parameters
    ----------
    source : str

    Examples
    --------
    >>> len(foreign_hash("dynavect-2afc"))
    64
    """
    return hashlib.sha256(f"imported\x1f{source}".encode()).hexdigest()


def one_row_each(table: pd.DataFrame, path: Path) -> pd.DataFrame:
    """Return one row for each subject where every row repeats the subject's own values.

    Parameters
    ----------
    table : DataFrame
        With a column ``subject``.
    path : Path
        Named in the error.

    Raises
    ------
    RelightlabError
        If two rows of a subject differ.
    """
    rows = table.drop_duplicates()
    twice = rows["subject"].duplicated().to_numpy(dtype=bool)
    if twice.any():
        number = int(rows.index[np.flatnonzero(twice)[0]]) + 1
        raise RelightlabError(
            f"{path} says otherwise about a subject in row {number} than in an earlier row:"
            " give each subject one gender, age and answer to each question"
        )
    return rows.reset_index(drop=True)


def long_answers(table: pd.DataFrame, questions: Sequence[str]) -> pd.DataFrame:
    """Return columns of answers as rows (subject, question, answer), empty ones left out.

    Parameters
    ----------
    table : DataFrame
        One row for each subject.
    questions : sequence of str
        Columns of the table.

    Examples
    --------
    >>> long_answers(pd.DataFrame({"subject": ["a"], "age": ["31"], "sex": [None]}), ["age", "sex"])
      subject question answer
    0       a      age     31
    """
    long = table.melt("subject", list(questions), var_name="question", value_name="answer")
    return long[long["answer"].notna()].reset_index(drop=True)


def imported_subjects(each: pd.DataFrame, name: str) -> pd.DataFrame:
    """Return the subjects of a foreign set: of mode ``imported`` and complete unless said else.

    Parameters
    ----------
    each : DataFrame
        One row for each subject, with a column ``subject`` and any other of a subject's columns.
    name : str
        Of the set; its task's too.

    Examples
    --------
    >>> imported_subjects(pd.DataFrame({"subject": ["a"], "age": [31.0]}), "lab")["mode"].item()
    'imported'
    """
    fixed = {"study_hash": foreign_hash(name), "task": name, "mode": "imported"}
    rows = pd.DataFrame({"order": 0, "status": "complete", **fixed}, index=each.index)
    return each.combine_first(rows)
