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
    Judgement,
    Judgements,
    Plot,
    Prose,
    Report,
    Section,
    Stamp,
    Table,
    tied_blocks,
)
from reports.figures import PlotFigure
from reports.html_renderer import write_html
from reports.pdf_renderer import write_pdf
from reports.pictures import diverging_stops
from reports.rows_behind import rows_behind
from reports.study_figures import Panel, forest_figure
from reports.study_flow_figure import flow_figure
from reports.study_order_figure import order_figure
from reports.study_tables import (
    consistency_table,
    everyone_table,
    exclusion_table,
    facts_table,
    full_rates,
    marked,
    model_table,
    planned_table,
    rates_tables,
    table3,
)
from reports.study_words import NOTHING, Row, condition_words, interval, number_or_nan, percent
from reports.table1_tables import rows_table
from shading_model.errors import RelightlabError

PAGE, PRINTED = "index.html", "report.pdf"
CHANCE = 0.5
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
EXPLAINED = (
    "Each rate is held against chance, 50 %, by its interval that allows for what the answers of"
    " one subject have in common. “Does not hold” means that the data do not show it, not that"
    " there is no difference; that is what the test of equivalence is for."
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
        sections=tuple(_sections(document)),
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


def study_plots(document: Document) -> tuple[Plot, ...]:
    """Return all plots of a study: forest plots, side and half, exclusion flow.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    tuple of Plot
    """
    mark = document["mark"]
    order = order_figure(document["rates"], mark)
    found: list[tuple[PlotFigure, tuple[str, ...]]] = [
        (figure, ("rates", "deviations", "published")) for figure in _forests(document)
    ]
    found += [(order, ("rates",))] if order else []
    found += (
        [(flow_figure(document["started"], document["exclusions"], mark), ("exclusions",))]
        if document["exclusions"]
        else []
    )
    return tuple(
        Plot(
            replace(figure, caption=marked(document, figure.caption)), rows_behind(document, *parts)
        )
        for figure, parts in found
    )


def _forests(document: Document) -> Iterable[PlotFigure]:
    rates = [row for row in full_rates(document) if row["group"] != "side"]
    for figure in document["figures"]:
        panels = [_titled(rates, document["published"], one) for one in figure["conditions"]]
        words = (figure["identifier"], figure["title"], figure["caption"])
        yield forest_figure(*words, panels, document["mark"])


def _titled(rates: Iterable[Row], published: Iterable[Row], condition: Row) -> Panel:
    pair = (condition["task"], condition["condition"])
    own, theirs = (
        [row for row in rows if (row["task"], row["condition"]) == pair]
        for rows in (rates, published)
    )
    return Panel(condition["title"], own, theirs)


def _sections(document: Document) -> Iterable[Section]:
    yield _finding_section(document)
    if document["table3"]:
        yield Section("insertions", "Inserted against real", (table3(document),))
    plots = {plot.figure.identifier: plot for plot in study_plots(document)}
    asides = {name: plots.pop(name, None) for name in ("side-and-half", "exclusion-flow")}
    for identifier, plot in plots.items():
        yield Section(identifier, plot.figure.title, (plot,))
    yield Section("rates", "All rates", (rates_tables(document),))
    if document["tests"]:
        yield Section("planned-tests", "Planned tests", (planned_table(document),))
    if (order := asides["side-and-half"]) is not None:
        yield Section("order", order.figure.title, (order,))
    if document["models"]:
        notes = tuple(Prose(f"{note[:1].upper()}{note[1:]}.") for note in document["notes"])
        yield Section("model-terms", "Models", (model_table(document), *notes))
    if (flow := asides["exclusion-flow"]) is not None:
        whole = [everyone_table(document)] if document["rates_with_everyone"] else []
        yield Section("flow", flow.figure.title, (flow, exclusion_table(document), *whole))
    if document["consistency"]:
        yield _consistency_section(document)


def _finding_section(document: Document) -> Section:
    every = [row for row in document["rates"] if row["group"] == "all"]
    items = tuple(_judgement(row) for row in every if row["rate"] is not None)
    return Section("findings", "What was found", (Prose(EXPLAINED), Judgements(items)))


def _judgement(row: Row) -> Judgement:
    low, high = (number_or_nan(row[f"cluster_{end}"]) for end in ("low", "high"))
    apart = low > CHANCE or high < CHANCE
    where = "above" if row["rate"] > CHANCE else "below"
    words = condition_words(row["task"], row["condition"])
    ends = interval(row["cluster_low"], row["cluster_high"])
    return Judgement(
        "holds" if apart else "does not hold",
        f"{words}: chosen {where} chance",
        f"{percent(row['rate'])} % of {row['trials']} trials of {row['subjects']} subjects",
        "" if ends == NOTHING else f"95 % by subject {ends}",
    )


def _consistency_section(document: Document) -> Section:
    rows = document["consistency"]
    below = sum(row["below"] for row in rows)
    text = (
        f"Of the {len(rows)} deviations printed in the paper's Table 3, {below} are below the"
        " binomial standard error of their rate by more than rounding explains. This concerns the"
        " published numbers alone, not the answers analysed here."
    )
    title = "The published deviations"
    odd = tuple(Prose(sentence) for sentence in document["disagreements"])
    return Section("consistency", title, (Prose(text), consistency_table(document), *odd))


def _lead(document: Document) -> str:
    started, steps = document["started"], document["exclusions"]
    left = sum(step["subjects"] for step in steps)
    trials = steps[-1]["remaining_trials"] if steps else started["trials"]
    remain = steps[-1]["remaining_subjects"] if steps else started["subjects"]
    gone = f", after {left} were left out by rules fixed beforehand" if left else ""
    return (
        f"In each trial a subject chose between two pictures. This report analyses {trials} trials"
        f" of {remain} subjects{gone}, from {{{document['source']}}}."
    )


def _marked_rows(report: Report, document: Document) -> Table:
    return replace(rows_table(tied_blocks(report)), caption=marked(document, ROWS_CAPTION))


def _flat(blocks: Iterable[Block]) -> Iterable[Block]:
    for block in blocks:
        if isinstance(block, Folded):
            yield from block.blocks
        else:
            yield block
