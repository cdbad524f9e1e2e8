"""The sections of the report about base shapes (Table 2), for one dataset."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from reports.base_shape_figure import base_shape_figure
from reports.base_shape_gallery import picture_figures
from reports.base_shape_run import BaseShapeStudy
from reports.base_shape_sensitivity import sensitivity_table, sensitivity_words
from reports.base_shape_tables import object_table, pair_table, shape_table
from reports.base_shape_verdict import (
    gap_words,
    shape_findings,
    significance_words,
    verdict_words,
)
from reports.base_shape_views import PART, view_figure
from reports.base_shape_words import (
    CAVEATS,
    INTRODUCTION,
    SENSOR,
    SENSOR_NOTE,
    SIMULATED_NOTE,
    Document,
    file_of,
    key_of,
    measured_shapes,
    set_words,
    shape_words,
)
from reports.content import (
    Block,
    Folded,
    Judgements,
    Pictures,
    Plot,
    Prose,
    Remarks,
    Section,
    Table,
)
from reports.rows_behind import rows_behind
from reports.table1_section import judged
from reports.table1_tables import provenance_table


def base_shape_sections(study: BaseShapeStudy) -> tuple[Section, ...]:
    """Return what the report says of the study of base shapes on one dataset.

    Parameters
    ----------
    study : BaseShapeStudy
        Models of the objects shown are built again, on the fits that its context keeps.

    Returns
    -------
    tuple of Section
        Table 2 with its verdict, figure and sensitivity; the pictures; and the generic-view
        check, where `reports.base_shape_views.with_generic_view` made it.
    """
    words = shape_words(study.context.dataset)
    views = _view_section(study.document, words)
    return (
        _table_section(study.document, words),
        _picture_section(study, words),
        *([views] if views else []),
    )


def section_title(document: Document) -> str:
    """Return the title of the first section on a dataset.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    str

    Examples
    --------
    >>> section_title({"provenance": {"dataset": "mit-berkeley"}})
    'Table 2: the base shape, on MIT-Berkeley'
    """
    return f"Table 2: the base shape, on {set_words(document['provenance']['dataset'])}"


def _table_section(document: Document, words: Mapping[str, str]) -> Section:
    findings = shape_findings(document, words)
    figure = base_shape_figure(document, words)
    tables = (pair_table(document, words),) if document["pairs"] else ()
    behind = rows_behind(document, "rows", "objects", file=file_of(document))
    blocks: tuple[Block, ...] = (
        Prose(f"{{Verdict.}} {verdict_words(document, findings)}", "verdict"),
        Judgements(judged(findings)),
        *(Prose(text) for text in _readings(document, words) if text),
        shape_table(document, words),
        *_notes(document, words),
        *([Folded("Pairs of shapes", tables)] if tables else []),
        Plot(figure, behind),
        Folded("All values by object", (object_table(document, words),)),
        *_sensitivity(document, words),
        Folded("What is needed to run this again", (_provenance(document),)),
    )
    return Section(f"table-2-{key_of(document)}", section_title(document), blocks)


def _readings(document: Document, words: Mapping[str, str]) -> Iterable[str]:
    protocol = document["protocol"]
    yield (
        f"{INTRODUCTION} Here: {protocol['lights']} lights, models from the {protocol['words']},"
        f" compared in {'colour' if protocol['channels'] == 'color' else protocol['channels']}."
    )
    yield significance_words(document)
    yield gap_words(document, words)


def _notes(document: Document, words: Mapping[str, str]) -> Iterable[Remarks]:
    """Yield what stands for the Kinect, where it was measured, and what the set favours."""
    caveat = CAVEATS.get(document["provenance"]["dataset"], "")
    real = words["kinect"] == SENSOR
    notes = {
        ("kinect", "What stands for the Kinect"): SENSOR_NOTE if real else SIMULATED_NOTE,
        ("favoured", "What this set favours"): caveat,
    }
    if "kinect" not in measured_shapes(document):
        del notes["kinect", "What stands for the Kinect"]
    items = tuple(
        Section(f"{identifier}-{key_of(document)}", title, (Prose(text),))
        for (identifier, title), text in notes.items()
        if text
    )
    if items:
        yield Remarks(items)


def _sensitivity(document: Document, words: Mapping[str, str]) -> Iterable[Block]:
    text = sensitivity_words(document)
    if text:
        yield Prose(f"{{How the order hangs on the protocol.}} {text}")
        yield sensitivity_table(document, words)


def _provenance(document: Document) -> Table:
    table = provenance_table(document["provenance"])
    return replace(table, identifier=f"facts-{key_of(document)}")


def _picture_section(study: BaseShapeStudy, words: Mapping[str, str]) -> Section:
    document = study.document
    behind = rows_behind(document, "objects", file=file_of(document))
    gallery, lights = picture_figures(study, words)
    blocks = (Pictures(gallery, behind), Pictures(lights, behind))
    return Section(f"base-shape-pictures-{key_of(document)}", gallery.title, blocks)


def _view_section(document: Document, words: Mapping[str, str]) -> Section | None:
    figure = view_figure(document, words)
    if figure is None:
        return None
    behind = rows_behind(document, PART, file=file_of(document))
    title = f"Turned views of the base shapes: {set_words(document['provenance']['dataset'])}"
    return Section(f"turned-views-{key_of(document)}", title, (Plot(figure, behind),))
