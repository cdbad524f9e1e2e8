"""What the command line shows: lines, tables and progress.

Results go to standard output, progress to standard error, so that a result can be piped.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeAlias

from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

Report: TypeAlias = Callable[[int, int, str], None]
"""Called with how much is done, how much there is in all, and what was done last."""

MOST_LINES = 20
"""Lines of progress at most, where there is no terminal to draw a bar on."""

_WIDTH_OF_A_FILE = 160


def say(*lines: str) -> None:
    """Print lines to standard output as they are.

    Parameters
    ----------
    *lines : str

    Examples
    --------
    >>> say("as [it] is")
    as [it] is
    """
    console = _console()
    for line in lines:
        console.print(line, markup=False, soft_wrap=True)


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table; columns of which every entry is a number are aligned to the right.

    Parameters
    ----------
    title : str
    columns : sequence of str
    rows : sequence of sequences of str
        An empty row draws a line.

    Examples
    --------
    >>> print_table("Fruit", ["name", "weight"], [["apple", "0.2"], ["pear", "0.3"]])
    Fruit
      name    weight
     ────────────────
      apple      0.2
      pear       0.3
    """
    table = Table(box=box.SIMPLE_HEAD, show_edge=False)
    for index, column in enumerate(columns):
        entries = [row[index] for row in rows if row]
        table.add_column(column, justify="right" if _all_numbers(entries) else "left")
    for row in rows:
        if row:
            table.add_row(*(entry.replace("[", r"\[") for entry in row))
        else:
            table.add_section()
    console = _console()
    console.print(title, style="bold", markup=False, soft_wrap=True)
    console.print(table)


@contextmanager
def progress(title: str) -> Iterator[Report]:
    """Yield a function that shows how far long work has come.

    On a terminal it draws a bar, which goes when the block ends; elsewhere it prints at most
    `MOST_LINES` plain lines.

    Parameters
    ----------
    title : str
        What is being done.

    Yields
    ------
    Report
    """
    console = Console(stderr=True, highlight=False)
    if not console.is_terminal:
        yield PlainProgress(title, console)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[latest]}"),
    )
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(title, total=None, latest="")
        yield lambda done, total, latest: bar.update(
            task, completed=done, total=total, latest=latest
        )


class PlainProgress:
    """Progress in lines, at most `MOST_LINES` of them.

    Parameters
    ----------
    title : str
    console : Console

    Examples
    --------
    >>> report = PlainProgress("counting", Console(file=sys.stdout))
    >>> for done in range(1, 101):
    ...     report(done, 100, str(done)) if done < 11 else None
    counting: 5 of 100 (5)
    counting: 10 of 100 (10)
    """

    def __init__(self, title: str, console: Console) -> None:
        self._title = title
        self._console = console
        self._shown = 0

    def __call__(self, done: int, total: int, latest: str) -> None:
        """Print a line if enough has been done since the last one."""
        step = done * MOST_LINES // max(total, 1)
        if step > self._shown:
            self._shown = step
            line = f"{self._title}: {done} of {total} ({latest})"
            self._console.print(line, markup=False, soft_wrap=True)


def _console() -> Console:
    terminal = sys.stdout.isatty()
    return Console(file=sys.stdout, width=None if terminal else _WIDTH_OF_A_FILE, highlight=False)


def _all_numbers(entries: Sequence[str]) -> bool:
    return bool(entries) and all(_is_number(entry) for entry in entries)


def _is_number(entry: str) -> bool:
    digits = entry.removeprefix("-").replace(".", "", 1).replace(",", "")
    return entry in {"", "-"} or digits.isdigit()
