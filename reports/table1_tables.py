"""The tables of the Table 1 report: entries beside the published ones, and provenance."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from reports.content import Cell, Group, Table
from reports.rows_behind import TABLE1_FILE, Rows, rows_behind
from reports.table1_entries import (
    LEFT_OUT,
    NO_RULE,
    PUBLISHED_RULES,
    RULES,
    Entry,
    EntryRow,
    has_rival,
    is_quick,
    table1_rows,
)

NONE = "–"  # noqa: RUF001  an en dash: no value
OWN_RULES = tuple(rule for rule in RULES if rule not in PUBLISHED_RULES)
SHOWN_MISSING = 12
CAPTION = (
    "Mean re-rendering error IMSE\u2032 over all objects and lights; below it, relative to the mean"
    " of the squared target. Columns are the rules that choose the weights. Ratio: ours over"
    " published, alike if within a tenth."
)
HELD_OUT_CAPTION = (
    "The same over the test objects of MIT-Berkeley alone. The priors of SIRFS were trained on the"
    " other ten, so that B+M and the rows (b) are optimistic on those; the published table is over"
    " all objects."
)


def number(value: float | None, digits: int = 5) -> str:
    """Return a number with fixed decimals, a dash for None.

    Parameters
    ----------
    value : float or None
    digits : int

    Examples
    --------
    >>> number(0.5, 2)
    '0.50'
    """
    return NONE if value is None else f"{value:.{digits}f}"


def entry_table(document: dict[str, Any], settings: Iterable[str]) -> Table:
    """Return Table 1: our entries beside the published ones, with ratio and verdict word.

    Parameters
    ----------
    document : dict
        See `evaluation.table1_results.table1_document`.
    settings : iterable of str

    Returns
    -------
    Table
    """
    behind = rows_behind(document, "rows", "baselines", "published")
    return _entry_table("entries", CAPTION, behind, document, settings)


def held_out_table(document: dict[str, Any], settings: Iterable[str]) -> Table | None:
    """Return Table 1 over the objects that no prior of SIRFS was trained on.

    Parameters
    ----------
    document : dict
    settings : iterable of str

    Returns
    -------
    Table or None
        None where there are no such objects, or the run left SIRFS out.
    """
    inner = document | {"rows": document.get("test_rows") or [], "baselines": []}
    if not has_rival(inner):
        return None
    behind = rows_behind(document, "test_rows", "published")
    return _entry_table("entries-held-out", HELD_OUT_CAPTION, behind, inner, settings)


def _entry_table(
    identifier: str, caption: str, behind: Rows, document: dict[str, Any], settings: Iterable[str]
) -> Table:
    above = (
        Cell("Model", role="head", rows=2),
        *(Cell(rule, role="head", rows=2) for rule in OWN_RULES),
        *(Cell(rule, role="head", columns=3, edge=True) for rule in PUBLISHED_RULES),
    )
    below = tuple(
        Cell(word, role="head", edge=word == "ours")
        for _ in PUBLISHED_RULES
        for word in ("ours", "published", "ratio")
    )
    groups = tuple(
        Group(
            f"Models from the {setting} photographs",
            tuple(_entry_cells(row) for row in table1_rows(document, setting)),
        )
        for setting in settings
    )
    return Table(identifier, stamped(document, caption), (above, below), groups, behind)


def stamped(document: dict[str, Any], caption: str) -> str:
    """Return the caption of a table with what is left out or missing before it.

    Parameters
    ----------
    document : dict
    caption : str

    Returns
    -------
    str

    Examples
    --------
    >>> stamped({"quick": True, "missing": []}, "Errors.")
    '{QUICK: without SIRFS.} Errors.'
    """
    missing = len(document["missing"])
    words = ["QUICK: without SIRFS."] if is_quick(document) else []
    words += [f"INCOMPLETE: {missing} cell{'s' if missing > 1 else ''} missing."] if missing else []
    return " ".join([*(f"{{{word}}}" for word in words), caption])


def _entry_cells(row: EntryRow) -> tuple[Cell, ...]:
    title = Cell(row.title, role="head")
    left_out = Cell(LEFT_OUT, role="absent", columns=len(OWN_RULES))
    if NO_RULE in row.entries:
        words = Cell("no weights to choose", role="quiet", columns=len(OWN_RULES))
        words = left_out if row.is_open else words
        same = Cell("the same for every rule", role="quiet", columns=3, edge=True)
        return (title, words, *_beside(row.entries[NO_RULE]), same)
    if "own" in row.entries:
        words = Cell("not in the published table", role="quiet", columns=6)
        return (title, replace(ours_cell(row.entries["own"]), columns=len(OWN_RULES)), words)
    if len(row.entries) == 1:
        words = Cell("no detail layers; not in the published table", role="quiet", columns=8)
        return (title, ours_cell(row.entries["coarse"]), words)
    own = [left_out] if row.is_open else [ours_cell(row.entries[rule]) for rule in OWN_RULES]
    beside = [cell for rule in PUBLISHED_RULES for cell in _beside(row.entries[rule])]
    return (title, *own, *beside)


def ours_cell(entry: Entry, edge: bool = False) -> Cell:
    """Return a measured entry with its relative error below it, or why there is none.

    Parameters
    ----------
    entry : Entry
    edge : bool

    Returns
    -------
    Cell

    Examples
    --------
    >>> ours_cell(Entry(0.005, 0.07))
    Cell(text='0.00500', note='7.0 %', role='', columns=1, rows=1, edge=False)
    """
    if entry.imse is None:
        return Cell(entry.absent, role="absent", edge=edge)
    share = "" if entry.relative is None else f"{100 * entry.relative:.1f} %"
    return Cell(number(entry.imse), share, "ours" if edge else "", edge=edge)


def _beside(entry: Entry) -> tuple[Cell, ...]:
    ratio = Cell(number(entry.ratio, 2), entry.word)
    printed = Cell(number(entry.published, 4), role="published")
    return (ours_cell(entry, edge=True), printed, ratio)


def provenance_table(provenance: dict[str, Any]) -> Table:
    """Return what is needed to run a result again.

    Parameters
    ----------
    provenance : dict
        Of `evaluation.provenance.Provenance.document`.

    Returns
    -------
    Table
    """
    workers = provenance["workers"]
    facts = {
        "protocol": Cell(provenance["protocol"]),
        "dataset": Cell(provenance["dataset"]),
        "data hash (SHA-256)": Cell(provenance["data_hash"], role="code"),
        "commit": Cell(provenance["commit"], role="code"),
        "cells done": Cell(str(provenance["cells_done"])),
        "cells missing": Cell(str(provenance["cells_missing"])),
        **{f"seed of {key}": Cell(seed, role="code") for key, seed in provenance["seeds"].items()},
        "run time": Cell(f"{provenance['seconds']} s, workers: {workers}"),
        "machine": Cell(provenance["machine"]),
        "Python": Cell(provenance["python"]),
        "versions": Cell(", ".join(f"{n} {v}" for n, v in provenance["versions"].items())),
    }
    rows = tuple((Cell(name, role="head"), cell) for name, cell in facts.items())
    return Table("facts", "What is needed to run this again.", (), (Group("", rows),))


def rows_table(tied: Iterable[tuple[str, Rows]]) -> Table:
    """Return which rows every table and figure was made from.

    Parameters
    ----------
    tied : iterable of (str, Rows)
        As `reports.content.tied_blocks` gives them.

    Returns
    -------
    Table
    """
    words = ("table or figure", "parts of the results", "rows", "SHA-256")
    head = tuple(Cell(word, role="head") for word in words)
    rows = tuple(
        (
            Cell(identifier, role="head"),
            Cell(_parts_words(behind)),
            Cell(str(behind.count)),
            Cell(behind.digest, role="code"),
        )
        for identifier, behind in tied
    )
    caption = (
        f"The rows behind each table and figure, as parts of `results/{TABLE1_FILE}` or of the file"
        " named with them. The hash is over the JSON text of the list of these parts, keys sorted,"
        " no spaces."
    )
    return Table("rows-behind", caption, (head,), (Group("", rows),))


def _parts_words(behind: Rows) -> str:
    words = ", ".join(behind.parts)
    return words if behind.file == TABLE1_FILE else f"{behind.file}: {words}"


def missing_words(document: dict[str, Any]) -> tuple[str, ...]:
    """Return the missing cells with the reasons, one sentence each; the last counts the rest.

    Parameters
    ----------
    document : dict

    Returns
    -------
    tuple of str
    """
    missing = document["missing"]
    shown = [
        f"{', '.join(value for axis, value in cell.items() if axis != 'reason')}: {cell['reason']}"
        for cell in missing[:SHOWN_MISSING]
    ]
    more = len(missing) - len(shown)
    return (*shown, f"and {more} more, all in results/table1.json") if more else tuple(shown)
