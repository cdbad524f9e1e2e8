"""The paper's Table 3, measured here beside published."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from reports.content import Cell, Group, Table
from reports.rows_behind import rows_behind
from reports.study_tables import Key, full_rates, marked, rows_by_name
from reports.study_words import GROUPS, NOTHING, Row, counted, interval, level_words, percent

Document = Mapping[str, Any]


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
    measured, published = (
        rows_by_name(rows) for rows in (full_rates(document), document["published"])
    )
    pairs = {(condition["task"], condition["condition"]) for condition in conditions}
    wanted = dict.fromkeys(
        (group, level)
        for task, condition, group, level in (*measured, *published)
        if (task, condition) in pairs and group != "side"
    )
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


def _key(condition: Row, name: tuple[str, str]) -> Key:
    return (condition["task"], condition["condition"], *name)


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
        Cell(str(row["trials"]), note=counted(row["subjects"], "subject"), edge=True),
        Cell(_with_deviation(row), role="ours", note=ends),
    ]


def _with_deviation(row: Row | None) -> str:
    if row is None:
        return NOTHING
    deviation = percent(row.get("deviation"))
    rate = percent(row["rate"])
    return rate if deviation == NOTHING else f"{rate} ± {deviation}"


def _trials(row: Row | None) -> str:
    return "" if row is None else counted(row["trials"], "trial")
