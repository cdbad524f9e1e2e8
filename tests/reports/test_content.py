"""Tests of reports.content: prose marks, tables whose rows fit, and hashes of rows."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace

import pytest

from reports.content import Cell, Group, Table, rows_behind, spans, tied_blocks
from reports.table1_tables import rows_table
from shading_model.errors import RelightlabError
from tests.reports.small_result import SmallResult, small_result

__all__ = ["small_result"]
HEAD = (
    (Cell("name", rows=2), Cell("both", columns=2), Cell("last", rows=2)),
    (Cell("one"), Cell("two")),
)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("plain words", [("text", "plain words")]),
        ("S_p", [("text", "S"), ("index", "p")]),
        ("a `S_p {b}` c", [("text", "a "), ("code", "S_p {b}"), ("text", " c")]),
        ("{so}", [("emphasis", "so")]),
        ("file_name, T_int", [("text", "file_name, T_int")]),
        ("", []),
    ],
)
def test_prose_is_cut_at_its_marks(text: str, expected: list[tuple[str, str]]) -> None:
    """Code, emphasis and one-letter indices are found; anything else stays as it is."""
    assert spans(text) == expected


def test_rows_that_do_not_fit_are_refused() -> None:
    """A table whose row has another width than its head is refused with both widths."""
    fitting = Group("", ((Cell("a"), Cell("b", columns=2), Cell("c")),))
    table = Table("t", "caption", HEAD, (fitting,))
    assert table.width == 4
    with pytest.raises(RelightlabError, match=r"expected rows of 4 columns .*got one of 1"):
        replace(table, groups=(fitting, Group("", ((Cell("a"),),))))


def test_leaf_headings_know_their_columns() -> None:
    """Headings that stand above one column alone have its number, the others none."""
    table = Table("t", "caption", HEAD, (Group("", ()),))
    assert table.head_columns() == ((0, None, 3), (1, 2))


def test_hash_is_of_the_rows_alone(small_result: SmallResult) -> None:
    """The hash can be computed from the results file, and moves with any value in the rows."""
    document = small_result.document
    behind = rows_behind(document, "rows", "published")
    parts = json.loads(json.dumps([document["rows"], document["published"]]))
    text = json.dumps(parts, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    assert behind.digest == hashlib.sha256(text.encode()).hexdigest()
    assert behind.count == len(document["rows"]) + len(document["published"])
    assert rows_behind(document | {"provenance": {}}, "rows", "published") == behind
    changed = [*document["rows"][1:], document["rows"][0] | {"imse": 1.0}]
    assert rows_behind(document | {"rows": changed}, "rows", "published").digest != behind.digest


def test_unknown_part_of_the_results_is_named() -> None:
    """A part that the results do not have is refused with those they have."""
    with pytest.raises(RelightlabError, match=r"Did you mean 'rows'\?"):
        rows_behind({"rows": []}, "row")


def test_every_table_and_figure_of_results_is_tied(small_result: SmallResult) -> None:
    """The report lists the rows behind each table and figure that shows results."""
    report = small_result.report()
    tied = list(tied_blocks(report))
    names = [name for name, _ in tied]
    assert names[:3] == ["entries", "table-shape", "object-errors"]
    assert {"objects-natural", "objects-laboratory", "gallery-natural"} <= set(names)
    assert len(names) == len(set(names))
    (provenance,) = [s for s in report.sections if s.identifier == "provenance"]
    assert provenance.blocks[-1] == rows_table(tied)
