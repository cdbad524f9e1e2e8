"""Tests of reports.sirfs_section: what the report says of SIRFS, and when it says nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from reports.content import Folded, Pictures, Table
from reports.sirfs_figure import significant
from reports.sirfs_section import ERRORS, sirfs_section, weakness
from tests.reports.fake_fits import FailingFits
from tests.reports.html_outline import read_html
from tests.reports.rival_rows import ERRORS as FAKE_ERRORS
from tests.reports.rival_rows import fit_row, left_out
from tests.reports.small_result import OBJECTS, SmallResult, small_result

__all__ = ["small_result"]


def test_section_shows_a_fit_its_errors_and_its_weakness(small_result: SmallResult) -> None:
    """A figure, means over sets, every object's errors folded, and two paragraphs."""
    section = sirfs_section(small_result.subject())
    assert section is not None
    kinds = [type(block).__name__ for block in section.blocks]
    assert kinds == ["Prose", "Pictures", "Table", "Folded", "Prose", "Prose"]
    summary, folded = (
        next(b for b in section.blocks if isinstance(b, kind)) for kind in (Table, Folded)
    )
    assert isinstance(folded, Folded)
    assert isinstance(summary, Table)
    assert [group.title for group in summary.groups] == ["natural, colour", "laboratory, colour"]
    for table in folded.blocks:
        assert [row[0].text for row in table.groups[0].rows] == list(OBJECTS)


def test_every_error_is_printed(small_result: SmallResult) -> None:
    """Each error of each fit stands in the tables with three digits, its cost with four."""
    section = sirfs_section(small_result.subject())
    assert section is not None
    tables = [t for b in section.blocks if isinstance(b, Folded) for t in b.blocks]
    shown = {cell.text for t in tables for group in t.groups for row in group.rows for cell in row}
    for row in small_result.document["sirfs_rows"]:
        assert {significant(row[key]) for key in ERRORS} <= shown
        assert {significant(row[key], 4) for key in ("final_loss", "evaluations")} <= shown


def test_without_sirfs_there_is_no_section(small_result: SmallResult, tmp_path: Path) -> None:
    """A quick run says nothing about SIRFS beyond its stamp, and asks for no fit."""
    assert sirfs_section(small_result.subject(**left_out(small_result.document))) is None
    page = read_html(small_result.write(tmp_path, **left_out(small_result.document)))
    assert all(link.attributes["href"] != "#sirfs" for link in page.all("a"))


def test_a_fit_that_failed_is_not_shown(small_result: SmallResult) -> None:
    """Where the fit of the object shown diverges, the errors of the others stay."""
    section = sirfs_section(replace(small_result.subject(), fits=FailingFits()))
    assert section is not None
    assert not any(isinstance(block, Pictures) for block in section.blocks)
    assert any(isinstance(block, Table) for block in section.blocks)


def test_weakness_is_measured() -> None:
    """The paragraph has the median and the largest growth of the albedo's error."""
    rows = [
        fit_row(name, setting, factor if setting == "laboratory" else 1.0)
        for name, factor in (("a", 1.0), ("b", 2.0), ("c", 0.1))
        for setting in FAKE_ERRORS
    ]
    (text,) = weakness({"sirfs_rows": rows, "intrinsic": []})
    ratio = FAKE_ERRORS["laboratory"][3] / FAKE_ERRORS["natural"][3]
    assert "for 2 of 3 objects" in text
    assert f"{significant(ratio)} times in the median" in text
    assert f"{significant(2 * ratio)} times for b" in text


@pytest.mark.parametrize(("lmse", "count"), [(1.0, 1), (0.001, 0)])
def test_retinex_stands_beside(lmse: float, count: int) -> None:
    """It is counted on how many objects SIRFS is closer than Retinex, by the same measure."""
    rows = [fit_row("a", "natural")]
    texts = weakness(
        {
            "sirfs_rows": rows,
            "intrinsic": [{"object": "a", "setting": "natural", "lmse": lmse}],
        }
    )
    assert texts[-1].endswith(f"than Retinex for {count} of 1 objects on the natural photographs.")


def test_unknown_errors_are_borne() -> None:
    """Rows without an error of the albedo, or of one setting alone, say nothing."""
    unknown = fit_row("a", "natural") | {"r_mse": None, "rs_mse": None}
    intrinsic = [{"object": "a", "setting": "natural", "lmse": 0.01}]
    assert weakness({"sirfs_rows": [unknown], "intrinsic": intrinsic}) == ()
    assert weakness({"intrinsic": []}) == ()
