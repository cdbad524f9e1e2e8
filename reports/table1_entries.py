"""Table 1 as the page lays it out: our entries beside the published ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

RULES = ("coarse", "default", "manual", "regression", "oracle")
"""Weight rules in the order of the page's columns."""
PUBLISHED_RULES = ("regression", "oracle")
LEFT_OUT = "left out by --quick"
"""In place of the entries that need SIRFS, in a run without it."""
SHORT_LEFT_OUT = "left out"
MISSING = "missing"
ALIKE = 0.1
"""Ratios that differ from one by no more than this are called alike."""
ROWS = (
    ("(a) default", "ours", "default"),
    ("(b) B+M S", "ours", "sirfs-shading"),
    ("(c) GT S", "ours", "gt-shading"),
    ("B+M", "sirfs", "default"),
)
"""Rows of the published table: title, method, detail source."""
SOURCE_TITLES = {source: title for title, method, source in ROWS if method == "ours"}
RIVAL, NO_RULE = "sirfs", "none"
"""Method of the row of B+M, and what stands there for a weight rule."""
Key = tuple[str, str, str]
"""Setting, detail source and weight rule of an entry; of B+M: setting, `RIVAL`, `NO_RULE`."""
BASELINE = "Retinex albedo, flat shape"


@dataclass(frozen=True)
class Entry:
    """One entry of Table 1.

    Parameters
    ----------
    imse, relative : float, optional
        Ours, and over the mean of I^2; None where not measured.
    published : float, optional
        None where the paper has no such entry.
    absent : str
        Why there is no number of ours; empty where there is one.
    """

    imse: float | None = None
    relative: float | None = None
    published: float | None = None
    absent: str = ""

    @property
    def ratio(self) -> float | None:
        """Ours over published, None where either is missing."""
        if self.imse is None or self.published is None:
            return None
        return self.imse / self.published

    @property
    def word(self) -> str:
        """``lower``, ``alike`` or ``higher`` than published; empty without a ratio."""
        if self.ratio is None:
            return ""
        if abs(self.ratio - 1) <= ALIKE:
            return "alike"
        return "lower" if self.ratio < 1 else "higher"


@dataclass(frozen=True)
class EntryRow:
    """One row of Table 1 in one setting: its title and its entries by weight rule.

    The row of B+M has the single entry ``none``; the baseline only ``coarse``; a row of a user's
    method or weight rule only ``own``. A row is open if the run left it out.
    """

    title: str
    entries: dict[str, Entry]
    is_open: bool = False


def table1_rows(document: dict[str, Any], setting: str) -> tuple[EntryRow, ...]:
    """Return the rows of one setting in the published order, then the user's, then the baseline.

    A result without baselines, such as that over the test objects alone, has no row of them.

    Parameters
    ----------
    document : dict
        See `evaluation.table1_results.table1_document`.
    setting : str

    Returns
    -------
    tuple of EntryRow
    """
    rows = [_row(document, setting, *keys) for keys in ROWS]
    baselines = [
        EntryRow(BASELINE, {"coarse": _entry(row, None)})
        for row in document["baselines"]
        if row["setting"] == setting
    ]
    return (*rows, *_own_rows(document, setting), *baselines)


def measured(document: dict[str, Any]) -> dict[Key, float]:
    """Return our IMSE of the entries of the published table, without the missing.

    Parameters
    ----------
    document : dict

    Returns
    -------
    dict
    """
    return _by_key(document["rows"])


def published(document: dict[str, Any]) -> dict[Key, float]:
    """Return the published IMSE by the same keys.

    Parameters
    ----------
    document : dict

    Returns
    -------
    dict
    """
    return _by_key(document["published"])


def entry_words(key: Key) -> str:
    """Return an entry of the published table in words.

    Parameters
    ----------
    key : tuple of str

    Returns
    -------
    str

    Examples
    --------
    >>> entry_words(("natural", "gt-shading", "oracle")), entry_words(("natural", "sirfs", "none"))
    ('natural, (c) GT S, oracle', 'natural, B+M')
    """
    setting, source, rule = key
    return f"{setting}, B+M" if source == RIVAL else f"{setting}, {SOURCE_TITLES[source]}, {rule}"


