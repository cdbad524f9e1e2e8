"""The tables of the Table 2 report: errors by shape, pairs of shapes, and objects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from evaluation.base_shape_table import REFERENCE
from reports.base_shape_comparison import (
    SAME,
    can_decide,
    compared,
    judged_rules,
    p_words,
    reported_rules,
)
from reports.base_shape_words import (
    OBJECTS_CAPTION,
    PAIRS_CAPTION,
    RULE_WORDS,
    TABLE_CAPTION,
    Document,
    file_of,
    key_of,
    measured_shapes,
)
from reports.content import Cell, Group, Table
from reports.rows_behind import rows_behind
from reports.table1_tables import NONE, number, stamped

Row = Mapping[str, Any]
TOO_FEW = "too few objects"


def shape_table(document: Document, words: Mapping[str, str]) -> Table:
    """Return Table 2: our errors beside the published ones, rules in groups.

    Parameters
    ----------
    document : mapping
    words : mapping of str
        What the shapes are called.

    Returns
    -------
    Table
    """
    above = (
        Cell("Base shape", role="head", rows=2),
        *(Cell(word, role="head", rows=2) for word in ("IMSE", "relative", "minus contour")),
        Cell("over contour", role="head", columns=2, edge=True),
        Cell("IMSE", role="head", edge=True),
    )
    below = tuple(
        Cell(word, role="head", edge=word != "published" or place == 2)
        for place, word in enumerate(("ours", "published", "published"))
    )
    groups = tuple(
        Group(title, tuple(_shape_cells(document, words, row) for row in rows))
        for title, rows in by_rule(document, "rows")
    )
    behind = rows_behind(document, "rows", "published", file=file_of(document))
    return Table(
        f"table-2-{key_of(document)}-errors",
        stamped(dict(document), TABLE_CAPTION),
        (above, below),
        groups,
        behind,
        layout="base-shapes",
    )


def pair_table(document: Document, words: Mapping[str, str]) -> Table:
    """Return wins and tests of the pairs of the paper's shapes.

    Parameters
    ----------
    document : mapping
    words : mapping of str

    Returns
    -------
    Table
    """
    heads = ("Pair", "first lower", "second lower", "median, % of I²", "p", "p, Holm", "reading")
    groups = tuple(
        Group(title, tuple(_pair_cells(document, words, row) for row in rows))
        for title, rows in by_rule(document, "pairs")
    )
    return Table(
        f"base-shape-pairs-{key_of(document)}",
        stamped(dict(document), PAIRS_CAPTION),
        (head_of(heads),),
        groups,
        rows_behind(document, "pairs", "tests", file=file_of(document)),
        layout="pairs",
    )


def object_table(document: Document, words: Mapping[str, str]) -> Table:
    """Return the relative error of every object on every shape, for the published rules.

    Parameters
    ----------
    document : mapping
    words : mapping of str

    Returns
    -------
    Table
    """
    shapes = measured_shapes(document)
    groups = []
    for title, rows in by_rule(document, "objects", judged_rules(document)):
        errors = {(row["object"], row["shape"]): row["relative_imse"] for row in rows}
        names = dict.fromkeys(row["object"] for row in rows)
        lines = tuple(
            (Cell(name, role="head"), *(_percent(errors.get((name, shape))) for shape in shapes))
            for name in names
        )
        groups.append(Group(title, lines))
    return Table(
        f"base-shape-objects-{key_of(document)}",
        stamped(dict(document), OBJECTS_CAPTION),
        (head_of(("Object", *(words[shape] for shape in shapes))),),
        tuple(groups),
        rows_behind(document, "objects", file=file_of(document)),
    )


def by_rule(
    document: Document, part: str, rules: Sequence[str] = ()
) -> list[tuple[str, list[Row]]]:
    """Return the rows of a part by weight rule, with the words for it.

    Parameters
    ----------
    document : mapping
    part : str
        A key of the document.
    rules : sequence of str
        Those wanted; by default all that there is something to report of.

    Returns
    -------
    list of (str, list)
    """
    found: dict[str, list[Row]] = {rule: [] for rule in rules or reported_rules(document)}
    for row in document[part]:
        if row["weights"] in found:
            found[row["weights"]].append(row)
    return [(RULE_WORDS.get(rule, rule), own) for rule, own in found.items() if own]


def head_of(words: Sequence[str]) -> tuple[Cell, ...]:
    """Return words as the cells of a table's head.

    Parameters
    ----------
    words : sequence of str

    Returns
    -------
    tuple of Cell
    """
    return tuple(Cell(word, role="head") for word in words)


def _shape_cells(document: Document, words: Mapping[str, str], row: Row) -> tuple[Cell, ...]:
    shape, rule = row["shape"], row["weights"]
    printed = {e["shape"]: e["imse"] for e in document["published"] if e["weights"] == rule}
    ours = {e["shape"]: e["imse"] for e in document["rows"] if e["weights"] == rule}
    share = row["relative_imse"]
    return (
        Cell(words[shape], role="head"),
        _spread(row, "imse", ("low", "high"), ".5f", "ours"),
        Cell(NONE if share is None else f"{100 * share:.1f} %"),
        Cell(NONE)
        if shape == REFERENCE
        else _spread(row, "difference", ("difference_low", "difference_high"), "+.5f"),
        Cell(number(_ratio(ours, shape), 2), edge=True),
        Cell(number(_ratio(printed, shape), 2), role="published"),
        Cell(number(printed.get(shape), 4), role="published", edge=True),
    )


def _spread(row: Row, key: str, ends: tuple[str, str], form: str, role: str = "") -> Cell:
    """Return a value with its interval, where there is one, below it."""
    if row[key] is None:
        return Cell("missing", role="absent")
    low, high = (row[end] for end in ends)
    interval = "" if low is None or row["objects"] < 2 else f"{low:{form}} to {high:{form}}"
    return Cell(_signed(f"{row[key]:{form}}"), _signed(interval), role)


def _signed(text: str) -> str:
    """Return a number with a minus sign as wide as its plus sign."""
    return text.replace("-", "−")  # noqa: RUF001  a minus sign


def _ratio(errors: Mapping[str, float | None], shape: str) -> float | None:
    value, unit = errors.get(shape), errors.get(REFERENCE)
    return value / unit if value is not None and unit else None


def _percent(share: float | None) -> Cell:
    return Cell(NONE if share is None else f"{100 * share:.1f}")


def _pair_cells(document: Document, words: Mapping[str, str], row: Row) -> tuple[Cell, ...]:
    first, second = row["first"], row["second"]
    found = compared(document, first, second, row["weights"])
    median = row["median_difference"]
    decided = can_decide(document)
    reading = TOO_FEW
    if found is not None and decided:
        reading = "not told apart" if found.word == SAME else f"first {found.word}"
    return (
        Cell(f"{words[first]}, {words[second]}", role="head"),
        Cell(str(row["wins"])),
        Cell(str(row["losses"])),
        Cell(NONE if median is None else _signed(f"{100 * median:+.1f}")),
        Cell(p_words(row["p"])),
        Cell(p_words(row["p_holm"])),
        Cell(reading),
    )
