"""The generic-view check (`fig:cube`) over the objects of a study of base shapes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, replace

from threadpoolctl import threadpool_limits

from evaluation.base_shape_models import study_builds
from evaluation.generic_view_study import GenericViewRow, ObjectShape, generic_view_rows
from reports.base_shape_run import BaseShapeStudy
from reports.base_shape_words import Document, key_of, measured_shapes
from reports.console import progress
from reports.figures import PlotFigure
from reports.generic_view_figure import generic_view_figure
from shading_model.errors import RelightlabError

PART = "generic_view"
"""Of the document, the rows of the check."""
SHAPES = ("contour", "sirfs", "ground-truth")
"""Those that are turned: the paper's, the one it is compared with, and the true one."""


def with_generic_view(study: BaseShapeStudy) -> BaseShapeStudy:
    """Add to a study's document how outlines and cast shadows of its shapes behave as views turn.

    Parameters
    ----------
    study : BaseShapeStudy

    Returns
    -------
    BaseShapeStudy
        Its document has ``generic_view``, a row for each shape, object and angle, see
        `evaluation.generic_view_study.GenericViewRow`. A shape that cannot be made of an object,
        whose missing cells the document names, has none.
    """
    rows: list[GenericViewRow] = []
    objects = list(dict.fromkeys(row["object"] for row in study.document["objects"]))
    title = f"turning the shapes of {study.context.dataset.name}"
    with progress(title) as report, threadpool_limits(limits=1):
        for count, name in enumerate(objects, start=1):
            rows += generic_view_rows(_shapes(study, name))
            report(count, len(objects), name)
    return replace(study, document=study.document | {PART: [asdict(row) for row in rows]})


def view_figure(document: Document, words: Mapping[str, str]) -> PlotFigure | None:
    """Return the curves of the check, None where it was not made.

    Parameters
    ----------
    document : mapping
    words : mapping of str
        What the shapes are called.

    Returns
    -------
    PlotFigure or None
    """
    rows = [GenericViewRow(**row) for row in document.get(PART) or []]
    if not rows:
        return None
    return generic_view_figure(rows, f"generic-view-{key_of(document)}", words)


def _shapes(study: BaseShapeStudy, name: str) -> Iterator[ObjectShape]:
    (build, *_) = study_builds(study.context, name)
    for shape in measured_shapes(study.document):
        if shape in SHAPES:
            with suppress(RelightlabError):
                yield ObjectShape(name, shape, build.shape(shape).height, build.mask)
