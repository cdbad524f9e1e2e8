"""Tests of CSV files that tables are written to and read from."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shading_model.errors import RelightlabError
from studies.csv_files import read_csv, unmarked, write_csv
from tests.studies.study_answers import TEXTS


@given(st.lists(st.tuples(TEXTS, st.none() | TEXTS), min_size=1))
def test_any_text_comes_back(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[str, str | None]]
) -> None:
    """Line ends, quotes, separators and formulas in a text are the same after reading."""
    path = tmp_path_factory.mktemp("csv") / "a.csv"
    write_csv(path, ["first", "second"], rows)
    read = read_csv(path)
    back = [
        tuple(None if cell != cell else unmarked(cell) for cell in row)  # noqa: PLR0124
        for row in read.itertuples(index=False)
    ]
    assert back == rows


def test_no_cell_is_a_formula(tmp_path: Path) -> None:
    """No cell begins with what a spreadsheet would run; plain numbers stay plain."""
    texts = ["=1+1", "+cmd", "-2+3", "@SUM(A1)", "\t=1", "\r=1", "'=1", "-5", "+1.5e3", "-"]
    write_csv(tmp_path / "a.csv", ["text"], [[text] for text in texts])
    cells = read_csv(tmp_path / "a.csv")["text"].tolist()
    assert [cell[0] for cell in cells[:7]] == ["'"] * 7
    assert cells[7:] == texts[7:]


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_separators_and_marks_of_spreadsheets(tmp_path: Path, separator: str) -> None:
    """Commas, semicolons and tabs are told apart, and a byte-order mark is no part of a name."""
    path = tmp_path / "a.csv"
    text = separator.join("ab") + "\r\n" + separator.join("12") + "\r\n"
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert read_csv(path).to_dict("list") == {"a": ["1"], "b": ["2"]}


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "holds no rows: expected a line of names, then the answers"),
        (b"a,b\n", "holds no rows"),
        (b"a,a\n1,2\n", "has two columns 'a': give each a name of its own"),
        (b"a,b\n1,2\n3\n", "row 2 of {path} has 1 cells, the first line names 2"),
        (b"a,b\n1,2,3\n", "row 1 of {path} has 3 cells, the first line names 2"),
        (b'a,b\n"1,2\n', "is not a CSV file: unexpected end of data; close every quotation mark"),
        (
            "a\ngr\u00fcn\n".encode("latin-1"),
            "is not UTF-8 at byte 4: save it again as 'CSV UTF-8'",
        ),
        ("a\n1\n".encode("utf-16"), "is not UTF-8 at byte 0"),
    ],
)
def test_wrong_files_are_told(tmp_path: Path, content: bytes, sentence: str) -> None:
    """Empty, ragged, open-ended and wrongly encoded files are each one sentence."""
    path = tmp_path / "a.csv"
    path.write_bytes(content)
    with pytest.raises(RelightlabError) as told:
        read_csv(path)
    assert sentence.format(path=path) in str(told.value)


def test_a_folder_is_told(tmp_path: Path) -> None:
    """A folder in place of a file is one sentence."""
    with pytest.raises(RelightlabError, match=r"cannot read .*: Is a directory"):
        read_csv(tmp_path)
