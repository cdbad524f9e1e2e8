"""Tests of lines, tables and progress."""

from __future__ import annotations

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from reports.console import MOST_LINES, PlainProgress, print_table, progress, say


def test_lines_are_printed_as_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    """Brackets are no markup and long lines are not broken."""
    line = "[red]" + 300 * "x"
    say(line)
    assert capsys.readouterr().out == line + "\n"


def test_table_entries_are_printed_as_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    """Brackets are no markup in tables either, and no entry is cut short in a pipe."""
    print_table("Title", ("name", "number"), [("[bold]x", "1"), (), (100 * "y", "22")])
    shown = capsys.readouterr().out
    assert shown.startswith("Title\n")
    assert "[bold]x" in shown
    assert 100 * "y" in shown


def test_numbers_are_aligned_to_the_right(capsys: pytest.CaptureFixture[str]) -> None:
    """The last digits of a column of numbers stand below each other."""
    print_table("Title", ("number", "text"), [("1.5", "a"), ("22.5", "b"), ("-", "c")])
    lines = capsys.readouterr().out.splitlines()[-3:]
    assert [line.index(text) for line, text in zip(lines, ("5 ", "5 ", "- "), strict=True)] == [
        lines[0].index("5 ")
    ] * 3


@given(total=st.integers(1, 5000))
def test_plain_progress_has_few_lines_and_reaches_the_end(total: int) -> None:
    """Whatever the amount of work there are at most `MOST_LINES` lines; the last says all."""
    stream = io.StringIO()
    report = PlainProgress("work", Console(file=stream))
    for done in range(1, total + 1):
        report(done, total, "step")
    lines = stream.getvalue().splitlines()
    assert 1 <= len(lines) <= MOST_LINES
    assert lines[-1] == f"work: {total} of {total} (step)"


def test_progress_is_on_standard_error(capsys: pytest.CaptureFixture[str]) -> None:
    """Without a terminal, progress is lines that do not mix with the result."""
    with progress("work") as report:
        report(1, 2, "half")
        report(2, 2, "all")
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err == "work: 1 of 2 (half)\nwork: 2 of 2 (all)\n"


def test_progress_is_a_bar_on_a_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """On a terminal a bar is drawn that shows what was done last."""
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    with progress("work") as report:
        report(1, 2, "half")
    shown = capsys.readouterr().err
    assert "\x1b[" in shown
    assert "half" in shown
