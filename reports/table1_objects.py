"""The tables of the Table 1 report that show every object."""

from __future__ import annotations

from typing import Any

from reports.content import Cell, Group, Table
from reports.rows_behind import rows_behind
from reports.table1_entries import MISSING, NO_RULE, PUBLISHED_RULES, RULES, Entry, has_rival
from reports.table1_tables import number, ours_cell, stamped

OBJECT_COLUMNS = {
    "(a) default": tuple(f"default {rule}" for rule in RULES),
    "(b) B+M S": tuple(f"sirfs-shading {rule}" for rule in PUBLISHED_RULES),
    "(c) GT S": tuple(f"gt-shading {rule}" for rule in PUBLISHED_RULES),
    "B+M": (f"default {NO_RULE}",),
}
"""Columns of the table by object: a heading, and the quantities of `object_values` below it."""
NEED_SIRFS = ("(b) B+M S", "B+M")


def object_values(document: dict[str, Any]) -> dict[str, dict[str, dict[str, Any]]]:
    """Return all that was measured on each object: by object, setting, then quantity.

    Parameters
    ----------
    document : dict

    Returns
    -------
    dict
        Quantities are ``lmse``, ``point_light_residual``, ``harmonic_residual`` and
        ``<detail source> <weight rule>``, of B+M ``default none``.
    """
    table: dict[str, dict[str, dict[str, Any]]] = {}
    for row in document["intrinsic"]:
        table.setdefault(row["object"], {})[row["setting"]] = dict(row)
    for row in document["objects"]:
        own = table[row["object"]][row["setting"]]
        own[f"{row['detail_source']} {row['weights']}"] = row["imse"]
    return table


def object_table(document: dict[str, Any], setting: str) -> Table:
    """Return all values of each object in one setting.

    Parameters
    ----------
    document : dict
    setting : str

    Returns
    -------
    Table
    """
    without = () if has_rival(document) else NEED_SIRFS
    columns = {title: c for title, c in OBJECT_COLUMNS.items() if title not in without}
    above = (
        Cell("Object", role="head", rows=2),
        *(Cell(title, role="head", columns=len(c), edge=True) for title, c in columns.items()),
        Cell("LMSE", role="head", rows=2, edge=True),
        Cell("residual", role="head", columns=2, edge=True),
    )
    below = tuple(
        Cell(word, role="head", edge=word == words[0])
        for words in (*(_rules(quantities) for quantities in columns.values()), ("points", "SH"))
        for word in words
    )
    rows = tuple(
        _object_cells(name, by_setting[setting], tuple(columns.values()))
        for name, by_setting in object_values(document).items()
        if setting in by_setting
    )
    caption = (
        f"Models from the {setting} photographs: IMSE\u2032 of each object, LMSE of Retinex, and"
        " root-mean-square residual of both light fits to the Retinex shading (mean 0.5)."
    )
    behind = rows_behind(document, "objects", "intrinsic")
    name, group = f"objects-{setting}", Group("", rows)
    return Table(name, stamped(document, caption), (above, below), (group,), behind)


def _rules(quantities: tuple[str, ...]) -> tuple[str, ...]:
    """Return the weight rules of quantities as short headings; none is the error itself."""
    short = {"regression": "regress", NO_RULE: "IMSE\u2032"}
    return tuple(short.get(q.split()[1], q.split()[1]) for q in quantities)


def _object_cells(
    name: str, own: dict[str, Any], columns: tuple[tuple[str, ...], ...]
) -> tuple[Cell, ...]:
    errors = [
        Cell(number(own.get(quantity)), edge=quantity == quantities[0])
        for quantities in columns
        for quantity in quantities
    ]
    residuals = (
        Cell(number(own["lmse"], 4), edge=True),
        Cell(number(own["point_light_residual"], 3), edge=True),
        Cell(number(own["harmonic_residual"], 3)),
    )
    return (Cell(name, role="head"), *errors, *residuals)


def own_object_table(document: dict[str, Any]) -> Table:
    """Return the error of every object in every row that the user added.

    Parameters
    ----------
    document : dict

    Returns
    -------
    Table
    """
    words = ("Object", "setting", "method", "details", "weights", "IMSE\u2032", "relative")
    head = tuple(Cell(word, role="head") for word in words)
    rows = tuple(
        (
            Cell(row["object"], role="head"),
            *(Cell(row[key]) for key in ("setting", "method", "detail_source", "weights")),
            ours_cell(Entry(row["imse"], absent=MISSING)),
            Cell(number(row["relative_imse"], 3)),
        )
        for row in document["own_objects"]
    )
    caption = "Error of each object in the rows that are no part of the published table."
    behind = rows_behind(document, "own_objects")
    return Table("objects-own", caption, (head,), (Group("", rows),), behind)
