"""Reading CSV files of any origin strictly, as text, and writing them so that they read back."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import pandas as pd

from shading_model.errors import RelightlabError

SEPARATORS = (",", ";", "\t")
# What a spreadsheet would run as a formula, and the mark that keeps it from doing so.
_FORMULA = re.compile(r"[=+\-@\t\r']")
_HARMLESS = re.compile(r"-|[+-]?\d+(\.\d*)?([eE][+-]?\d+)?")
_MARKED = re.compile(r"'[=+\-@\t\r']")


def read_csv(path: Path, *, may_be_empty: bool = False) -> pd.DataFrame:
    """Return the rows of a CSV file as text; an empty cell is missing.

    The separator is a comma, a semicolon or a tab, whichever the first line has most of.

    Parameters
    ----------
    path : Path
        UTF-8, with or without a byte-order mark; the first line names the columns.
    may_be_empty : bool
        Whether a line of names alone will do.

    Returns
    -------
    DataFrame of str

    Raises
    ------
    RelightlabError
        If the file cannot be read, is not UTF-8, has no rows, names a column twice, or has a row
        of another length.

    Examples
    --------
    >>> read_csv(Path("no such file.csv"))
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: cannot read no such file.csv: No such file or directory
    """
    text = _text_of(path)
    first = text.split("\n", 1)[0]
    separator = max(SEPARATORS, key=first.count)
    try:
        stream = io.StringIO(text, newline="")
        lines = list(csv.reader(stream, delimiter=separator, strict=True))
    except csv.Error as error:
        raise RelightlabError(
            f"{path} is not a CSV file: {error}; close every quotation mark"
        ) from error
    header, rows = (lines[0], [line for line in lines[1:] if line]) if lines else ([], [])
    if not header or not (rows or may_be_empty):
        raise RelightlabError(f"{path} holds no rows: expected a line of names, then the answers")
    _check_shape(path, header, rows)
    cells = [[cell or None for cell in row] for row in rows]
    return pd.DataFrame(cells, columns=pd.Index(header), dtype="str")


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write rows as RFC 4180 has it, UTF-8; None is an empty cell, floats are exact.

    A text that a spreadsheet would take for a formula gets an apostrophe before it, which
    `unmarked` takes away.

    Parameters
    ----------
    path : Path
    header : sequence of str
    rows : iterable of sequences
        Of str, int, float, bool or None.
    """
    with path.open("w", encoding="utf-8", newline="") as stream:
        # CRLF besides being the standard's makes the writer quote both of its letters in a text.
        writer = csv.writer(stream, lineterminator="\r\n")
        writer.writerow(header)
        writer.writerows([_marked(cell) for cell in row] for row in rows)


def unmarked(text: str) -> str:
    """Return a text of a file that `write_csv` wrote, as it was.

    Parameters
    ----------
    text : str

    Examples
    --------
    >>> unmarked("'=1+1"), unmarked("it's")
    ('=1+1', "it's")
    """
    return text[1:] if _MARKED.match(text) else text


def _marked(cell: object) -> object:
    if not isinstance(cell, str) or not _FORMULA.match(cell) or _HARMLESS.fullmatch(cell):
        return cell
    return f"'{cell}"


def _text_of(path: Path) -> str:
    try:
        return path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise RelightlabError(f"cannot read {path}: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise RelightlabError(
            f"{path} is not UTF-8 at byte {error.start}: save it again as 'CSV UTF-8'"
        ) from error


def _check_shape(path: Path, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    twice = [name for name in header if header.count(name) > 1]
    if twice:
        raise RelightlabError(f"{path} has two columns {twice[0]!r}: give each a name of its own")
    for number, row in enumerate(rows, start=1):
        if len(row) != len(header):
            raise RelightlabError(
                f"row {number} of {path} has {len(row)} cells, the first line names"
                f" {len(header)}: save the table again as CSV"
            )
