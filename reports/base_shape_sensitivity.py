"""How the order of base shapes hangs on the choices of the protocol: a table and its reading."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from evaluation.base_shapes import RIVAL_SHAPES
from reports.base_shape_tables import by_rule, head_of
from reports.base_shape_words import (
    SENSITIVITY_CAPTION,
    Document,
    file_of,
    key_of,
    measured_shapes,
    short_words,
)
from reports.content import Cell, Group, Table
from reports.rows_behind import rows_behind
from reports.table1_tables import NONE, number, stamped

Row = Mapping[str, Any]
LAYOUT = "sensitivity"
"""Of these tables; their second column is words."""


def sensitivity_table(document: Document, words: Mapping[str, str]) -> Table:
    """Return the errors and the order of the shapes in every variant that was measured.

    Parameters
    ----------
    document : mapping
    words : mapping of str

    Returns
    -------
    Table
    """
    shapes, called = measured_shapes(document), short_words(words)
    groups = tuple(
        Group(title, tuple(_variant_cells(row, rows[0], shapes, called) for row in rows))
        for title, rows in by_rule(document, "sensitivity")
    )
    return Table(
        f"base-shape-sensitivity-{key_of(document)}",
        stamped(dict(document), SENSITIVITY_CAPTION),
        (head_of(("Built from, or changed", "order", *(called[s] for s in shapes))),),
        groups,
        rows_behind(document, "sensitivity", file=file_of(document)),
        layout=LAYOUT,
    )


def changed_orders(rows: Sequence[Row]) -> tuple[Row, ...]:
    """Return the variants under one rule whose order is not that of the first.

    Parameters
    ----------
    rows : sequence of mappings
        Of the document's ``sensitivity``, the table's own variant first.

    Returns
    -------
    tuple of mappings

    Examples
    --------
    >>> first = {"variant": "mean", "order": ["kinect", "sirfs", "contour"]}
    >>> other = {"variant": "leave-one-out", "order": ["contour", "kinect"]}
    >>> [row["variant"] for row in changed_orders([first, other])]
    ['leave-one-out']
    """
    return tuple(row for row in rows if not _same_order(row, rows[0]))


def _same_order(row: Row, first: Row) -> bool:
    """Return whether shapes measured in both come in the same order."""
    both = set(row["order"]) & set(first["order"])
    orders = [[shape for shape in one["order"] if shape in both] for one in (row, first)]
    return orders[0] == orders[1]


def sensitivity_words(document: Document) -> str:
    """Return under which choices the order of the shapes is another, in sentences.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    str
        Empty where only the table's own variant was measured.
    """
    said = []
    for title, rows in by_rule(document, "sensitivity"):
        others = rows[1:]
        changed = [row["words"] for row in changed_orders(rows)]
        if not others:
            continue
        kept = f"the order holds in {len(others) - len(changed)} of {len(others)} variants"
        where = f", and changes with: {', '.join(changed)}" if changed else ""
        said.append(f"{title}: {kept}{where}.")
    return " ".join(said)


def _variant_cells(
    row: Row, first: Row, shapes: Sequence[str], words: Mapping[str, str]
) -> tuple[Cell, ...]:
    order = " < ".join(words[shape].removesuffix(" (simulated)") for shape in row["order"]) or NONE
    same = _same_order(row, first)
    note = "" if row is first else ("the same" if same else "changes")
    if same and len(row["order"]) < len(first["order"]):
        note = "the same, as far as measured"
    known = [row["imse"].get(s) for s in RIVAL_SHAPES if row["imse"].get(s) is not None]
    lowest = min(known) if known and len(row["order"]) == len(first["order"]) else None
    return (
        Cell(row["words"], role="head"),
        Cell(order, note, role="" if same else "ours"),
        *(
            Cell(number(value), role="ours" if value is not None and value == lowest else "")
            for value in (row["imse"].get(shape) for shape in shapes)
        ),
    )
