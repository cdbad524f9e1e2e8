"""Tests of reports.content: tables whose rows fit, and what is tied to rows."""

from __future__ import annotations

from dataclasses import replace

import pytest

from reports.content import Cell, Group, Table, tied_blocks
from reports.table1_tables import rows_table
from shading_model.errors import RelightlabError
from tests.reports.small_result import SmallResult, small_result

__all__ = ["small_result"]
HEAD = (
    (Cell("name", rows=2), Cell("both", columns=2), Cell("last", rows=2)),
    (Cell("one"), Cell("two")),
)


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


def test_every_table_and_figure_of_results_is_tied(small_result: SmallResult) -> None:
    """The report lists the rows behind each table and figure that shows results."""
    report = small_result.report()
    tied = list(tied_blocks(report))
    names = [name for name, _ in tied]
    assert names[:3] == ["entries", "entries-held-out", "differences"]
    assert {"table-shape", "object-errors"} <= set(names)
    assert {"objects-natural", "objects-laboratory", "gallery-natural"} <= set(names)
    assert len(names) == len(set(names))
    (provenance,) = [s for s in report.sections if s.identifier == "provenance"]
    assert provenance.blocks[-1] == rows_table(tied)
