"""Tests of rows as lines: what they share is written once and never lost in silence."""

from __future__ import annotations

import math

import pytest

from evaluation.row_lines import DamagedLine, decode_rows, encode_row, encode_rows
from shading_model.errors import RelightlabError

FIRST = {"experiment": "small", "version": 1, "commit": "ab", "cell": {"object": "sun"}}
SECOND = {"experiment": "small", "version": 1, "commit": "cd", "cell": {"object": "sun"}}


def test_rows_come_back_as_they_were() -> None:
    """Rows of two origins, mixed, and rows of none are read as they were written."""
    rows = [FIRST, SECOND, FIRST, {"imse": 0.1}, SECOND]
    assert list(decode_rows(encode_rows(rows))) == rows


def test_what_rows_share_is_written_once() -> None:
    """A batch names its origin in one line, however many rows it has."""
    lines = list(encode_rows([FIRST] * 10))
    assert len(lines) == 11
    assert sum(b'"commit"' in line for line in lines) == 1


def test_rows_without_their_origin_are_damaged() -> None:
    """Rows whose origin line is damaged are reported, not read without where they came from."""
    lines = list(encode_rows([FIRST, FIRST]))
    lines[0] = lines[0].replace(b"small", b"Small")
    found = list(decode_rows(lines))
    assert [type(one) for one in found] == [DamagedLine] * 3
    assert "where it comes from" in str(found[1])
    assert list(decode_rows([*lines, *encode_rows([FIRST])]))[3:] == [FIRST]


@pytest.mark.parametrize("value", [math.nan, math.inf, object(), {1, 2}])
def test_what_is_no_json_is_refused(value: object) -> None:
    """NaN, infinity and objects are refused in one sentence."""
    with pytest.raises(RelightlabError, match="not JSON"):
        encode_row({"imse": value})
