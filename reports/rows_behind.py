"""The rows of results behind a table or a figure, and a hash over them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from shading_model.errors import unknown_name

TABLE1_FILE = "table1.json"
SHOWN_DIGITS = 12
"""Of a hash, where it is printed beside a table; the provenance has it whole."""


@dataclass(frozen=True)
class Rows:
    """The rows that something was made from.

    Parameters
    ----------
    parts : tuple of str
        Keys of the results document.
    count : int
    digest : str
        SHA-256 of `rows_behind`.
    file : str
        Name of the results file that holds the document.
    """

    parts: tuple[str, ...]
    count: int
    digest: str
    file: str = TABLE1_FILE

    @property
    def sentence(self) -> str:
        """The rows in words, for a caption."""
        return f"From {self.count} rows with SHA-256 `{self.digest[:SHOWN_DIGITS]}`."


def rows_behind(document: Mapping[str, Any], *parts: str, file: str = TABLE1_FILE) -> Rows:
    """Return parts of a results document with a hash over them.

    The hash is the SHA-256 of the JSON text of the list of parts, keys sorted, no spaces, so that
    anyone can compute it from the results file.

    Parameters
    ----------
    document : mapping
    parts : str
        Keys of lists of rows.
    file : str
        Name of the results file that holds the document.

    Returns
    -------
    Rows

    Raises
    ------
    RelightlabError
        If the document has no such part.

    Examples
    --------
    >>> rows_behind({"rows": [{"imse": 0.5}]}, "rows").count
    1
    """
    for part in parts:
        if part not in document:
            raise unknown_name("part of the results", part, document)
    chosen = [document[part] for part in parts]
    text = json.dumps(chosen, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return Rows(parts, sum(map(len, chosen)), hashlib.sha256(text.encode()).hexdigest(), file)
