"""Tests of reports.table1_differences: every differing pair has a row and a reason from numbers."""

from __future__ import annotations

from typing import Any

import pytest

from evaluation.published_table1 import PUBLISHED
from reports.table1_differences import (
    REASONS,
    Numbers,
    Pair,
    difference_table,
    differing_pairs,
    likely_reason,
)
from reports.table1_entries import Key, entry_words
from reports.table1_verdict import table1_verdict

OBJECTS = tuple("abcdefgh")
SIGNS = {"natural": (1, -1) * 4, "laboratory": (-1, 1) * 4}
UNEXPLAINED = "No reason can be read"


def document(spread: float = 0.0, **factors: float) -> dict[str, Any]:
    """Return the published table as ours, entries named in words times a factor.

    The errors of objects are spread by a share, against each other in the two settings.
    """
    named = {
        row["setting"] + row["method"] + row["detail_source"] + row["weights"]: row
        for row in PUBLISHED
    }
    chosen = {key.replace("_", ""): value for key, value in factors.items()}
    rows = []
    for name, row in named.items():
        matching = [v for key, v in chosen.items() if key in name.replace("-", "")]
        rows.append(row | {"imse": float(row["imse"]) * (matching[0] if matching else 1.0)})
    objects = [
        row | {"object": name, "imse": row["imse"] * (1 + sign * spread)}
        for row in rows
        for name, sign in zip(OBJECTS, SIGNS[row["setting"]], strict=True)
    ]
    published = [dict(row) for row in PUBLISHED]
    return {"rows": rows, "objects": objects, "published": published, "missing": [], "open": []}


def reasons(found: dict[str, Any], *parts: str) -> set[str]:
    """Return the reasons of the differing pairs in whose words all parts stand."""
    numbers = Numbers(found)
    return {
        likely_reason(numbers, pair)[0]
        for pair in differing_pairs(numbers)
        if all(part in entry_words(pair.lower) + entry_words(pair.higher) for part in parts)
    }


def test_the_published_table_differs_nowhere() -> None:
    """The published numbers, at whatever scale, have no differing pair and no table."""
    assert difference_table(document()) is None
    assert difference_table(document(natural=0.1, laboratory=0.1)) is None


def test_every_differing_pair_has_a_row() -> None:
    """As many rows as the verdict counts pairs in another order, each with both numbers."""
    found = document(naturalsirfs=3.0, laboratoryoursdefault=0.3)
    verdict = table1_verdict(found)
    table = difference_table(found)
    assert table is not None
    rows = [row for group in table.groups for row in group.rows]
    assert len(rows) == verdict.pairs - verdict.pairs_alike > 10
    assert all(row[2].text.count("<") == row[3].text.count("≥") == 1 for row in rows)
    assert all(row[4].text for row in rows)
    assert all(group.title[:-1] in REASONS for group in table.groups)


def test_a_tie_in_both_tables_is_one() -> None:
    """Entries within a tenth of each other, there and here, are called a tie."""
    (reason,) = reasons(document(naturaloursgtshadingregression=0.96))
    assert reason.startswith("Nearly a tie in both tables")


def test_a_difference_within_its_spread_is_not_settled() -> None:
    """Where objects disagree about an order, it is not settled; where they agree, it is."""
    pair = Pair(("laboratory", "gt-shading", "regression"), ("natural", "gt-shading", "regression"))
    noisy, clear = (
        likely_reason(Numbers(document(spread, naturaloursgtshadingregression=0.85)), pair)[0]
        for spread in (0.5, 0.0)
    )
    assert noisy.startswith("Not settled here")
    assert clear.startswith("Nearly a tie in the paper")


def test_another_gap_between_rules_is_told_from_other_models() -> None:
    """If only regressed weights are worse, the gap between the rules is the reason."""
    found = document(naturalourssirfsshadingregression=1.2)
    (reason,) = reasons(found, "(b) B+M S, regression", "(a) default, regression")
    assert reason == UNEXPLAINED or reason.startswith("B+M's shading goes with")
    (reason,) = reasons(found, "(b) B+M S, regression", "(a) default, oracle")
    assert reason.startswith("The gap between the weight rules")


@pytest.mark.parametrize(
    ("factors", "parts", "beginning"),
    [
        ({"laboratorysirfs": 0.5}, ("laboratory, B+M",), "B+M errs less than its share"),
        (
            {"naturalsirfs": 0.5, "naturalourssirfsshading": 0.5},
            ("natural, (b)", "natural, (c)"),
            "With B+M's shading we err less",
        ),
        ({"laboratorysirfs": 3.0}, ("laboratory, B+M",), "B+M errs more than its share"),
        (
            {"naturalourssirfsshading": 1.5},
            ("natural, (b)", "natural, (a)"),
            "B+M's shading goes with B+M's shape",
        ),
        ({"laboratoryoursdefault": 0.3}, ("laboratory, (a)",), "Our default errs less"),
        ({"naturaloursgtshading": 2.0}, ("natural, (c)", "natural, (a)"), UNEXPLAINED),
    ],
)
def test_reasons_follow_the_entry_that_stands_out(
    factors: dict[str, float], parts: tuple[str, ...], beginning: str
) -> None:
    """The entry that is farther from its share of the table decides which reason is given."""
    found = reasons(document(**factors), *parts)
    assert any(reason.startswith(beginning) for reason in found), found


def test_zeros_and_single_entries_are_borne() -> None:
    """Errors of zero, one entry alone, and no objects give a table or none, and no fault."""
    zero = document(naturalours=0.0)
    assert difference_table(zero | {"objects": []}) is not None
    assert difference_table(zero | {"rows": zero["rows"][:1]}) is None
    assert difference_table(zero | {"rows": []}) is None


def test_shares_are_one_where_the_table_is_in_proportion() -> None:
    """Ours over published over its median is one for every entry of a scaled table."""
    numbers = Numbers(document(natural=0.2, laboratory=0.2))
    keys: list[Key] = list(numbers.ours)
    assert all(numbers.share(key) == pytest.approx(1.0) for key in keys)
    assert numbers.strange(Pair(keys[0], keys[1])) in keys[:2]
