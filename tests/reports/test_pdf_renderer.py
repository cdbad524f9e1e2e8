"""Tests of reports.pdf_renderer, reading the PDF with another program than wrote it."""

from __future__ import annotations

import gc
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pypdfium2
import pytest

from reports.content import Equation, Pictures, Plot, Report, Table, tied_blocks
from reports.pdf_renderer import pdf_bytes, write_pdf
from reports.table1_report import PRINTED
from shading_model.errors import RelightlabError
from tests.reports.small_result import (
    SmallResult,
    provenance,
    small_page,
    small_result,
)

__all__ = ["small_page", "small_result"]
LARGEST = 10_000_000
A4 = (595.28, 841.89)


@pytest.fixture(scope="module")
def report(small_result: SmallResult) -> Report:
    """The content of the small result's report."""
    return small_result.report()


@pytest.fixture(scope="module")
def printed(small_page: Path) -> Iterator[pypdfium2.PdfDocument]:
    """The small result's PDF."""
    document = pypdfium2.PdfDocument(small_page.with_name(PRINTED))
    yield document
    document.close()


def page_texts(document: pypdfium2.PdfDocument) -> list[str]:
    """Return the text of each page, with single spaces and without breaks inside words."""
    found = []
    for page in document:
        text = page.get_textpage().get_text_range()
        found.append(" ".join(re.sub("[\u200b\ufffe\u00ad]", "", text).split()))
    gc.collect()
    return found


def text_of(content: bytes) -> str:
    """Return the text of a PDF."""
    document = pypdfium2.PdfDocument(content)
    text = " ".join(page_texts(document))
    document.close()
    return text


@pytest.fixture(scope="module")
def texts(printed: pypdfium2.PdfDocument) -> list[str]:
    """The text of each page."""
    return page_texts(printed)


def test_pages_are_numbered(texts: list[str]) -> None:
    """Every page carries its number and how many there are."""
    assert 6 <= len(texts) <= 20
    for number, text in enumerate(texts, start=1):
        assert f"{number} of {len(texts)}" in text


def test_headings_are_the_outline(printed: pypdfium2.PdfDocument, report: Report) -> None:
    """The bookmarks are the sections in order, and each heading is on its bookmark's page."""
    marks = list(printed.get_toc())
    top = [mark for mark in marks if mark.level == 0]
    titles = [re.sub(r"^\d+ ", "", mark.get_title()) for mark in top]
    assert titles == [section.title for section in report.sections]
    pages = [mark.get_dest().get_index() for mark in top]
    assert all(before <= after for before, after in pairwise(pages))
    texts = page_texts(printed)
    for title, page in zip(titles, pages, strict=True):
        assert title in texts[page]


def test_numbers_are_those_of_the_document(texts: list[str], small_result: SmallResult) -> None:
    """Every measured and published value of Table 1 and of the objects is printed."""
    text = " ".join(texts)
    document = small_result.document
    for row in [*document["rows"], *document["baselines"]]:
        assert f"{row['imse']:.5f}" in text
        assert f"{100 * row['relative_imse']:.1f} %" in text
    for row in document["published"]:
        assert f"{row['imse']:.4f}" in text
    for row in document["intrinsic"]:
        assert f"{row['lmse']:.4f}" in text


def test_every_table_cell_is_printed(texts: list[str], report: Report) -> None:
    """The text of every cell of Table 1, with its note, is in the PDF, in the table's order."""
    table = next(b for s in report.sections for b in s.blocks if isinstance(b, Table))
    text = " ".join(texts)
    place = text.index("Table 1. Mean re-rendering error")
    for row in (row for group in table.groups for row in group.rows):
        for cell in row:
            found = text.find(cell.text, place)
            assert found >= place, cell.text
            place = found


def test_hashes_and_captions_are_printed(texts: list[str], report: Report) -> None:
    """Figures and tables are numbered without a gap, and the provenance has whole hashes."""
    text = " ".join(texts)
    names = [name for name, _ in tied_blocks(report)]
    blocks = [b for s in report.sections for b in s.blocks]
    figures = {b.figure.identifier for b in blocks if isinstance(b, Plot | Pictures)}
    tables = len(set(names) - figures) + 2  # provenance is made from no rows
    for word, count in (("Table", tables), ("Figure", len(figures))):
        numbers = [int(found) for found in re.findall(rf"{word} (\d+)\. ", text)]
        assert sorted(set(numbers)) == list(range(1, count + 1))
    assert provenance().data_hash in text.replace(" ", "")
    assert report.maker in text


