"""Tests of reports.base_shape_section: what the report says of Table 2, and what it leaves out."""

from __future__ import annotations

import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from datasets.psm_uw import PsmUw
from datasets.rgbd_mitten import RgbdMitten
from reports.base_shape_run import BaseShapeStudy
from reports.base_shape_section import base_shape_sections
from reports.base_shape_views import PART
from reports.base_shape_words import CAVEATS, shape_words
from reports.content import Folded, Judgements, Pictures, Plot, Prose, Remarks, Section, Table
from reports.html_renderer import html_text
from reports.pdf_renderer import pdf_bytes
from reports.table1_report import table1_report
from tests.reports.html_outline import read_html
from tests.reports.small_result import SmallResult
from tests.reports.small_study import study_document


@pytest.fixture(scope="module")
def sections(small_study: BaseShapeStudy) -> tuple[Section, ...]:
    """The sections of the small study."""
    return base_shape_sections(small_study)


def changed(study: BaseShapeStudy, **parts: Any) -> BaseShapeStudy:
    """Return a study with changed parts of its document."""
    return replace(study, document=copy.deepcopy(study.document) | parts)


def test_three_sections_tell_of_a_set(sections: tuple[Section, ...]) -> None:
    """The table with all that belongs to it, the pictures, and the turned views."""
    assert [section.title for section in sections] == [
        "Table 2: the base shape, on the synthetic set",
        "Relit on each base shape: the synthetic set",
        "Turned views of the base shapes: the synthetic set",
    ]
    kinds = [[type(block) for block in section.blocks] for section in sections]
    assert kinds[0][:2] == [Prose, Judgements]
    assert [kind for kind in kinds[0] if kind not in {Prose, Judgements}] == [
        *(Table, Remarks, Folded, Plot, Folded, Folded)
    ]
    assert kinds[1:] == [[Pictures, Pictures], [Plot]]


def test_three_objects_bear_no_test(sections: tuple[Section, ...]) -> None:
    """A set of three objects says plainly that no test is possible."""
    texts = [block.text for block in sections[0].blocks if isinstance(block, Prose)]
    assert any("{No test is possible}: with three objects" in text for text in texts)
    assert texts[0].startswith("{Verdict.} That the contour shape is not the barrier")


@pytest.mark.slow
def test_identifiers_are_of_the_set(small_result: SmallResult, small_study: BaseShapeStudy) -> None:
    """A page with two studies has no identifier twice, and links to every section."""
    other = changed(
        small_study, provenance=small_study.document["provenance"] | {"dataset": "own:my mugs"}
    )
    subject = replace(small_result.subject(), studies=(small_study, other))
    outline = read_html(html_text(table1_report(subject)))
    named = [e.attributes["id"] for e in outline.all() if e.attributes.get("id")]
    assert len(named) == len(set(named))
    assert {"table-2-synthetic", "table-2-own-my-mugs"} <= set(named)
    targets = {str(link.attributes["href"]).removeprefix("#") for link in outline.all("a")}
    assert targets <= set(named)


@pytest.mark.slow
def test_sections_follow_table_1_and_are_tied(
    small_result: SmallResult, small_study: BaseShapeStudy
) -> None:
    """The study stands after SIRFS, and the list of rows names its file."""
    subject = replace(small_result.subject(), studies=(small_study,))
    report = table1_report(subject)
    names = [section.identifier for section in report.sections]
    place = names.index("sirfs") + 1
    assert names[place : place + 3] == [
        *("table-2-synthetic", "base-shape-pictures-synthetic", "turned-views-synthetic")
    ]
    tied = report.sections[names.index("provenance")].blocks[1]
    assert isinstance(tied, Table)
    listed = {row[0].text: row[1].text for group in tied.groups for row in group.rows}
    assert listed["table-2-synthetic-errors"] == "table2-synthetic.json: rows, published"
    assert listed["generic-view-synthetic"] == "table2-synthetic.json: generic_view"
    assert listed["entries"] == "rows, baselines, published"


@pytest.mark.slow
def test_the_pdf_has_the_study(small_result: SmallResult, small_study: BaseShapeStudy) -> None:
    """The same content is typeset, without a fault, to a PDF that may be read aloud."""
    varied = study_document(
        dataset="synthetic", variants={"half-height": {"contour": 0.01, "sirfs": 0.02}}
    )
    study = changed(small_study, sensitivity=varied["sensitivity"])
    content = pdf_bytes(table1_report(replace(small_result.subject(), studies=(study,))))
    assert content.startswith(b"%PDF-")


def test_without_the_check_there_are_no_views(small_study: BaseShapeStudy) -> None:
    """A study that was not turned has two sections."""
    without = changed(small_study, **{PART: []})
    assert len(base_shape_sections(without)) == 2


def test_sensitivity_needs_variants(small_study: BaseShapeStudy) -> None:
    """With a second variant there is a table of the order; with the table alone there is none."""
    varied = study_document(variants={"half-height": {"contour": 0.01, "sirfs": 0.02}})
    study = changed(small_study, sensitivity=varied["sensitivity"])
    tables = [b for b in base_shape_sections(study)[0].blocks if isinstance(b, Table)]
    assert [table.layout for table in tables] == ["base-shapes", "sensitivity"]


def test_quick_study_says_what_it_lacks(small_study: BaseShapeStudy) -> None:
    """Without the fitted shapes, what needs them is not measured, and captions are stamped."""
    quick = study_document(
        {"contour": 0.02, "kinect": 0.01, "ground-truth": 0.01, "flat": 0.03},
        dataset="synthetic",
        quick=True,
        objects=3,
    )
    parts = {part: quick[part] for part in ("rows", "pairs", "tests", "sensitivity", "quick")}
    parts["objects"] = [
        row for row in small_study.document["objects"] if not row["shape"].startswith("sirfs")
    ]
    table, *_ = base_shape_sections(changed(small_study, **parts))
    (judged,) = (block for block in table.blocks if isinstance(block, Judgements))
    assert [item.state for item in judged.items] == [
        *("does not hold", "not measured", "not measured")
    ]
    captions = [block.caption for block in table.blocks if isinstance(block, Table)]
    assert all(caption.startswith("{QUICK: without SIRFS.}") for caption in captions)


@pytest.mark.parametrize("dataset", ["mit-berkeley", "psm-uw", "rgbd-mitten", "synthetic"])
def test_every_set_says_what_it_favours(dataset: str) -> None:
    """For each set that the study is reported on, it is written down what its lights favour."""
    assert "favour" in CAVEATS[dataset] or "say nothing" in CAVEATS[dataset]


def test_sensors_and_references_are_told_from_simulations(small_result: SmallResult) -> None:
    """A real sensor and a reference are called so; elsewhere the Kinect is simulated."""
    synthetic = shape_words(small_result.dataset)
    assert (synthetic["kinect"], synthetic["ground-truth"]) == (
        "Kinect (simulated)",
        "ground truth",
    )
    mitten = shape_words(RgbdMitten(Path("rgbd-mitten")))
    assert mitten["kinect"] == "depth sensor (real)"
    uw = shape_words(PsmUw(Path("psm-uw")))
    assert uw["kinect"] == "Kinect (simulated)"
    assert uw["ground-truth"] == "photometric stereo (reference)"
