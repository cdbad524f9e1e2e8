"""The planned tests of a study as tables: of conditions, and of subpopulations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from reports.content import Folded, Table
from reports.study_tables import Column, by_key, plain_table
from reports.study_words import Row, condition_words, interval, percent, probability

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
GROUP_KINDS = ("interaction", "group")


def _test_words(row: Row) -> str:
    """Return what is tested; the condition's own name is said with its task."""
    condition, words = row["condition"], str(row["test"])
    if condition and words.startswith(f"{condition} "):
        return condition_words(row["task"], condition) + words.removeprefix(condition)
    return words


TEST_COLUMNS = (
    Column("Test", _test_words),
    Column("estimate", lambda row: percent(row["estimate"])),
    Column("interval", lambda row: interval(row["low"], row["high"])),
    Column("p", lambda row: probability(row["p"])),
    Column("p, Holm", lambda row: probability(row["p_holm"])),
    Column("result", lambda row: row["result"], "words"),
)


def planned_tables(document: Document) -> tuple[Table, Folded | None]:
    """Return every planned test with its p-value before and after Holm's correction.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    Table, Folded or None
        Tests of conditions; those of subpopulations, None if there are none.
    """
    of_groups = [row for row in document["tests"] if row["kind"] in GROUP_KINDS]
    others = [row for row in document["tests"] if row["kind"] not in GROUP_KINDS]
    caption = (
        "Planned tests, estimates in percent or percentage points with intervals by subject (of"
        " equivalence, the one that its two one-sided tests amount to). Holm's correction is over"
        " tests of one kind in a family."
    )
    caution = (
        "Tests of subpopulations. That a difference is seen in one group and not in another is no"
        " difference between the groups: only these tests say so."
    )
    main = _tests(document, "tests", caption, others, TEST_COLUMNS)
    if not of_groups:
        return main, None
    short = tuple(column for column in TEST_COLUMNS if column.head not in {"estimate", "interval"})
    folded = _tests(document, "group-tests", caution, of_groups, short)
    return main, Folded("Do subpopulations differ?", (folded,))


def _tests(
    document: Document,
    identifier: str,
    caption: str,
    rows: Sequence[Row],
    columns: Sequence[Column],
) -> Table:
    groups = [
        (f"{family}: {KINDS.get(kind, kind)}", of_kind)
        for family, own in by_key(rows, "family").items()
        for kind, of_kind in by_key(own, "kind").items()
    ]
    return plain_table(document, identifier, caption, columns, groups, ["tests"])