def test_equations_are_numbered(texts: list[str], report: Report) -> None:
    """The three equations of the paper stand in the section of the model, numbered."""
    equations = [b for s in report.sections for b in s.blocks if isinstance(b, Equation)]
    assert [e.label for e in equations] == ["eq:model", "eq:normal", "eq:MSEmetric"]
    (first,) = [i for i, t in enumerate(texts) if "The relit shading is the coarse shading" in t]
    section = " ".join(texts[first : first + 2])  # it may run over a page's end
    assert all(f"({number})" in section for number in (1, 2, 3))


def test_no_glyph_is_missing(texts: list[str], printed: pypdfium2.PdfDocument) -> None:
    """No character came out as a replacement, and every text is drawn in a font of a wheel."""
    assert not any("\ufffd" in text or "\x00" in text for text in texts)
    raw = {
        obj.get_font().get_base_name() for page in printed for obj in page.get_objects([1])
    }  # 1: text
    names = {re.sub(r"^[A-Z]{6}\+", "", name) for name in raw}
    assert names
    known = ("Libertinus", "NewCM", "DejaVu")
    assert all(name.startswith(known) for name in names), names


def test_pages_are_not_blank_and_nothing_is_cut(printed: pypdfium2.PdfDocument) -> None:
    """Every page has ink, none of it in the outer margin, and is A4."""
    for page in printed:
        assert page.get_size() == pytest.approx(A4, abs=0.1)
        image = page.render(scale=1).to_numpy()[..., :3]
        ink = (image < 250).any(axis=-1)
        assert ink.mean() > 0.005
        inside = np.zeros_like(ink)
        inside[20:-20, 40:-40] = True
        assert not (ink & ~inside).any()


def test_pictures_are_of_print_resolution(printed: pypdfium2.PdfDocument) -> None:
    """Photographs are embedded pictures; plots are drawn, not embedded."""
    pictures = [obj for page in printed for obj in page.get_objects([3])]  # 3: image
    assert len(pictures) > 50
    plots = [text for text in page_texts(printed) if "error over that of natural" in text]
    assert len(plots) == 1


def test_metadata_is_fixed(printed: pypdfium2.PdfDocument, report: Report) -> None:
    """Title, author and keywords are the report's; the date is no clock's; the PDF is tagged."""
    found = printed.get_metadata_dict()
    assert found["Title"].startswith(report.title)
    assert found["Author"] == ", ".join(report.authors)
    assert all(word in found["Keywords"] for word in report.keywords)
    assert found["CreationDate"] == found["ModDate"] == "D:20190101000000Z"
    assert printed.is_tagged()


def test_same_content_gives_same_bytes(report: Report) -> None:
    """Two builds of one content are equal byte for byte, and not too large."""
    first = pdf_bytes(report)
    assert first == pdf_bytes(report)
    assert len(first) < LARGEST


def test_incomplete_result_is_stamped_on_every_page(small_result: SmallResult) -> None:
    """A PDF of a run with missing cells says INCOMPLETE at its head, with the cells, and above."""
    cell = {"object": "cup", "light": "3", "reason": "MemoryError: no room"}
    content = pdf_bytes(small_result.report(missing=[cell]))
    document = pypdfium2.PdfDocument(content)
    texts = page_texts(document)
    document.close()
    assert all("INCOMPLETE" in text for text in texts)
    assert "cup, 3: MemoryError: no room" in texts[0]
    assert "Table 1. INCOMPLETE: 1 cell missing. Mean re-rendering" in " ".join(texts)


def test_text_of_the_document_is_not_markup(small_result: SmallResult) -> None:
    """Signs that typst would read as markup are printed as they are."""
    machine = '#panic("x") *a* _b_ $c$ @d <e> `f` \\g'
    text = text_of(
        pdf_bytes(small_result.report(provenance=provenance(machine=machine).document()))
    )
    assert machine in text


def test_unwritable_pdf_is_one_sentence(report: Report, tmp_path: Path) -> None:
    """A PDF that cannot be written is told in one sentence, and nothing is left."""
    (tmp_path / "file").write_text("taken", encoding="utf-8")
    with pytest.raises(RelightlabError, match="choose another output"):
        write_pdf(tmp_path / "file" / "report.pdf", report)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
