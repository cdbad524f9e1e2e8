"""The page of Table 1: one HTML file that needs nothing else, and no network."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

import evaluation.table1
from datasets.atomic import atomic_path
from datasets.records import Dataset
from reports.decomposition_figure import decomposition_figure, teaser_figure
from reports.error_figure import object_error_figure, table_shape_figure
from reports.figures import PanelFigure
from reports.gallery_figure import gallery_figure
from reports.light_fit_figure import light_fit_figure
from reports.pictures import diverging_stops
from reports.subject import Subject
from reports.table1_entries import PUBLISHED_RULES, RULES, missing_reasons, table1_rows
from reports.table1_verdict import detail_effect, table1_verdict
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ModelParameters

TEMPLATE = "table1.html.j2"
SYNTHETIC = "synthetic"

PANEL_FIGURES: dict[str, Callable[[Subject], Sequence[PanelFigure]]] = {
    "decomposition": lambda subject: [decomposition_figure(subject)],
    "light fits": lambda subject: [light_fit_figure(subject)],
    "gallery": lambda subject: [gallery_figure(subject, setting) for setting in subject.settings],
}
"""Every figure of pictures, in the order of the page; a new one is a line here."""


def write_page(
    path: str | os.PathLike[str],
    *,
    document: dict[str, Any],
    dataset: Dataset,
    lights: Sequence[LogHarmonics],
    parameters: ModelParameters,
) -> None:
    """Write the page of a measured Table 1.

    The same arguments give the same bytes. The models of the objects shown are built again,
    which takes some seconds.

    Parameters
    ----------
    path : path
        The HTML file to write, whole or not at all.
    document : dict
        What `evaluation.table1_results.table1_document` returns.
    dataset : Dataset
        The set the result was measured on.
    lights : sequence of LogHarmonics
        The lights of the result.
    parameters : ModelParameters
        As the result was measured with.

    Raises
    ------
    RelightlabError
        If the document is of another dataset or other lights, reports no object, or the file
        cannot be written.
    """
    # Opened first: an unwritable place is noticed before the models are built.
    with atomic_path(path) as temporary:
        subject = _checked(Subject(document, dataset, tuple(lights), parameters))
        temporary.write_text(page_text(subject), encoding="utf-8")


def page_text(subject: Subject) -> str:
    """Return the page of a result as HTML.

    Parameters
    ----------
    subject : Subject

    Returns
    -------
    str
    """
    document = subject.document
    return (
        _environment()
        .get_template(TEMPLATE)
        .render(
            document=document,
            settings=subject.settings,
            rules=RULES,
            published_rules=PUBLISHED_RULES,
            tables={setting: table1_rows(document, setting) for setting in subject.settings},
            verdict=table1_verdict(document),
            detail_effect=detail_effect(document),
            synthetic=subject.dataset.name == SYNTHETIC,
            incomplete=missing_reasons(document, len(subject.dataset.objects)),
            teaser=teaser_figure(subject),
            plots=[table_shape_figure(subject), object_error_figure(subject)],
            objects=object_table(document),
            figures=[figure for make in PANEL_FIGURES.values() for figure in make(subject)],
            protocol=protocol_sections(evaluation.table1.__doc__ or ""),
            stops=diverging_stops(),
        )
    )


def object_table(document: dict[str, Any]) -> dict[str, dict[str, dict[str, Any]]]:
    """Return all that was measured on each object: by object, setting, then quantity.

    Parameters
    ----------
    document : dict

    Returns
    -------
    dict
        Quantities are ``lmse``, ``point_light_residual``, ``harmonic_residual`` and
        ``<detail source> <weight rule>``.
    """
    table: dict[str, dict[str, dict[str, Any]]] = {}
    for row in document["intrinsic"]:
        table.setdefault(row["object"], {})[row["setting"]] = dict(row)
    for row in document["objects"]:
        own = table[row["object"]][row["setting"]]
        own[f"{row['detail_source']} {row['weights']}"] = row["imse"]
    return table


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


def code_segments(text: str) -> list[tuple[bool, str]]:
    """Return a text cut at its backticks: whether each piece is code, and the piece.

    Parameters
    ----------
    text : str

    Returns
    -------
    list of (bool, str)

    Examples
    --------
    >>> code_segments("by ``k`` or `eq:model`")
    [(False, 'by '), (True, 'k'), (False, ' or '), (True, 'eq:model')]
    """
    pieces = re.split(r"`{1,2}([^`]+)`{1,2}", text)
    return [(bool(place % 2), piece) for place, piece in enumerate(pieces) if piece]


def symbol_segments(text: str) -> list[tuple[str, str]]:
    """Return a text cut at its one-letter indices: each piece, and the index that follows it.

    Parameters
    ----------
    text : str

    Returns
    -------
    list of (str, str)

    Examples
    --------
    >>> symbol_segments("the residual S_p alone")
    [('the residual S', 'p'), (' alone', '')]
    """
    pieces = re.split(r"(?<=\b[A-Zw])_(\w)\b", text)
    return list(zip(pieces[::2], [*pieces[1::2], ""], strict=True))


def _number(value: float | None, digits: int = 5) -> str:
    return "–" if value is None else f"{value:.{digits}f}"  # noqa: RUF001  an en dash: no value


def _percent(value: float | None) -> str:
    return "–" if value is None else f"{100 * value:.1f} %"  # noqa: RUF001  as above


def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "number": _number,
        "percent": _percent,
        "segments": code_segments,
        "symbols": symbol_segments,
    }
    return environment


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
