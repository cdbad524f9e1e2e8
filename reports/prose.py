"""Prose of a report: backticks for code, braces for emphasis, an underscore for an index (S_p)."""

from __future__ import annotations

import re
from collections.abc import Iterator

_CODE = re.compile(r"`{1,2}([^`]+)`{1,2}")
_EMPHASIS = re.compile(r"\{([^{}]+)\}")
_INDEX = re.compile(r"(?<=\b[A-Zw])_(\w)\b")


def spans(text: str) -> list[tuple[str, str]]:
    """Return prose cut at its marks: the kind of each piece, and the piece.

    Parameters
    ----------
    text : str

    Returns
    -------
    list of (str, str)
        Kinds are ``text``, ``code``, ``emphasis`` and ``index``.

    Examples
    --------
    >>> spans("by `k`, S_p and {style}")
    [('text', 'by '), ('code', 'k'), ('text', ', S'), ('index', 'p'), ('text', ' and '),
     ('emphasis', 'style')]
    """
    found: list[tuple[str, str]] = []
    for place, piece in enumerate(_CODE.split(text)):
        found += [("code", piece)] if place % 2 else _plain_spans(piece)
    return [(kind, piece) for kind, piece in found if piece]


def _plain_spans(text: str) -> Iterator[tuple[str, str]]:
    for place, piece in enumerate(_EMPHASIS.split(text)):
        if place % 2:
            yield "emphasis", piece
            continue
        for part, words in enumerate(_INDEX.split(piece)):
            yield ("index" if part % 2 else "text"), words
