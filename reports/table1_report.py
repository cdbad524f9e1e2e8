"""The report of Table 1: its content, and the page and the PDF made from it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import evaluation.table1
from datasets.records import Dataset
from reports.base_shape_run import BaseShapeStudy
from reports.base_shape_section import base_shape_sections
from reports.content import (
    Definitions,
    Folded,
    Pictures,
    Plot,
    Prose,
    Report,
    Section,
    Stamp,
    tied_blocks,
)
from reports.decomposition_figure import decomposition_figure, teaser_figure
from reports.error_figure import object_error_figure, table_shape_figure
from reports.figures import PanelFigure
from reports.gallery_figure import gallery_figure
from reports.html_renderer import write_html
from reports.light_fit_figure import light_fit_figure
from reports.paper_equations import EQUATIONS
from reports.pdf_renderer import write_pdf
from reports.pictures import diverging_stops
from reports.rows_behind import Rows, rows_behind
from reports.sirfs_section import sirfs_section
from reports.subject import Fits, Subject
from reports.table1_entries import is_quick, missing_reasons
from reports.table1_objects import object_table, own_object_table
from reports.table1_section import difference_section, table_section
from reports.table1_tables import missing_words, provenance_table, rows_table
from reports.table1_words import METHOD, PHOTOGRAPHS, QUICK_STAMP, SYNTHETIC_STAMP
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ModelParameters

PAGE, PRINTED = "index.html", "report.pdf"
SYNTHETIC = "synthetic"
KEYWORDS = ("relighting", "shading", "intrinsic images", "re-rendering error", "Table 1")

PANEL_FIGURES: dict[str, Callable[[Subject], Sequence[PanelFigure]]] = {
    "decomposition": lambda subject: [decomposition_figure(subject)],
    "light fits": lambda subject: [light_fit_figure(subject)],
    "gallery": lambda subject: [gallery_figure(subject, setting) for setting in subject.settings],
}
"""Every figure of pictures, in the order of the report; a new one is a line here."""


def write_report(
    folder: Path,
    *,
    document: dict[str, Any],
    dataset: Dataset,
    lights: Sequence[LogHarmonics],
    parameters: ModelParameters,
    fits: Fits | None = None,
    studies: Sequence[BaseShapeStudy] = (),
) -> tuple[Path, Path]:
    """Write the report of a measured Table 1 as one HTML page and as a PDF.

    The same arguments give the same bytes. The models of the objects shown are built again,
    which takes some seconds.

    Parameters
    ----------
    folder : Path
        Gets ``index.html`` and ``report.pdf``, each whole or not at all.
    document : dict
        What `evaluation.table1_results.table1_document` returns.
    dataset : Dataset
        The set the result was measured on.
    lights : sequence of LogHarmonics
        The lights of the result.
    parameters : ModelParameters
        As the result was measured with.
    fits : Fits, optional
        Where the fits of SIRFS are kept, one of which is shown.
    studies : sequence of BaseShapeStudy
        Of Table 2, each on a dataset of its own, which need not be that of Table 1.

    Returns
    -------
    Path, Path
        Page and PDF.

    Raises
    ------
    RelightlabError
        If the document is of another dataset or other lights, reports no object, or a file
        cannot be written.
    """
    subject = Subject(document, dataset, tuple(lights), parameters, fits, tuple(studies))
    report = table1_report(subject)
    page, printed = folder / PAGE, folder / PRINTED
    write_html(page, report)
    write_pdf(printed, report)
    return page, printed


def table1_report(subject: Subject) -> Report:
    """Return what the report of a result says.

    Parameters
    ----------
    subject : Subject

    Returns
    -------
    Report

    Raises
    ------
    RelightlabError
        If the document is of another dataset or other lights, or reports no object.
    """
    document = _checked(subject).document
    origin, protocol = document["provenance"], document["protocol"]
    sections = (
        table_section(subject),
        difference_section(document),
        _model_section(),
        *_figure_sections(subject),
        *([rival] if (rival := sirfs_section(subject)) else []),
        *(section for study in subject.studies for section in base_shape_sections(study)),
    )
    stamps = tuple(_stamps(subject))
    report = Report(
        title="From one photograph to Table 1",
        eyebrow=f"relightlab {origin['project']} · protocol {protocol['name']},"
        f" version {protocol['version']}",
        name=f"Table 1 on {origin['dataset']} · relightlab",
        description="Re-rendering error of the approximate shading model on"
        f" {origin['dataset']}, beside the published Table 1.",
        authors=(f"relightlab {origin['project']}",),
        keywords=(*KEYWORDS, origin["dataset"], *(stamp.word for stamp in stamps)),
        lead=Prose(_lead(subject), "lead"),
        stamps=stamps,
        teaser=Pictures(teaser_figure(subject), _object_rows(document)),
        sections=(*sections, _protocol_section(document)),
        maker=f"Made by relightlab {origin['project']}.",
        stops=diverging_stops(),
    )
    closing = (_provenance_section(report, document), _citation_section(subject))
    return replace(report, sections=(*report.sections, *closing))


def protocol_sections(docstring: str) -> tuple[tuple[str, str], ...]:
    r"""Return the terms and definitions of the protocol's docstring.

    Parameters
    ----------
    docstring : str
        Terms at the margin, each followed by an indented definition.

    Returns
    -------
    tuple of (str, str)

    Examples
    --------
    >>> protocol_sections("Summary.\n\nLights\n    Twenty\n    draws.\n")
    (('Lights', 'Twenty draws.'),)
    """
    found = re.findall(r"^(\S.*)\n((?: {4}.*(?:\n|$))+)", docstring, flags=re.MULTILINE)
    return tuple((term.strip(), " ".join(text.split())) for term, text in found)


def _lead(subject: Subject) -> str:
    return (
        "How well can an object be relit from a single photograph? This report measures the"
        " {approximate shading model with detail decomposition} (Liao, Karsch, Zhang and Forsyth"
        f" 2019) on {{{subject.dataset.name}}}: {len(subject.objects)} objects, each relit under"
        f" {len(subject.lights)} lights, and sets every number beside the published one."
    )


def _stamps(subject: Subject) -> Iterable[Stamp]:
    if subject.dataset.name == SYNTHETIC:
        yield SYNTHETIC_STAMP
    if is_quick(subject.document):
        yield QUICK_STAMP
    reasons = missing_reasons(subject.document, len(subject.dataset.objects))
    missing = missing_words(subject.document)
    if reasons or missing:
        why = "; ".join(reasons) or f"{len(subject.document['missing'])} cells are missing"
        yield Stamp("INCOMPLETE", f"{why}. Do not quote these numbers as the table.", missing)


def _model_section() -> Section:
    return Section("model", "The model and its measure", EQUATIONS)


def _figure_sections(subject: Subject) -> Iterable[Section]:
    document = subject.document
    shape, errors = table_shape_figure(subject), object_error_figure(subject)
    yield Section(
        shape.identifier, shape.title, (Plot(shape, rows_behind(document, "rows", "published")),)
    )
    tables = [object_table(document, setting) for setting in subject.settings]
    tables += [own_object_table(document)] if document["own_objects"] else []
    folded = Folded("All values by object", tuple(tables))
    plot = Plot(errors, _object_rows(document))
    yield Section(errors.identifier, errors.title, (plot, folded))
    for figure in (figure for make in PANEL_FIGURES.values() for figure in make(subject)):
        pictures = Pictures(figure, _object_rows(document))
        yield Section(figure.identifier, figure.title, (pictures,))


def _object_rows(document: dict[str, Any]) -> Rows:
    return rows_behind(document, "objects")


def _protocol_section(document: dict[str, Any]) -> Section:
    protocol = document["protocol"]
    manual = ", ".join(map(str, protocol["manual_weights"]))
    text = (
        "Every choice that the paper leaves open, as this run made it. Albedos compared as:"
        f" {protocol['channels']}; manual weights: {manual}; lights: {protocol['lights']}."
    )
    terms = Definitions(protocol_sections(evaluation.table1.__doc__ or ""))
    title = f"Protocol {protocol['name']}, version {protocol['version']}"
    return Section("protocol", title, (Prose(text), terms))


def _provenance_section(report: Report, document: dict[str, Any]) -> Section:
    tables = (provenance_table(document["provenance"]), rows_table(tied_blocks(report)))
    return Section("provenance", "Provenance", tables)


def _citation_section(subject: Subject) -> Section:
    origin, protocol = subject.document["provenance"], subject.document["protocol"]
    numbers = (
        f"These numbers: relightlab {origin['project']}, commit `{origin['commit']}`, protocol"
        f" {protocol['name']} version {protocol['version']}, data hash"
        f" `{origin['data_hash'][:12]}`."
    )
    texts = (METHOD, numbers, *(() if subject.dataset.name == SYNTHETIC else (PHOTOGRAPHS,)))
    return Section("cite", "How to cite", tuple(Prose(text) for text in texts))


def _checked(subject: Subject) -> Subject:
    document, dataset = subject.document, subject.dataset
    if document["provenance"]["dataset"] != dataset.name:
        raise RelightlabError(
            f"the result was measured on {document['provenance']['dataset']} but the pictures"
            f" would come from {dataset.name}: give the dataset of the result"
        )
    if document["protocol"]["lights"] != len(subject.lights):
        raise RelightlabError(
            f"the result has {document['protocol']['lights']} lights but {len(subject.lights)}"
            " were given: give the lights of the result"
        )
    if not subject.objects:
        raise RelightlabError("the result reports no object: measure at least one")
    return subject
