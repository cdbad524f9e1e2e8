"""Rows of results as lines of text that tell whether they are whole.

Each line is ``CHECKSUM SPACE JSON NEWLINE``, the checksum being the first sixteen hexadecimal
digits of the SHA-256 of the JSON text. What the rows of a batch share - experiment, version,
inputs, commit, environment - stands once before them, in a line ``{"origin": ID, "shared": {...}}``
that they name by its id, the hash of its content.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from shading_model.errors import RelightlabError

Row: TypeAlias = Mapping[str, Any]
CHECKSUM_DIGITS = 16
ORIGIN, SHARED = "origin", "shared"
ORIGIN_FIELDS = ("experiment", "version", "inputs", "data", "seed", "commit", "environment")
"""What is written once for all rows of a batch that agree in it."""
_encode_json = json.JSONEncoder(allow_nan=False, ensure_ascii=False).encode


@dataclass(frozen=True)
class DamagedLine:
    """A line that cannot be read.

    Parameters
    ----------
    number : int
        One for the first line of the file.
    reason : str
    """

    number: int
    reason: str


def encode_rows(rows: Iterable[Row]) -> Iterator[bytes]:
    """Yield the lines of a batch: each origin before the first row that names it.

    Parameters
    ----------
    rows : iterable of mappings

    Raises
    ------
    RelightlabError
        As `encode_row`.

    Examples
    --------
    >>> rows = [{"commit": "ab12", "cell": {"object": name}} for name in ("sun", "pear")]
    >>> for line in encode_rows(rows):
    ...     print(line.decode(), end="")
    e1c99e41acc6bad7 {"origin": "4199520765a70f8a", "shared": {"commit": "ab12"}}
    e23ed12f5d0a9612 {"origin": "4199520765a70f8a", "cell": {"object": "sun"}}
    3bf1d68caa167948 {"origin": "4199520765a70f8a", "cell": {"object": "pear"}}
    """
    known: dict[str, str] = {}
    for row in rows:
        shared = {field: row[field] for field in ORIGIN_FIELDS if field in row}
        if not shared:
            yield encode_row(row)
            continue
        content = repr(shared)
        if content not in known:
            known[content] = _checksum(_json(shared)).decode()
            yield encode_row({ORIGIN: known[content], SHARED: shared})
        own = {field: value for field, value in row.items() if field not in shared}
        yield encode_row({ORIGIN: known[content], **own})


def decode_rows(lines: Iterable[bytes]) -> Iterator[dict[str, Any] | DamagedLine]:
    """Yield each row with what it shares with others, or the damage of its line.

    Parameters
    ----------
    lines : iterable of bytes

    Examples
    --------
    >>> rows = [{"commit": "ab12", "cell": {"object": "sun"}}]
    >>> list(decode_rows([*encode_rows(rows), b"cut"]))
    [{'commit': 'ab12', 'cell': {'object': 'sun'}}, DamagedLine(number=3, reason='the line is ...
    """
    origins: dict[str, dict[str, Any]] = {}
    for number, line in enumerate(lines, start=1):
        try:
            row = decode_row(line)
            if SHARED in row:
                origins[row[ORIGIN]] = row[SHARED]
            elif ORIGIN in row:
                yield {**origins[row.pop(ORIGIN)], **row}
            else:
                yield row
        except ValueError as error:
            yield DamagedLine(number, str(error))
        except KeyError:
            yield DamagedLine(number, "the line that says where it comes from is damaged")


def encode_row(row: Row) -> bytes:
    r"""Return the line of a row.

    Parameters
    ----------
    row : mapping

    Raises
    ------
    RelightlabError
        If a value is NaN, infinite or no JSON value.

    Examples
    --------
    >>> encode_row({"imse": 0.5})
    b'cf27a45cfc913bf0 {"imse": 0.5}\n'
    """
    text = _json(row)
    return _checksum(text) + b" " + text + b"\n"


def decode_row(line: bytes) -> dict[str, Any]:
    """Return the row of a line.

    Parameters
    ----------
    line : bytes

    Raises
    ------
    ValueError
        If the line is cut or its checksum does not fit.

    Examples
    --------
    >>> decode_row(encode_row({"imse": 0.5}))
    {'imse': 0.5}
    """
    if not line.endswith(b"\n"):
        raise ValueError("the line is cut off")
    checksum, _, text = line[:-1].partition(b" ")
    if checksum != _checksum(text):
        raise ValueError("the checksum does not fit the line")
    row: dict[str, Any] = json.loads(text)
    return row


def _json(value: object) -> bytes:
    try:
        return _encode_json(value).encode()
    except (TypeError, ValueError) as error:
        raise RelightlabError(f"a result row holds a value that is not JSON: {error}") from error


def _checksum(text: bytes) -> bytes:
    return hashlib.sha256(text).hexdigest()[:CHECKSUM_DIGITS].encode()
