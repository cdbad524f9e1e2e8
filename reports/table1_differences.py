"""Pairs of published entries that come in another order here, each with the likely reason.

A reason is chosen from the numbers, by the first rule of `REASONS` that gives evidence. Entries are
compared in proportion: ours over published, over the median of that over the table, is an entry's
share; where it is above one, we err more than the rest of the table lets expect.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np

from reports.content import Cell, Group, Table
from reports.rows_behind import rows_behind
from reports.table1_entries import ALIKE, NO_RULE, RIVAL, Key, entry_words, measured, published
from reports.table1_tables import stamped

SETTLED = 2.0
"""Standard errors from which on a difference over the objects is called settled."""
CAPTION = (
    "Every pair of entries whose order is not the published one, under its likely reason. Reasons"
    " are chosen by rule from the numbers on the right; they are not proofs. An entry's share is"
    " ours over published, over the median of that ratio in the table."
)


@dataclass(frozen=True)
class Numbers:
    """What reasons are chosen from.

    Parameters
    ----------
    document : dict
        See `evaluation.table1_results.table1_document`.
    """

    document: dict[str, Any]

    @cached_property
    def ours(self) -> dict[Key, float]:
        """Our entries that the paper has too."""
        return {k: v for k, v in measured(self.document).items() if k in self.theirs}

    @cached_property
    def theirs(self) -> dict[Key, float]:
        """The published entries."""
        return published(self.document)

    @cached_property
    def by_object(self) -> dict[Key, dict[str, float]]:
        """Our error of every object in every entry."""
        found: dict[Key, dict[str, float]] = {}
        for row in self.document["objects"]:
            source = RIVAL if row["weights"] == NO_RULE else row["detail_source"]
            if row["imse"] is not None:
                key = (row["setting"], source, row["weights"])
                found.setdefault(key, {})[row["object"]] = row["imse"]
        return found

    def share(self, key: Key) -> float:
        """Return ours over published, over the median of that; one where it is like the table."""
        ratios = {k: value / self.theirs[k] for k, value in self.ours.items()}
        common = float(np.median(list(ratios.values())))
        return ratios[key] / common if common > 0 else 1.0

    def strange(self, pair: Pair) -> Key:
        """Return the entry of a pair that is farther from its share."""
        return max((pair.lower, pair.higher), key=lambda key: abs(np.log(self.share(key) or 1e-9)))


@dataclass(frozen=True)
class Pair:
    """Two entries, by their order in the paper."""

    lower: Key
    higher: Key


Rule = Callable[[Numbers, Pair], str]
"""Returns the evidence, in numbers; nothing where the reason does not apply."""


def differing_pairs(numbers: Numbers) -> tuple[Pair, ...]:
    """Return the pairs whose order here is not the published one.

    Parameters
    ----------
    numbers : Numbers

    Returns
    -------
    tuple of Pair
    """
    ours, theirs = numbers.ours, numbers.theirs
    ordered = sorted(ours, key=lambda key: theirs[key])
    pairs = (Pair(a, b) for a, b in combinations(ordered, 2) if theirs[a] < theirs[b])
    return tuple(pair for pair in pairs if ours[pair.lower] >= ours[pair.higher])


def difference_table(document: dict[str, Any]) -> Table | None:
    """Return every differing pair under its likely reason, None where there is none.

    Parameters
    ----------
    document : dict

    Returns
    -------
    Table or None
    """
    numbers = Numbers(document)
    found = [(pair, *likely_reason(numbers, pair)) for pair in differing_pairs(numbers)]
    groups = tuple(
        Group(
            f"{reason}.",
            tuple(_cells(numbers, pair, why) for pair, own, why in found if own == reason),
        )
        for reason in REASONS
        if any(own == reason for _, own, _ in found)
    )
    if not groups:
        return None
    words = ("lower in the paper", "higher in the paper", "published", "here", "numbers behind it")
    head = tuple(Cell(word, role="head") for word in words)
    behind = rows_behind(document, "rows", "objects", "published")
    return Table("differences", stamped(document, CAPTION), (head,), groups, behind)


def likely_reason(numbers: Numbers, pair: Pair) -> tuple[str, str]:
    """Return the first reason that the numbers speak for, and these numbers.

    Parameters
    ----------
    numbers : Numbers
    pair : Pair

    Returns
    -------
    str, str
    """
    return next((reason, why) for reason, rule in REASONS.items() if (why := rule(numbers, pair)))


def _alike_in_both(numbers: Numbers, pair: Pair) -> str:
    there, here = (_apart(table, pair) for table in (numbers.theirs, numbers.ours))
    return _percent_apart(there, here) if max(there, here) <= ALIKE else ""


def _not_settled(numbers: Numbers, pair: Pair) -> str:
    first, second = (numbers.by_object.get(key, {}) for key in (pair.lower, pair.higher))
    both = [name for name in first if name in second]
    if len(both) < 2:
        return ""
    differences = np.array([first[name] - second[name] for name in both])
    error = float(differences.std(ddof=1)) / np.sqrt(len(both))
    mean = float(differences.mean())
    if mean >= SETTLED * error:
        return ""
    return f"difference {mean:.5f}, standard error over {len(both)} objects {error:.5f}"


def _only_another_rule(numbers: Numbers, pair: Pair) -> str:
    """With the published gap between the weight rules, the order would be the published one."""
    lower, higher = numbers.ours[pair.lower], numbers.ours[pair.higher]
    for key in (pair.lower, pair.higher):
        other = (*key[:2], {"oracle": "regression", "regression": "oracle"}.get(key[2], NO_RULE))
        if pair.lower[2] == pair.higher[2] or other == key or not numbers.ours.get(other):
            continue
        there, here = (table[key] / table[other] for table in (numbers.theirs, numbers.ours))
        moved = numbers.ours[other] * there
        if (moved < higher) if key == pair.lower else (lower < moved):
            return f"{entry_words(key)} over {other[2]}: {there:.2f} published, {here:.2f} here"
    return ""


def _better_rival(numbers: Numbers, pair: Pair) -> str:
    key = numbers.strange(pair)
    return _share_words(numbers, key) if key[1] == RIVAL and numbers.share(key) < 1 else ""


def _better_shading(numbers: Numbers, pair: Pair) -> str:
    key = numbers.strange(pair)
    rival = (key[0], RIVAL, NO_RULE)
    if key[1] != "sirfs-shading" or numbers.share(key) >= 1 or rival not in numbers.ours:
        return ""
    return _share_words(numbers, key, rival) if numbers.share(rival) < 1 else ""


def _cast_shadows(numbers: Numbers, pair: Pair) -> str:
    """In the laboratory the rival, or its shading, is worse than its share."""
    key = numbers.strange(pair)
    ours, theirs = (_laboratory_over_natural(t) for t in (numbers.ours, numbers.theirs))
    of_rival = key[0] == "laboratory" and key[1] in {RIVAL, "sirfs-shading"}
    if not of_rival or numbers.share(key) <= 1 or not ours > theirs:
        return ""
    words = _share_words(numbers, key)
    return f"{words}; B+M, laboratory over natural: {ours:.1f} here, {theirs:.1f} published"


def _shape_is_lost(numbers: Numbers, pair: Pair) -> str:
    key = numbers.strange(pair)
    rival = (key[0], RIVAL, NO_RULE)
    if key[1] != "sirfs-shading" or numbers.share(key) <= 1 or rival not in numbers.ours:
        return ""
    own, whole = numbers.ours[key], numbers.ours[rival]
    return f"{_share_words(numbers, key)}; {own:.5f}, B+M {whole:.5f}" if whole < own else ""


def _better_default(numbers: Numbers, pair: Pair) -> str:
    key = numbers.strange(pair)
    return _share_words(numbers, key) if key[1] == "default" and numbers.share(key) < 1 else ""


def _alike_in_the_paper(numbers: Numbers, pair: Pair) -> str:
    there, here = (_apart(table, pair) for table in (numbers.theirs, numbers.ours))
    return _percent_apart(there, here) if there <= ALIKE else ""


def _unexplained(numbers: Numbers, pair: Pair) -> str:
    return _share_words(numbers, pair.lower, pair.higher)


REASONS: dict[str, Rule] = {
    "Nearly a tie in both tables, within a tenth of each other: other lights can turn it around": (
        _alike_in_both
    ),
    "Not settled here: the difference is within twice its standard error over the objects": (
        _not_settled
    ),
    "The gap between the weight rules is another one: with the published gap, the order would be as"
    " published": _only_another_rule,
    "B+M errs less than its share: this SIRFS is the later release 1.5, in colour, and the paper"
    " cites that of 2012": _better_rival,
    "With B+M's shading we err less than our share, as B+M itself does: this SIRFS is the later"
    " release, in colour": _better_shading,
    "B+M errs more than its share in the laboratory: cast shadows, which SIRFS has no part for, end"
    " up in its albedo and light": _cast_shadows,
    "B+M's shading goes with B+M's shape, but row (b) puts it on the contour shape": _shape_is_lost,
    "Our default errs less than its share: Retinex here is in colour, with thresholds learned on"
    " the other objects; the paper does not describe its own": _better_default,
    "Nearly a tie in the paper, within a tenth: other lights or parameters decide it": (
        _alike_in_the_paper
    ),
    "No reason can be read from these numbers; the paper's lights and parameters are not known": (
        _unexplained
    ),
}
"""Likely reasons and the rules they are chosen by, in order; the last always applies."""


def _apart(table: dict[Key, float], pair: Pair) -> float:
    """Return by how much two entries differ, over the larger."""
    values = table[pair.lower], table[pair.higher]
    return 1 - min(values) / max(values) if max(values) > 0 else 0.0


def _laboratory_over_natural(table: dict[Key, float]) -> float:
    values = [table.get((s, RIVAL, NO_RULE), np.nan) for s in ("laboratory", "natural")]
    return float(values[0] / values[1]) if values[1] else float("nan")


def _share_words(numbers: Numbers, *keys: Key) -> str:
    return "; ".join(f"{entry_words(key)}: share {numbers.share(key):.2f}" for key in keys)


def _percent_apart(there: float, here: float) -> str:
    return f"{_percent(there)} apart published, {_percent(here)} here"


def _percent(value: float) -> str:
    return f"{100 * value:.1f} %"


def _cells(numbers: Numbers, pair: Pair, why: str) -> tuple[Cell, ...]:
    ours, theirs = numbers.ours, numbers.theirs
    return (
        Cell(entry_words(pair.lower), role="head"),
        Cell(entry_words(pair.higher), role="quiet"),
        Cell(f"{theirs[pair.lower]:.4f} < {theirs[pair.higher]:.4f}", role="quiet"),
        Cell(f"{ours[pair.lower]:.5f} ≥ {ours[pair.higher]:.5f}"),
        Cell(why, role="quiet"),
    )
