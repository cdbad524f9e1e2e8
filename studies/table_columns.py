"""A column of a tidy table: its name, kind and meaning, and the check that values fit it."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from shading_model.arrays import Mask
from shading_model.errors import RelightlabError, unknown_name

KINDS = {
    "text": "text",
    "time": "times in ISO 8601 with their zone, 2026-11-25T14:00:00Z",
    "number": "numbers",
    "whole": "whole numbers",
    "flag": "true or false",
}
"""What a column may hold, in words for whoever gave something else."""

EXACT = 2**53
"""Whole numbers up to this one are exact as ``float64``."""

NUMBERS = (int, float, np.integer, np.floating)

Objects = NDArray[Any]
"""Values of a column as they were given, of any types: (n,)."""


@dataclass(frozen=True)
class Column:
    """A column of a tidy table.

    Parameters
    ----------
    name : str
    kind : str
        A key of `KINDS`.
    meaning : str
        One line for the data dictionary.
    missing : bool
        Whether values may be missing.
    choices : tuple of str
        The values a text may have; any where empty.
    """

    name: str
    kind: str
    meaning: str
    missing: bool = False
    choices: tuple[str, ...] = ()

    @property
    def dtype(self) -> str:
        """Name of the pandas type of the column in a checked table."""
        if self.kind == "whole":
            return "float64" if self.missing else "int64"
        return {"number": "float64", "flag": "boolean"}.get(self.kind, "str")


def checked_table(name: str, table: pd.DataFrame, columns: Sequence[Column]) -> pd.DataFrame:
    """Return a table with exactly these columns, in their order and of their types.

    Parameters
    ----------
    name : str
        What it is called in errors: ``"trials"``.
    table : DataFrame
        Its columns that may hold missing values may be left out; all may where it has no rows.
    columns : sequence of Column

    Returns
    -------
    DataFrame
        New, rows numbered from 0.

    Raises
    ------
    RelightlabError
        If a column is unknown, lacking, comes twice, or holds what it must not.

    Examples
    --------
    >>> columns = (Column("pair", "text", "the item"), Column("age", "number", "years", True))
    >>> checked_table("trials", pd.DataFrame({"pair": ["chair"]}), columns)
        pair  age
    0  chair  NaN
    """
    given = [str(column) for column in table.columns]
    known = {column.name: column for column in columns}
    for column in given:
        if column not in known:
            raise unknown_name(f"column of the {name}", column, known)
        if given.count(column) > 1:
            raise RelightlabError(f"the {name} have the column {column!r} twice: keep one")
    lacking = [c.name for c in columns if not c.missing and c.name not in given]
    if lacking and len(table):
        raise RelightlabError(
            f"the {name} lack the column{'s' * (len(lacking) > 1)} {', '.join(lacking)}:"
            f" expected {', '.join(c.name for c in columns if not c.missing)}"
        )
    empty = pd.Series([None] * len(table), dtype=object)
    rows = table.reset_index(drop=True)
    return pd.DataFrame(
        {c.name: checked_column(name, rows.get(c.name, empty), c) for c in columns},
        index=rows.index,
    )


def checked_column(table: str, values: pd.Series, column: Column) -> pd.Series:
    """Return the values of one column in its type; an empty text is a missing one.

    Parameters
    ----------
    table : str
        What its table is called in errors.
    values : Series
        Of any type that holds such values: whole numbers do for texts, 0 and 1 for flags.
    column : Column

    Raises
    ------
    RelightlabError
        If a value is missing where none may be, or is not of the column's kind or choices.

    Examples
    --------
    >>> side = Column("response", "text", "what was chosen", choices=("left", "right"))
    >>> checked_column("trials", pd.Series(["left", "middle"]), side)
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: the column 'response' of the trials holds 'middle' in
    row 1: expected left or right
    """
    objects = values.to_numpy(dtype=object)
    absent = values.isna().to_numpy(dtype=bool)
    if column.dtype == "str":
        absent = absent | np.array([isinstance(v, str) and not v for v in objects], dtype=bool)
    if not column.missing and absent.any():
        raise RelightlabError(
            f"the column {column.name!r} of the {table} holds nothing in row"
            f" {_first(absent)}: expected {_expected(column)}"
        )
    wrong = ~absent
    if wrong.any():
        wrong[wrong] = ~_fits(objects[wrong], column)
    if wrong.any():
        row = _first(wrong)
        raise RelightlabError(
            f"the column {column.name!r} of the {table} holds {_shown(objects[row])} in row"
            f" {row}: expected {_expected(column)}"
        )
    if column.dtype == "str":
        strings = [None if no else str(v) for v, no in zip(objects, absent, strict=True)]
        return pd.Series(strings, index=values.index, dtype="str")
    if column.kind == "flag":
        flags = [pd.NA if no else bool(v) for v, no in zip(objects, absent, strict=True)]
        return pd.Series(flags, index=values.index, dtype="boolean")
    numbers = np.full(len(objects), np.nan)
    numbers[~absent] = objects[~absent]
    return pd.Series(numbers.astype(np.dtype(column.dtype)), index=values.index)


def _fits(values: Objects, column: Column) -> Mask:
    """Return which of these present values are of a column's kind and choices."""
    if column.choices:
        return np.array([value in column.choices for value in values], dtype=bool)
    if column.kind == "flag":
        return _are(values, bool, np.bool_) | (_are(values, *NUMBERS) & np.isin(values, (0, 1)))
    if column.dtype == "str":
        fits = np.array([_is_text(value) for value in values], dtype=bool)
        return fits & _are_moments(values) if column.kind == "time" else fits
    fits = _are(values, *NUMBERS) & ~_are(values, bool)
    # A comparison is safe for whole numbers too large for any float, and false for NaN.
    largest = EXACT if column.kind == "whole" else sys.float_info.max
    fits[fits] = [-largest <= value <= largest for value in values[fits]]
    if column.kind == "whole":
        fits[fits] = values[fits].astype(np.float64) % 1 == 0
    return fits


def _are(values: Objects, *types: type) -> Mask:
    return np.array([isinstance(value, types) for value in values], dtype=bool)


def _is_text(value: object) -> bool:
    if not isinstance(value, str):
        return isinstance(value, int | np.integer) and not isinstance(value, bool)
    # NUL and half a pair of surrogates can be stored neither in UTF-8 nor in every database.
    return "\0" not in value and not any("\ud800" <= letter <= "\udfff" for letter in value)


def _are_moments(values: Objects) -> Mask:
    texts = pd.Series([str(value) for value in values], dtype="str")
    moments = pd.to_datetime(texts, format="ISO8601", errors="coerce", utc=True)
    return moments.notna().to_numpy(dtype=bool)


def _first(marks: Mask) -> int:
    return int(np.flatnonzero(marks)[0])


def _shown(value: object) -> str:
    text = repr(value.item() if isinstance(value, np.generic) else value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _expected(column: Column) -> str:
    if not column.choices:
        return KINDS[column.kind]
    *others, last = column.choices
    return f"{', '.join(others)} or {last}"
