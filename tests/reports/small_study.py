"""Studies of base shapes for tests of the report: made-up ones at no cost, and a small real one."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from evaluation.base_shape_table import RULES, BaseShapeTable
from evaluation.published_table2 import PUBLISHED
from evaluation.sirfs.fit import FitOptions
from evaluation.sirfs.result import SirfsFit
from evaluation.sirfs_fits import SirfsFits
from evaluation.study_variants import VARIANTS
from reports.base_shape_run import BaseShapeStudy, StudyChoice, measure_base_shapes
from reports.base_shape_views import with_generic_view
from shading_model.arrays import Float, Image, Mask
from tests.evaluation.sirfs.fake_fits import flat_fit, pretend
from tests.reports.small_result import SmallResult, provenance

POWER = 0.1
"""Mean squared photograph of every made-up object."""
GROWTH = 0.01
"""Share by which errors grow from one object to the next: tied differences make Wilcoxon slow."""
PAPERS = {"contour": 0.03, "kinect": 0.031, "sirfs": 0.033, "sirfs-stereo": 0.019}
"""Errors in the paper's order and proportions."""
BOUNDS = {"ground-truth": 0.01, "flat": 0.06}


def study_document(
    errors: Mapping[str, float] | None = None,
    objects: int = 12,
    dataset: str = "mit-berkeley",
    variants: Mapping[str, Mapping[str, float]] | None = None,
    **changes: Any,
) -> dict[str, Any]:
    """Return a document with the given mean errors, every object in the same order.

    Parameters
    ----------
    errors : mapping of float
        By shape; those of the paper and the bounds by default. NaN is a shape that failed.
    objects : int
    dataset : str
    variants : mapping of mappings
        Errors by shape in variants other than the table's.
    **changes
        Parts put in place of the document's own.
    """
    own = {**PAPERS, **BOUNDS} if errors is None else dict(errors)
    every = {"mean": own, **(variants or {})}
    key = tuple((variant, tuple(given.items())) for variant, given in every.items())
    return copy.deepcopy(_document(key, objects, dataset)) | changes


@cache
def _document(
    every: tuple[tuple[str, tuple[tuple[str, float], ...]], ...], objects: int, dataset: str
) -> dict[str, Any]:
    errors = {variant: dict(given) for variant, given in every}
    shapes = tuple(errors["mean"])
    table = BaseShapeTable(
        dataset,
        tuple(f"object {number:02d}" for number in range(objects)),
        shapes,
        tuple(errors),
        {
            (variant, shape, rule): _about(given.get(shape, np.nan), objects)
            for variant, given in errors.items()
            for shape in shapes
            for rule in RULES
        },
        {variant: np.full((objects, 1), POWER) for variant in errors},
        (),
    )
    protocol = {"name": "base-shapes", "version": 1, "variant": "mean", "channels": "gray"}
    return {
        "protocol": protocol | {"words": VARIANTS["mean"].words, "lights": 1},
        "rows": [_without_nan(row) for row in table.rows()],
        "objects": [_without_nan(row) for row in table.object_rows()],
        "tests": table.tests(),
        "pairs": [_without_nan(row) for row in table.pairs()],
        "sensitivity": [row | {"imse": _without_nan(row["imse"])} for row in table.sensitivity()],
        "published": [dict(row) for row in PUBLISHED],
        "quick": False,
        "missing": [],
        "provenance": provenance(dataset=dataset).document(),
    }


def _about(mean: float, objects: int) -> Float:
    """Return errors of objects with a mean, (objects, 1)."""
    steps = np.arange(objects) - (objects - 1) / 2
    errors: Float = (mean * (1 + GROWTH * steps))[:, None]
    return errors


def _without_nan(row: Mapping[str, Any]) -> dict[str, Any]:
    return {key: None if value != value else value for key, value in row.items()}  # noqa: PLR0124


@dataclass(frozen=True)
class FlatFits(SirfsFits):
    """Fits that cost nothing: the flat shape."""

    def fit_images(
        self,
        images: Sequence[Image],
        mask: Mask,
        options: FitOptions,
        outline: Mask | None = None,  # noqa: ARG002
    ) -> SirfsFit:
        """Return the flat fit to the first photograph."""
        return flat_fit(images[0], mask, 1.0, options)


@pytest.fixture(scope="session")
def small_study(small_result: SmallResult) -> BaseShapeStudy:
    """Three objects of 64 pixels on all shapes, with the generic-view check; SIRFS is a fake."""
    with pytest.MonkeyPatch.context() as patch:
        pretend(patch)
        study = measure_base_shapes(small_result.dataset, StudyChoice())
    return with_generic_view(replace(study, context=replace(study.context, fits=FlatFits())))
