"""Tests of reports.prose."""

from __future__ import annotations

import pytest

from reports.prose import spans


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("plain words", [("text", "plain words")]),
        ("S_p", [("text", "S"), ("index", "p")]),
        ("a `S_p {b}` c", [("text", "a "), ("code", "S_p {b}"), ("text", " c")]),
        ("{so}", [("emphasis", "so")]),
        ("file_name, T_int", [("text", "file_name, T_int")]),
        ("", []),
    ],
)
def test_prose_is_cut_at_its_marks(text: str, expected: list[tuple[str, str]]) -> None:
    """Code, emphasis and one-letter indices are found; anything else stays as it is."""
    assert spans(text) == expected
