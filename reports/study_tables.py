"""The tables of a study's report; every one of them carries the mark of its data."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from reports.content import Cell, Folded, Group, Table
from reports.rows_behind import Rows, rows_behind
from reports.study_words import (
    Row,
    condition_words,
    interval,
    level_words,
    percent,
)

Document = Mapping[str, Any]
Key = tuple[str, str, str, str]
"""Task, condition, group and level of a row."""
BESIDE = ("deviation", "bootstrap_low", "bootstrap_high")
"""Values of a rate that the document keeps apart: the paper's deviation, and one more interval."""


@dataclass(frozen=True)
class Column:
    """A column of a table: its head, and what it shows of a row."""

    head: str
    text: Callable[[Row], str]
    role: str = ""


def marked(document: Document, caption: str) -> str:
    """Return a caption behind the mark of simulated or pilot data.

    Parameters
    ----------
    document : mapping
        Its ``mark`` is empty for real data.
    caption : str

    Returns
    -------
    str

    Examples
    --------
    >>> marked({"mark": "SIMULATED"}, "Rates."), marked({"mark": ""}, "Rates.")
    ('{SIMULATED DATA.} Rates.', 'Rates.')
    """
    return f"{{{document['mark']} DATA.}} {caption}" if document["mark"] else caption


def plain_table(
    document: Document,
    identifier: str,
    caption: str,
    columns: Sequence[Column],
    groups: Iterable[tuple[str, Iterable[Row]]],
    parts: Sequence[str],
) -> Table:
    """Return rows as a table, with the data's mark in its caption.

    Parameters
    ----------
    document : mapping
    identifier, caption : str
    columns : sequence of Column
        The first is the head of each row.
    groups : iterable of (title, rows)
    parts : sequence of str
        Parts of the document that the rows are of.

    Returns
    -------
    Table
    """
    head = tuple(Cell(column.head, role="head") for column in columns)
    body = tuple(
        Group(title, tuple(_cells(columns, row) for row in rows)) for title, rows in groups
    )
    behind: Rows | None = rows_behind(document, *parts) if parts else None
    return Table(identifier, marked(document, caption), (head,), body, behind)


def _cells(columns: Sequence[Column], row: Row) -> tuple[Cell, ...]:
    first, *others = columns
    return (
        Cell(first.text(row), role="head"),
        *(Cell(column.text(row), role=column.role) for column in others),
    )


def rates_tables(document: Document) -> Folded:
    """Return all rates with their three intervals, a table for each task and condition.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    Folded
    """
    columns = (
        Column("Subpopulation", lambda row: level_words(row["group"], row["level"])),
        Column("trials", lambda row: str(row["trials"])),
        Column("subjects", lambda row: str(row["subjects"])),
        Column("chosen %", lambda row: percent(row["rate"]), "ours"),
        *(
            Column(words, lambda row, key=key: interval(row[f"{key}_low"], row[f"{key}_high"]))  # type: ignore[misc]
            for key, words in (
                ("wilson", "Wilson"),
                ("cluster", "by subject"),
                ("bootstrap", "bootstrap"),
                ("twoway", "subjects and items"),
            )
        ),
    )
    caption = (
        "{words}: rate of choosing the target, and 95 % intervals: Wilson's, as if all trials were"
        " independent; cluster-robust by subject, with Student's t; of subjects drawn anew; and"
        " two-way, for other subjects and other scenes like these."
    )
    tables = tuple(
        plain_table(
            document,
            f"rates-{number}",
            caption.replace("{words}", words),
            columns,
            [("", rows)],
            ["rates", "deviations"],
        )
        for number, (words, rows) in enumerate(by_condition(full_rates(document)).items(), start=1)
    )
    return Folded("All rates with their intervals", tables)


def full_rates(document: Document) -> list[dict[str, Any]]:
    """Return the rates, each with the values `BESIDE` it, None without one.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    list of dict

    Examples
    --------
    >>> row = {"task": "t", "condition": "c", "group": "all", "level": "all", "rate": 0.5}
    >>> full_rates({"rates": [row], "deviations": []})[0]["deviation"]
    """
    deviations = rows_by_name(document["deviations"])
    return [
        {**row, **{name: deviations.get(key, {}).get(name) for name in BESIDE}}
        for row in document["rates"]
        for key in rows_by_name([row])
    ]


def by_condition(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Return rows by the words for their task and condition, in the order they come.

    Parameters
    ----------
    rows : iterable of Row

    Returns
    -------
    dict

    Examples
    --------
    >>> list(by_condition([{"task": "real", "condition": "ours"}]))
    ['real: ours']
    """
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(condition_words(row["task"], row["condition"]), []).append(row)
    return found


def by_key(rows: Iterable[Row], key: str) -> dict[str, list[Row]]:
    """Return rows by one of their values, in the order they come.

    Parameters
    ----------
    rows : iterable of Row
    key : str

    Returns
    -------
    dict

    Examples
    --------
    >>> by_key([{"model": "gee", "se": 1}], "model")
    {'gee': [{'model': 'gee', 'se': 1}]}
    """
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(str(row[key]), []).append(row)
    return found


def consistency_table(document: Document) -> Table:
    """Return the published deviations beside those that a binomial allows.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    Table
    """
    columns = (
        Column("Subpopulation", lambda row: level_words(row["group"], row["level"])),
        Column("trials", lambda row: str(row["trials"])),
        Column("rate %", lambda row: percent(row["rate"])),
        Column("printed deviation", lambda row: percent(row["deviation"]), "published"),
        Column("binomial error", lambda row: percent(row["binomial"], 2)),
        Column("finding", lambda row: row["finding"]),
    )
    caption = (
        "Whether the deviations printed in the paper's Table 3 can be standard errors of its rates:"
        " independent answers have the binomial one, answers that subjects have in common a larger"
        " one. One below it, by more than rounding, is less than chance alone would give."
    )
    return plain_table(
        *(document, "consistency", caption, columns),
        by_condition(document["consistency"]).items(),
        ["consistency"],
    )


def facts_table(document: Document) -> Table:
    """Return where the numbers come from.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    Table
        The caption is marked, too.
    """
    rows = tuple(
        (Cell(name, role="head"), Cell(str(value), role="code" if len(str(value)) > 39 else ""))
        for name, value in document["provenance"].items()
    )
    caption = marked(document, "Where these numbers come from.")
    return Table("facts", caption, (), (Group("", rows),))


def rows_by_name(rows: Iterable[Row]) -> dict[Key, Row]:
    """Return rows by task, condition, group and level.

    Parameters
    ----------
    rows : iterable of Row

    Returns
    -------
    dict
    """
    return {(row["task"], row["condition"], row["group"], row["level"]): row for row in rows}
