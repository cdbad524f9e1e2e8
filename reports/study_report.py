"""The report of a study: its content, and the page and the PDF made from it.

Data that no people gave, or only a pilot's, are marked: in the document, and from it on the page,
on every page of the PDF, in every caption of a table and across every plot. A report in which one
of these is missing is refused.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from reports.content import (
    Block,
    Folded,
    Plot,
    Prose,
    Report,
    Section,
    Stamp,
    Table,
    tied_blocks,
)
from reports.html_renderer import write_html
from reports.pdf_renderer import write_pdf
from reports.pictures import diverging_stops
from reports.study_sections import study_sections
from reports.study_tables import (
    facts_table,
    marked,
)
from reports.study_words import counted
from reports.table1_tables import rows_table
from shading_model.errors import RelightlabError

PAGE, PRINTED = "index.html", "report.pdf"
KEYWORDS = ("user study", "two-alternative forced choice", "relighting", "Table 3")
STAMPS = {
    "SIMULATED": "No people gave these answers: simulated observers did. The numbers test the"
    " design, the software and the analysis; they say nothing about what people see.",
    "PILOT": "These answers are a pilot's. They test the study before it is run; do not report"
    " them as its result.",
}
"""What is said of each mark."""
ROWS_CAPTION = (
    "The rows behind each table and figure, as parts of `study.json`. The hash is over the JSON"
    " text of the list of these parts, keys sorted, no spaces."
)

Document = Mapping[str, Any]


def write_study_report(folder: Path, document: Document) -> tuple[Path, Path]:
    """Write the report of an analysed study as one HTML page and as a PDF.

    The same document gives the same bytes.

    Parameters
    ----------
    folder : Path
        Gets ``index.html`` and ``report.pdf``, each whole or not at all.
    document : mapping
        See `reports.study_run`.

    Returns
    -------
    Path, Path
        Page and PDF.

    Raises
    ------
    RelightlabError
        If a part of the report lacks the mark of its data, or a file cannot be written.
    """
    report = study_report(document)
    page, printed = folder / PAGE, folder / PRINTED
    write_html(page, report)
    write_pdf(printed, report)
    return page, printed


def study_report(document: Document) -> Report:
    """Return what the report of a study says.

    Parameters
    ----------
    document : mapping
        See `reports.study_run`.

    Returns
    -------
    Report

    Raises
    ------
    RelightlabError
        If a part of the report lacks the mark of its data.
    """
    stamps = study_stamps(document)
    version = document["provenance"].get("relightlab", "")
    report = Report(
        title=document["title"],
        eyebrow=f"relightlab {version} · user study".replace("  ", " "),
        name=f"{document['title']} · relightlab",
        description=f"Rates, intervals and models of the study {document['title']}.",
        authors=(f"relightlab {version}".strip(),),
        keywords=(*KEYWORDS, *(stamp.word for stamp in stamps)),
        lead=Prose(_lead(document), "lead"),
        stamps=stamps,
        teaser=None,
        sections=tuple(study_sections(document)),
        maker=f"Made by relightlab {version}".strip() + ".",
        stops=diverging_stops(),
    )
    tables = (facts_table(document), _marked_rows(report, document))
    closing = Section("provenance", "Provenance", tables)
    return require_marks(replace(report, sections=(*report.sections, closing)), document["mark"])


def study_stamps(document: Document) -> tuple[Stamp, ...]:
    """Return the warnings at the head of a report, none for answers that people gave.

    Parameters
    ----------
    document : mapping
        Its ``mark`` holds words of `STAMPS` with commas between them.

    Returns
    -------
    tuple of Stamp

    Examples
    --------
    >>> [stamp.word for stamp in study_stamps({"mark": "PILOT"})]
    ['PILOT DATA']
    """
    words = [word for word in document["mark"].split(", ") if word]
    return tuple(Stamp(f"{word} DATA", STAMPS[word]) for word in words)


def require_marks(report: Report, mark: str) -> Report:
    """Return a report as it is, having looked for a mark in all of its parts.

    Parameters
    ----------
    report : Report
    mark : str
        Empty for answers that people gave.

    Returns
    -------
    Report

    Raises
    ------
    RelightlabError
        If a table or a figure lacks the mark, or the report has no stamp of it.
    """
    if not mark:
        return report
    bare = [] if report.stamps else ["the report"]
    for section in report.sections:
        for block in _flat(section.blocks):
            if isinstance(block, Table) and mark not in block.caption:
                bare.append(block.identifier)
            if isinstance(block, Plot) and not (
                mark in block.figure.svg and mark in block.figure.caption
            ):
                bare.append(block.figure.identifier)
    if bare:
        raise RelightlabError(f"expected the mark {mark} on all of a report, missing on {bare[0]}")
    return report


def _lead(document: Document) -> str:
    started, steps = document["started"], document["exclusions"]
    left = sum(step["subjects"] for step in steps)
    trials = steps[-1]["remaining_trials"] if steps else started["trials"]
    remain = steps[-1]["remaining_subjects"] if steps else started["subjects"]
    gone = f" ({left} were left out by the rules below)" if left else ""
    return (
        f"How often was the target chosen? This report analyses {counted(trials, 'trial')} of"
        f" {counted(remain, 'subject')}{gone}, from {{{document['source']}}}."
    )


def _marked_rows(report: Report, document: Document) -> Table:
    return replace(rows_table(tied_blocks(report)), caption=marked(document, ROWS_CAPTION))


def _flat(blocks: Iterable[Block]) -> Iterable[Block]:
    for block in blocks:
        if isinstance(block, Folded):
            yield from block.blocks
        else:
            yield block