def is_quick(document: Mapping[str, Any]) -> bool:
    """Return whether a result was made without SIRFS.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    bool
    """
    return bool(document.get("quick"))


def has_rival(document: Mapping[str, Any]) -> bool:
    """Return whether a result has rows of SIRFS.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    bool
    """
    return any(_key(row)[1] == RIVAL for row in document["rows"])


def missing_reasons(document: dict[str, Any], objects_in_set: int) -> tuple[str, ...]:
    """Return why a result is not the whole table, in words; empty if it is.

    Entries that a quick run leaves out do not count.

    Parameters
    ----------
    document : dict
    objects_in_set : int
        How many objects the dataset has.

    Returns
    -------
    tuple of str
    """
    reasons = []
    cells = document["provenance"]["cells_missing"]
    if cells:
        reasons.append(f"{cells} cells were not measured")
    reported = len({row["object"] for row in document["intrinsic"]})
    if reported < objects_in_set:
        reasons.append(f"{reported} of {objects_in_set} objects are reported")
    empty = sum(row["imse"] is None for row in document["rows"])
    if empty:
        reasons.append(f"{empty} table entries have no value")
    return tuple(reasons)


def _row(document: dict[str, Any], setting: str, title: str, method: str, source: str) -> EntryRow:
    key = {"setting": setting, "method": method, "detail_source": source}
    is_open = any(key.items() <= entry.items() for entry in document["open"])
    absent = SHORT_LEFT_OUT if is_open else MISSING
    entries = {}
    for rule in (NO_RULE,) if method == RIVAL else RULES:
        ours = _find(document["rows"], key | {"weights": rule})
        printed = _find(document["published"], key | {"weights": rule})
        entries[rule] = _entry(ours, printed, absent)
    return EntryRow(title, entries, is_open)


def _own_rows(document: dict[str, Any], setting: str) -> list[EntryRow]:
    """Return the rows that a user added: models by their rules, other rows each by itself."""
    added = [row for row in document["rows"] if row["setting"] == setting and _is_own(row)]
    rows = {}
    for row in added:
        source = SOURCE_TITLES.get(row["detail_source"], "")
        title = ", ".join(part for part in (row["method"], source) if part)
        if row["weights"] in RULES:
            key = {name: row[name] for name in ("setting", "method", "detail_source")}
            found = {r: _entry(_find(added, key | {"weights": r}), None) for r in RULES}
            rows[title] = EntryRow(title, found)
        else:
            rule = "" if row["weights"] == "none" else f", {row['weights']}"
            rows[title + rule] = EntryRow(title + rule, {"own": _entry(row, None)})
    return list(rows.values())


def _is_own(row: dict[str, Any]) -> bool:
    return _key(row)[1] != RIVAL and (row["method"] != "ours" or row["weights"] not in RULES)


def _entry(
    ours: dict[str, Any] | None, printed: dict[str, Any] | None, absent: str = MISSING
) -> Entry:
    value = printed["imse"] if printed else None
    if ours is None or ours["imse"] is None:
        return Entry(published=value, absent=absent)
    return Entry(ours["imse"], ours["relative_imse"], value)


def _find(rows: list[dict[str, Any]], key: dict[str, str]) -> dict[str, Any] | None:
    return next((row for row in rows if key.items() <= row.items()), None)


def _by_key(rows: list[dict[str, Any]]) -> dict[Key, float]:
    return {
        _key(row): row["imse"]
        for row in rows
        if row["imse"] is not None and (row["method"] == "ours" or _key(row)[1] == RIVAL)
    }


def _key(row: dict[str, Any]) -> Key:
    cell = row["method"], row["detail_source"], row["weights"]
    return row["setting"], RIVAL if cell == (RIVAL, "default", NO_RULE) else cell[1], cell[2]
