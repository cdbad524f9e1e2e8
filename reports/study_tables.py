"""The tables of a study's report; every one of them carries the mark of its data."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from reports.content import Cell, Folded, Group, Table
from reports.rows_behind import Rows, rows_behind
from reports.study_words import (
    GROUPS,
    NOTHING,
    Row,
    condition_words,
    decimal,
    interval,
    level_words,
    number_or_nan,
    percent,
    probability,
)

Document = Mapping[str, Any]
KINDS = {
    "chance": "against chance",
    "equivalence": "equivalence with chance",
    "difference": "differences of conditions",
    "interaction": "interactions with subpopulations",
    "group": "differences between subpopulations",
    "side": "side bias",
    "learning": "learning",
}
"""Kinds of planned tests as headings."""


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
                ("twoway", "subjects and items"),
            )
        ),
    )
    caption = (
        "{words}: rate of choosing the target, and 95 % intervals: Wilson's, as if all trials were"
        " independent; cluster-robust by subject, with Student's t; and two-way, for other subjects"
        " and other scenes like these."
    )
    tables = tuple(
        plain_table(
            document,
            f"rates-{number}",
            caption.replace("{words}", words),
            columns,
            [("", rows)],
            ["rates"],
        )
        for number, (words, rows) in enumerate(by_condition(document["rates"]).items(), start=1)
    )
    return Folded("All rates with their intervals", tables)


def full_rates(document: Document) -> list[dict[str, Any]]:
    """Return the rates, each with the paper's own deviation as ``deviation``, None without one.

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
    deviations = _values(document["deviations"])
    return [
        {**row, "deviation": deviations.get(key, {}).get("deviation")}
        for row in document["rates"]
        for key in _values([row])
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


def model_table(document: Document) -> Table:
    """Return the coefficients of all models, on the logit scale.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    Table
    """
    columns = (
        Column("Term", lambda row: row["term"]),
        Column("estimate", lambda row: decimal(row["estimate"], 4), "ours"),
        Column("standard error", lambda row: decimal(row.get("se"), 4)),
        Column("z", lambda row: decimal(_ratio(row), 2)),
        Column("p", lambda row: probability(two_sided(_ratio(row)))),
    )
    caption = (
        "Models of the choice, coefficients on the logit scale: crossed logistic mixed models"
        " (Laplace) with subjects and items, and GEE clustered by subject as confirmation. Terms"
        " `sd` are standard deviations of random effects."
    )
    return plain_table(
        *(document, "models", caption, columns),
        by_key(document["models"], "model").items(),
        ["models"],
    )


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


def _ratio(row: Row) -> float | None:
    error = number_or_nan(row.get("se"))
    return number_or_nan(row["estimate"]) / error if error > 0 else None


def two_sided(z: float | None) -> float | None:
    """Return the two-sided p-value of a standard normal value, None for None.

    Parameters
    ----------
    z : float or None

    Returns
    -------
    float or None

    Examples
    --------
    >>> round(two_sided(1.959964), 6)
    0.05
    """
    return None if z is None else math.erfc(abs(z) / math.sqrt(2))


def exclusion_table(document: Document) -> Table:
    """Return who was left out and why.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    Table
    """
    columns = (
        Column("Step", lambda row: row["reason"]),
        Column("subjects left out", lambda row: str(row["subjects"])),
        Column("trials left out", lambda row: str(row["trials"])),
        Column("subjects that remain", lambda row: str(row["remaining_subjects"])),
        Column("trials that remain", lambda row: str(row["remaining_trials"])),
    )
    caption = "Exclusions by the rules fixed beforehand, in the order in which they are applied."
    return plain_table(
        document, "exclusions", caption, columns, [("", document["exclusions"])], ["exclusions"]
    )


def planned_table(document: Document) -> Table:
    """Return every planned test with its p-value before and after Holm's correction.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    Table
    """
    columns = (
        Column("Test", lambda row: row["test"]),
        Column("estimate", lambda row: percent(row["estimate"])),
        Column("interval", lambda row: interval(row["low"], row["high"])),
        Column("p", lambda row: probability(row["p"])),
        Column("p, Holm", lambda row: probability(row["p_holm"])),
        Column("result", lambda row: row["result"], "words"),
    )
    caption = (
        "Planned tests, estimates in percent or percentage points with intervals by subject (of"
        " equivalence, the 90 % interval that its two one-sided tests amount to). Holm's correction"
        " is over tests of one kind in a family. That a difference is seen in one group and not in"
        " another is no difference between the groups: only the test of the groups says so."
    )
    families = by_key(document["tests"], "family").items()
    groups = [
        (f"{family}: {KINDS.get(kind, kind)}", rows)
        for family, own in families
        for kind, rows in by_key(own, "kind").items()
    ]
    return plain_table(document, "tests", caption, columns, groups, ["tests"])


def everyone_table(document: Document) -> Table:
    """Return the rates of everybody beside those after exclusions.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    Table
    """
    kept = _values(row for row in document["rates"] if row["group"] == "all")
    pairs = [
        {"name": condition_words(*key[:2]), "everyone": row, "kept": kept[key]}
        for key, row in _values(document["rates_with_everyone"]).items()
        if key in kept
    ]
    columns = (
        Column("Condition", lambda pair: pair["name"]),
        *(
            Column(f"{words}, {head}", lambda pair, key=key, text=text: text(pair[key]), role)  # type: ignore[misc]
            for key, words in (("everyone", "everybody"), ("kept", "after exclusions"))
            for head, text, role in (
                ("trials", lambda row: str(row["trials"]), ""),
                ("%", lambda row: percent(row["rate"]), "ours"),
                (
                    "by subject",
                    lambda row: interval(row["cluster_low"], row["cluster_high"]),
                    "",
                ),
            )
        ),
    )
    caption = "What the exclusions change: rates with everybody's answers, and without those left"
    parts = ["rates_with_everyone", "rates"]
    return plain_table(document, "with-everyone", f"{caption} out.", columns, [("", pairs)], parts)


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


def table3(document: Document) -> Table:
    """Return the paper's Table 3: measured here beside published, by subpopulation.

    Parameters
    ----------
    document : mapping
        Its ``table3`` is a list of the conditions, each with ``task``, ``condition``, ``title``.

    Returns
    -------
    Table
    """
    conditions = document["table3"]
    head = (
        (Cell("Subpopulation", role="head", rows=2), *_wide_heads(conditions)),
        tuple(
            Cell(words, role="head", edge=words == "trials")
            for _ in conditions
            for words in ("trials", "here", "published")
        ),
    )
    measured, published = (_values(rows) for rows in (full_rates(document), document["published"]))
    names = dict.fromkeys((group, level) for _, _, group, level in (*measured, *published))
    wanted = [name for name in names if any(_has(published, c, name) for c in conditions)]
    groups = by_group(wanted)
    body = tuple(
        Group(
            GROUPS.get(group, group) if group != "all" else "",
            tuple(_table3_row(measured, published, conditions, (group, level)) for level in levels),
        )
        for group, levels in groups.items()
    )
    caption = (
        "Table 3: how often an inserted object was taken for the real picture, in percent, with the"
        " paper's own deviation and, below it, the 95 % interval that is robust to what one"
        " subject's answers have in common. An optimal result would be 50 %."
    )
    behind = rows_behind(document, "rates", "deviations", "published")
    return Table("table3", marked(document, caption), head, body, behind)


def by_group(names: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """Return the levels of each group, in the order they come.

    Parameters
    ----------
    names : iterable of (group, level)

    Returns
    -------
    dict

    Examples
    --------
    >>> by_group([("half", "1st half"), ("half", "2nd half")])
    {'half': ['1st half', '2nd half']}
    """
    found: dict[str, list[str]] = {}
    for group, level in names:
        found.setdefault(group, []).append(level)
    return found


Key = tuple[str, str, str, str]


def _values(rows: Iterable[Row]) -> dict[Key, Row]:
    return {(row["task"], row["condition"], row["group"], row["level"]): row for row in rows}


def _key(condition: Row, name: tuple[str, str]) -> Key:
    return (condition["task"], condition["condition"], *name)


def _has(rows: Mapping[Key, Row], condition: Row, name: tuple[str, str]) -> bool:
    return _key(condition, name) in rows


def _wide_heads(conditions: Sequence[Row]) -> tuple[Cell, ...]:
    return tuple(Cell(one["title"], role="head", columns=3, edge=True) for one in conditions)


def _table3_row(
    measured: Mapping[Key, Row],
    published: Mapping[Key, Row],
    conditions: Sequence[Row],
    name: tuple[str, str],
) -> tuple[Cell, ...]:
    cells = [Cell(level_words(*name), role="head")]
    for condition in conditions:
        ours, theirs = (rows.get(_key(condition, name)) for rows in (measured, published))
        cells += _measured_cells(ours)
        cells.append(Cell(_with_deviation(theirs), role="published", note=_trials(theirs)))
    return tuple(cells)


def _measured_cells(row: Row | None) -> list[Cell]:
    if row is None or row["rate"] is None:
        return [Cell(NOTHING, edge=True), Cell("not measured", role="absent")]
    ends = interval(row["cluster_low"], row["cluster_high"])
    return [
        Cell(str(row["trials"]), note=f"{row['subjects']} subjects", edge=True),
        Cell(_with_deviation(row), role="ours", note=ends),
    ]


def _with_deviation(row: Row | None) -> str:
    if row is None:
        return NOTHING
    deviation = percent(row.get("deviation"))
    rate = percent(row["rate"])
    return rate if deviation == NOTHING else f"{rate} ± {deviation}"


def _trials(row: Row | None) -> str:
    return "" if row is None else f"{row['trials']} trials"
