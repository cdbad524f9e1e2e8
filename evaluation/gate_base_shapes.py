"""What the regression gate measures of the study of base shapes: the shapes that need no fit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from datasets.model_parameters import shipped_parameters
from datasets.records import Dataset
from evaluation.base_shape_grid import base_shape_experiment
from evaluation.base_shape_models import SETTING, BaseShapeContext
from evaluation.base_shape_table import BaseShapeTable, base_shape_table
from evaluation.base_shapes import BASE_SHAPES, FITTED_SHAPES
from evaluation.grid_run import Progress, RunOptions, run_grid
from evaluation.row_store import MemoryRows
from evaluation.study_variants import TABLE

SHAPES = tuple(shape for shape in BASE_SHAPES if shape not in FITTED_SHAPES)
RULES = ("default", "oracle")
"""The rules that an object's own cells decide; a regression would need more objects."""


def shape_variants() -> tuple[str, ...]:
    """Return the words that follow setting and object in the name of an error of a base shape.

    Returns
    -------
    tuple of str

    Examples
    --------
    >>> shape_variants()[0], len(shape_variants())
    ('base-shape contour default', 8)
    """
    return tuple(f"base-shape {shape} {rule}" for shape in SHAPES for rule in RULES)


def measure_shapes(
    dataset: Dataset, options: RunOptions, progress: Progress | None = None
) -> tuple[dict[str, Sequence[float]], tuple[str, ...]]:
    """Measure Table 2 on a dataset without the shapes that take a fit.

    Parameters
    ----------
    dataset : Dataset
        With photographs under known lights.
    options : RunOptions
    progress : callable, optional

    Returns
    -------
    dict of sequences of float
        By ``setting object base-shape shape rule``, one number for each light; NaN where it could
        not be measured.
    tuple of str
        Why not.
    """
    context = BaseShapeContext(dataset, shipped_parameters())
    experiment = base_shape_experiment(context, shapes=SHAPES)
    table = base_shape_table(experiment, run_grid(experiment, MemoryRows(), options, progress))
    reasons = tuple(dict.fromkeys(missing["reason"] for missing in table.missing))
    return dict(_rows(table)), reasons


def _rows(table: BaseShapeTable) -> Iterator[tuple[str, Sequence[float]]]:
    for shape in SHAPES:
        for rule in RULES:
            errors = table.errors[TABLE, shape, rule]
            for name, row in zip(table.objects, errors, strict=True):
                yield f"{SETTING} {name} base-shape {shape} {rule}", row.tolist()
