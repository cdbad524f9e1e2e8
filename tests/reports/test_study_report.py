"""Tests of the report of a study: what stands on it, and the mark that made-up answers carry."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pypdfium2
import pytest

from reports.content import Block, Folded, Judgements, Plot, Report, Table
from reports.html_renderer import html_text
from reports.paper_table3 import table3
from reports.pdf_renderer import pdf_bytes
from reports.study_report import require_marks, study_report
from reports.study_results import mark_of_modes
from reports.study_sections import study_sections
from shading_model.errors import RelightlabError
from tests.reports.html_outline import read_html
from tests.reports.study_document import CONDITIONS, study_document

MARKS = ["SIMULATED", "SIMULATED, PILOT"]


@pytest.fixture(scope="module")
def report() -> Report:
    """The report of simulated answers."""
    return study_report(study_document())


def blocks(report: Report) -> Iterator[Block]:
    """Yield every block, those that are folded away among them."""
    for section in report.sections:
        for block in section.blocks:
            yield from block.blocks if isinstance(block, Folded) else (block,)


def page_texts(report: Report) -> list[str]:
    """Return the text of each page of the PDF."""
    document = pypdfium2.PdfDocument(pdf_bytes(report))
    texts = [page.get_textpage().get_text_range() for page in document]
    document.close()
    return [" ".join(re.sub("[\u200b\ufffe\u00ad]", "", text).split()) for text in texts]


@pytest.mark.parametrize("mark", MARKS)
def test_every_table_and_figure_is_marked(mark: str) -> None:
    """The mark stands in each caption and across each plot; on the page in its stamps."""
    report = study_report(study_document(mark))
    tables = [block for block in blocks(report) if isinstance(block, Table)]
    plots = [block for block in blocks(report) if isinstance(block, Plot)]
    assert len(tables) > 8
    assert len(plots) == 3
    assert all(table.caption.startswith(f"{{{mark} DATA.}}") for table in tables)
    assert all(plot.figure.caption.startswith(f"{{{mark} DATA.}}") for plot in plots)
    assert all(mark in plot.figure.svg for plot in plots)
    assert [stamp.word for stamp in report.stamps] == [f"{m} DATA" for m in mark.split(", ")]
    outline = read_html(html_text(report))
    stamps = [e for e in outline.all("div") if e.attributes.get("class") == "stamp"]
    assert [stamp.one("strong").text for stamp in stamps] == [s.word for s in report.stamps]
    assert all(table.one("caption").text.startswith(mark) for table in outline.all("table"))


def test_every_page_of_the_print_is_marked(report: Report) -> None:
    """Each page of the PDF says SIMULATED DATA, the first in its stamp and others at their head."""
    texts = page_texts(report)
    assert len(texts) >= 5
    assert all("SIMULATED DATA" in text for text in texts)


def test_every_panel_is_marked(report: Report) -> None:
    """A plot of two panels has the mark in each of them, so that cropping one keeps it."""
    (forest,) = [b for b in blocks(report) if isinstance(b, Plot) and b.figure.title[:4] == "Ours"]
    assert forest.figure.svg.count(">SIMULATED<") == 2


def test_real_answers_have_no_mark() -> None:
    """Without simulated or pilot answers nothing on the page speaks of them."""
    page = html_text(study_report(study_document("")))
    assert "SIMULATED" not in page
    assert "PILOT" not in page
    assert 'class="stamp"' not in page


@pytest.mark.parametrize("part", ["table", "plot", "stamps"])
def test_an_unmarked_part_is_refused(report: Report, part: str) -> None:
    """A report that lost the mark of one table, one plot or its stamps cannot be written."""
    bare: Any = {"stamps": ()}
    if part != "stamps":
        section = report.sections[1 if part == "table" else 2]
        (block,) = section.blocks
        if isinstance(block, Table):
            block = replace(block, caption="Rates.")
        elif isinstance(block, Plot):
            svg = block.figure.svg.replace("SIMULATED", "")
            block = replace(block, figure=replace(block.figure, svg=svg))
        sections = [replace(s, blocks=(block,)) if s is section else s for s in report.sections]
        bare = {"sections": tuple(sections)}
    with pytest.raises(RelightlabError, match="expected the mark SIMULATED on all of a report"):
        require_marks(replace(report, **bare), "SIMULATED")


def test_marks_come_from_modes() -> None:
    """One simulated subject among many marks all; imported and live ones do not."""
    assert mark_of_modes(["live"] * 99 + ["simulated"]) == "SIMULATED"
    assert mark_of_modes(["live", "imported"]) == ""
    assert mark_of_modes(["pilot"]) == "PILOT"


def test_table3_has_measured_beside_published() -> None:
    """Each row has trials, our rate with deviation and interval, and the published rate."""
    table = table3(study_document())
    rows = [row for group in table.groups for row in group.rows]
    names = [row[0].text for row in rows]
    assert names[:3] == ["all", "expert", "non-expert"]
    assert len(rows) == 11
    first = rows[0]
    assert [cell.text for cell in first[1:4]] == ["1040", "45.0 ± 1.6", "44.0 ± 1.5"]
    assert first[2].note == "41.0 to 49.0"
    assert (first[2].role, first[3].role) == ("ours", "published")


def test_a_condition_that_was_not_measured_stays_in_table3() -> None:
    """Its cells say so, and the published values remain."""
    document = study_document()
    rates = [row for row in document["rates"] if row["condition"] != "ours"]
    table = table3(document | {"rates": rates})
    first = table.groups[0].rows[0]
    assert [cell.text for cell in first[1:4]] == ["–", "not measured", "44.0 ± 1.5"]  # noqa: RUF001


def test_findings_say_what_is_shown() -> None:
    """A rate whose interval has chance inside is not shown to differ; others hold, either way."""
    document = study_document("")
    every = [row for row in document["rates"] if row["group"] == "all"]
    every[-1] |= {"cluster_low": 0.45, "cluster_high": 0.66}
    conditions = document["table3"] + document["figures"][0]["conditions"]
    figures = [document["figures"][0] | {"conditions": conditions}]
    findings = next(study_sections(document | {"figures": figures})).blocks[1]
    assert isinstance(findings, Judgements)
    assert [item.state for item in findings.items] == ["holds", "holds", "holds", "not shown"]
    words = [item.statement.split(": ")[1] for item in findings.items]
    assert words == ["below chance"] * 2 + ["above chance", "apart from chance"]


def test_page_adapts_to_rates_alone() -> None:
    """Without tests, models, exclusions and published rates their sections are not there."""
    parts = ("tests", "models", "exclusions", "published", "table3", "consistency")
    empty: dict[str, Any] = {part: [] for part in (*parts, "rates_with_everyone", "notes")}
    report = study_report(study_document(**empty))
    titles = [section.identifier for section in report.sections]
    assert titles == ["findings", "study_vs_barron_karsch", "rates", "order", "provenance"]
    assert len(page_texts(report)) >= 2


def test_texts_of_the_data_are_not_markup() -> None:
    """A level or task with markup in its name is shown as it is, on the page and in plots."""
    evil = "<script>alert(1)</script>"
    document = study_document("")
    rates = [row | {"level": evil} if row["level"] == "male" else row for row in document["rates"]]
    page = html_text(study_report(document | {"rates": rates}))
    assert evil not in page
    assert "&lt;script&gt;" in page


def test_missing_values_are_dashes() -> None:
    """A rate of one subject has no cluster interval; plots and tables leave it out."""
    document = study_document("")
    none = {f"{name}_{end}": None for name in ("cluster", "twoway") for end in ("low", "high")}
    rates = [row | none for row in document["rates"]]
    deviations = [row | {"deviation": None} for row in document["deviations"]]
    report = study_report(document | {"rates": rates, "deviations": deviations})
    assert not re.search(r"\bnan\b", html_text(report), re.IGNORECASE)


def test_same_document_gives_same_bytes(report: Report) -> None:
    """Two builds of one document are equal, on the page and in print."""
    again = study_report(study_document())
    assert html_text(again) == html_text(report)
    assert pdf_bytes(again) == pdf_bytes(report)


def test_each_condition_has_its_rates(report: Report) -> None:
    """Folded away, every condition has a table of all of its rates."""
    tables = [b for b in blocks(report) if isinstance(b, Table) and b.identifier[:5] == "rates"]
    assert len(tables) == len(CONDITIONS)
    assert all(len(table.groups[0].rows) == 13 for table in tables)
