"""The tables of the Table 1 report: entries beside the published ones, objects, provenance."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from reports.content import Cell, Group, Table
from reports.rows_behind import Rows, rows_behind
from reports.table1_entries import MISSING, PUBLISHED_RULES, RULES, Entry, EntryRow, table1_rows

NONE = "–"  # noqa: RUF001  an en dash: no value
OWN_RULES = tuple(rule for rule in RULES if rule not in PUBLISHED_RULES)
OBJECT_SOURCES = {"default": RULES, "gt-shading": PUBLISHED_RULES}
SHOWN_MISSING = 12
CAPTION = (
    "Mean re-rendering error IMSE\u2032 over all objects and lights; below it, relative to the mean"
    " of the squared target. Columns are the rules that choose the weights. Ratio: ours over"
    " published, alike if within a tenth."
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
    behind = rows_behind(document, "rows", "baselines", "published")
    return Table("entries", _stamped(document, CAPTION), (above, below), groups, behind)


def _stamped(document: dict[str, Any], caption: str) -> str:
    missing = len(document["missing"])
    if not missing:
        return caption
    return f"{{INCOMPLETE: {missing} cell{'s' if missing > 1 else ''} missing.}} {caption}"


def _entry_cells(row: EntryRow) -> tuple[Cell, ...]:
    title = Cell(row.title, role="head")
    if "none" in row.entries:
        sirfs = row.entries["none"]
        return (
            title,
            Cell(sirfs.absent, role="absent", columns=4),
            Cell(number(sirfs.published, 4), role="published"),
            Cell("no weights to choose", role="quiet", columns=4),
        )
    if "own" in row.entries:
        words = Cell("not in the published table", role="quiet", columns=6)
        return (title, replace(_ours(row.entries["own"]), columns=len(OWN_RULES)), words)
    if len(row.entries) == 1:
        words = Cell("no detail layers; not in the published table", role="quiet", columns=8)
        return (title, _ours(row.entries["coarse"]), words)
    own: tuple[Cell, ...]
    if row.is_open:
        own = (Cell(row.entries["coarse"].absent, role="absent", columns=len(OWN_RULES)),)
    else:
        own = tuple(_ours(row.entries[rule]) for rule in OWN_RULES)
    beside = [cell for rule in PUBLISHED_RULES for cell in _beside(row.entries[rule], row.is_open)]
    return (title, *own, *beside)


def _ours(entry: Entry, edge: bool = False) -> Cell:
    if entry.imse is None:
        return Cell(entry.absent, role="absent", edge=edge)
    share = "" if entry.relative is None else f"{100 * entry.relative:.1f} %"
    return Cell(number(entry.imse), share, "ours" if edge else "", edge=edge)


def _beside(entry: Entry, is_open: bool) -> tuple[Cell, ...]:
    ours = Cell("open", role="absent", edge=True) if is_open else _ours(entry, edge=True)
    ratio = Cell(number(entry.ratio, 2), entry.word)
    return (ours, Cell(number(entry.published, 4), role="published"), ratio)


def object_values(document: dict[str, Any]) -> dict[str, dict[str, dict[str, Any]]]:
    """Return all that was measured on each object: by object, setting, then quantity.

    Parameters
    ----------
    document : dict

    Returns
    -------
    dict
        Quantities are ``lmse``, ``point_light_residual``, ``harmonic_residual`` and
        ``<detail source> <weight rule>``.
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
    above = (
        Cell("Object", role="head", rows=2),
        Cell("(a) default", role="head", columns=len(RULES), edge=True),
        Cell("(c) GT S", role="head", columns=len(PUBLISHED_RULES), edge=True),
        Cell("LMSE", role="head", rows=2, edge=True),
        Cell("residual", role="head", columns=2, edge=True),
    )
    below = tuple(
        Cell(word, role="head", edge=word == words[0])
        for words in (*OBJECT_SOURCES.values(), ("points", "SH"))
        for word in words
    )
    rows = tuple(
        _object_cells(name, by_setting[setting])
        for name, by_setting in object_values(document).items()
        if setting in by_setting
    )
    caption = (
        f"Models from the {setting} photographs: IMSE\u2032 of each object, LMSE of Retinex, and"
        " root-mean-square residual of both light fits to the Retinex shading (mean 0.5)."
    )
    behind = rows_behind(document, "objects", "intrinsic")
    name, group = f"objects-{setting}", Group("", rows)
    return Table(name, _stamped(document, caption), (above, below), (group,), behind)


def _object_cells(name: str, own: dict[str, Any]) -> tuple[Cell, ...]:
    errors = [
        Cell(number(own.get(f"{source} {rule}")), edge=rule == rules[0])
        for source, rules in OBJECT_SOURCES.items()
        for rule in rules
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
            _ours(Entry(row["imse"], absent=MISSING)),
            Cell(number(row["relative_imse"], 3)),
        )
        for row in document["own_objects"]
    )
    caption = "Error of each object in the rows that are no part of the published table."
    behind = rows_behind(document, "own_objects")
    return Table("objects-own", caption, (head,), (Group("", rows),), behind)


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
            Cell(", ".join(behind.parts)),
            Cell(str(behind.count)),
            Cell(behind.digest, role="code"),
        )
        for identifier, behind in tied
    )
    caption = (
        "The rows behind each table and figure, as parts of `results/table1.json`. The hash is over"
        " the JSON text of the list of these parts, keys sorted, no spaces."
    )
    return Table("rows-behind", caption, (head,), (Group("", rows),))


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
