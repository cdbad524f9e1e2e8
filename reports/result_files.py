"""Results as JSON and CSV files, whole or absent."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from datasets.atomic import atomic_path


def require_writable(*paths: Path | None) -> None:
    """Refuse outputs that cannot be written, before hours are spent on what belongs into them.

    Their folders are made; nothing is left under the names themselves.

    Parameters
    ----------
    *paths : Path or None
        None is passed over.

    Raises
    ------
    RelightlabError
        If one cannot be written.

    Examples
    --------
    >>> require_writable(None)
    """
    for path in paths:
        if path is not None:
            with suppress(_Unwritten), atomic_path(path):
                raise _Unwritten


class _Unwritten(Exception):  # noqa: N818  no error: it ends a trial
    """Ends a trial of an output without writing it."""


def write_json(path: Path, document: Mapping[str, Any]) -> None:
    """Write a document as JSON: UTF-8, indented, keys in the order given.

    Parameters
    ----------
    path : Path
    document : mapping
        Plain values; NaN is not allowed, for JSON has none.

    Raises
    ------
    RelightlabError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "rows.json"
    >>> write_json(path, {"rows": [1]})
    >>> json.loads(path.read_text())
    {'rows': [1]}
    """
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    r"""Write rows as CSV with the keys of the first row as its header; None becomes empty.

    Parameters
    ----------
    path : Path
    rows : sequence of mappings
        At least one; all with the same keys.

    Raises
    ------
    RelightlabError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "rows.csv"
    >>> write_csv(path, [{"name": "apple", "weight": 0.2}])
    >>> path.read_text()
    'name,weight\napple,0.2\n'
    """
    with (
        atomic_path(path) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as stream,
    ):
        writer = csv.DictWriter(stream, fieldnames=list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
