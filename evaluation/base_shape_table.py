"""Table 2 made of its rows: errors of every base shape, their intervals, tests and sensitivity."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from evaluation.base_shape_grid import LIGHT_VALUES
from evaluation.base_shapes import RIVAL_SHAPES
from evaluation.cell_values import cell_of_values
from evaluation.experiment import CellKey, Experiment
from evaluation.grid_status import GridStatus
from evaluation.known_values import mean_of_known
from evaluation.paired_statistics import (
    PairedMeans,
    friedman_test,
    paired_means,
    pairwise_tests,
)
from evaluation.stored_cells import missing_reason
from evaluation.study_variants import TABLE, VARIANTS
from evaluation.weight_rules import CellGrid, regressed_by_own_lights
from shading_model.arrays import Float, Mask
from shading_model.object_model import Weights
from shading_model.seeds import generator_for

RULES = ("default", "oracle", "regression")
REFERENCE = "contour"
Row = dict[str, Any]


@dataclass(frozen=True, eq=False)
class BaseShapeTable:
    """Errors of the study of base shapes.

    Parameters
    ----------
    dataset : str
    objects, shapes, variants : tuple of str
    errors : dict of (objects, lights) arrays
        IMSE by (variant, shape, rule); NaN where a cell is missing.
    power : dict of (objects, lights) arrays
        Mean squared target by variant.
    missing : tuple of dict of str
        Cells without a result, with the ``reason``.
    """

    dataset: str
    objects: tuple[str, ...]
    shapes: tuple[str, ...]
    variants: tuple[str, ...]
    errors: Mapping[tuple[str, str, str], Float]
    power: Mapping[str, Float]
    missing: tuple[dict[str, str], ...]

    def rows(self, variant: str = TABLE) -> list[Row]:
        """Return the entries of the table in one variant, shapes by rules.

        Parameters
        ----------
        variant : str

        Returns
        -------
        list of dict
            ``dataset, shape, weights``; ``imse``, the mean over objects of the mean over lights,
            and ``low, high``, its interval; ``relative_imse``, over the mean squared target;
            ``difference`` to the contour shape with ``difference_low, difference_high``, paired,
            NaN where that was not measured; ``objects``, ``cells``. An object that a shape failed
            on is left out of all means, a shape that failed on every object leaves none out.
        """
        return [row for rule in RULES for row in self._rule_rows(variant, rule)]

    def _rule_rows(self, variant: str, rule: str) -> Iterator[Row]:
        means = self._means(variant, rule)
        shared = self._shared_objects(variant, rule)
        for index, shape in enumerate(self.shapes):
            errors = self.errors[variant, shape, rule]
            whole = np.isfinite(errors).any(axis=1) & shared
            yield {
                "dataset": self.dataset,
                "shape": shape,
                "weights": rule,
                "imse": float(means.mean[index]),
                "relative_imse": mean_of_known(errors[whole])
                / mean_of_known(self.power[variant][whole]),
                "low": float(means.low[index]),
                "high": float(means.high[index]),
                "difference": float(means.difference[index]),
                "difference_low": float(means.difference_low[index]),
                "difference_high": float(means.difference_high[index]),
                "objects": int(whole.sum()),
                "cells": int(np.isfinite(errors).sum()),
            }

    def object_rows(self, variant: str = TABLE) -> list[Row]:
        """Return the errors of every object: ``object, shape, weights, imse, relative_imse``.

        Parameters
        ----------
        variant : str
        """
        return [
            {
                "object": name,
                "shape": shape,
                "weights": rule,
                "imse": mean_of_known(self.errors[variant, shape, rule][index]),
                "relative_imse": mean_of_known(self.errors[variant, shape, rule][index])
                / mean_of_known(self.power[variant][index]),
            }
            for rule in RULES
            for index, name in enumerate(self.objects)
            for shape in self.shapes
        ]

    def tests(self, variant: str = TABLE) -> list[Row]:
        """Return Friedman's test over the published four shapes, for each rule, where it applies.

        Parameters
        ----------
        variant : str

        Returns
        -------
        list of dict
            ``weights, statistic, p, objects, methods``.
        """
        found = ((rule, friedman_test(self._relative(variant, rule))) for rule in RULES)
        return [{"weights": rule, **test} for rule, test in found if test]

    def pairs(self, variant: str = TABLE) -> list[Row]:
        """Return wins and tests of the pairs of the published four shapes, by relative error.

        Parameters
        ----------
        variant : str

        Returns
        -------
        list of dict
            ``weights`` and what `evaluation.paired_statistics.pairwise_tests` gives; Holm's
            correction is over the pairs of one rule.
        """
        return [
            {"weights": rule, **row}
            for rule in RULES
            for row in pairwise_tests(self._relative(variant, rule), self.rivals)
        ]

    def sensitivity(self) -> list[Row]:
        """Return, for every variant and rule, the errors by shape and the order of the rivals.

        Returns
        -------
        list of dict
            ``variant, words, weights``; ``imse`` by shape; ``order``, the published four from
            best to worst; ``friedman_p`` where it applies.
        """
        return [self._sensitivity_row(variant, rule) for variant in self.variants for rule in RULES]

    def _sensitivity_row(self, variant: str, rule: str) -> Row:
        errors = {s: mean_of_known(self.errors[variant, s, rule]) for s in self.shapes}
        known = [shape for shape in self.rivals if np.isfinite(errors[shape])]
        test = friedman_test(self._relative(variant, rule))
        return {
            "variant": variant,
            "words": VARIANTS[variant].words,
            "weights": rule,
            "imse": errors,
            "order": sorted(known, key=lambda shape: errors[shape]),
            "friedman_p": test["p"] if test else None,
        }

    @cached_property
    def rivals(self) -> tuple[str, ...]:
        """The shapes of the published table that were measured."""
        return tuple(shape for shape in self.shapes if shape in RIVAL_SHAPES)

    def _shared_objects(self, variant: str, rule: str) -> Mask:
        """Return the objects known on every shape that is known on any."""
        errors = (self.errors[variant, shape, rule] for shape in self.shapes)
        known = np.array([np.isfinite(one).any(axis=1) for one in errors])
        shared: Mask = np.asarray(known[known.any(axis=1)].all(axis=0))
        return shared

    def _means(self, variant: str, rule: str) -> PairedMeans:
        columns = [_row_means(self.errors[variant, shape, rule]) for shape in self.shapes]
        generator = generator_for("base shapes", self.dataset, variant, rule)
        reference = self.shapes.index(REFERENCE) if REFERENCE in self.shapes else None
        return paired_means(np.stack(columns, axis=1), reference, generator)

    def _relative(self, variant: str, rule: str) -> Float:
        """Return the relative error of the rivals, (objects, rivals)."""
        power = _row_means(self.power[variant])
        columns = [_row_means(self.errors[variant, shape, rule]) for shape in self.rivals]
        return np.stack(columns, axis=1) / power[:, None] if columns else np.zeros((len(power), 0))


def base_shape_table(experiment: Experiment, status: GridStatus) -> BaseShapeTable:
    """Return the table that the rows of a store hold.

    Parameters
    ----------
    experiment : Experiment
        As `evaluation.base_shape_grid.base_shape_experiment` makes it.
    status : GridStatus

    Returns
    -------
    BaseShapeTable
    """
    axes = experiment.axes
    errors: dict[tuple[str, str, str], Float] = {}
    power: dict[str, Float] = {}
    for variant in axes["variant"]:
        for shape in axes["shape"]:
            values = _values(experiment, status, variant, shape)
            for rule, found in _errors_by_rule(values).items():
                errors[variant, shape, rule] = found
            seen = np.array([[one.get("power", np.nan) for one in row] for row in values])
            power[variant] = np.where(np.isfinite(seen), seen, power.get(variant, seen))
    missing = tuple(_missing(experiment, status, key) for key in status.missing)
    return BaseShapeTable(
        experiment.context.dataset.name,
        axes["object"],
        axes["shape"],
        axes["variant"],
        errors,
        power,
        missing,
    )


def _values(
    experiment: Experiment, status: GridStatus, variant: str, shape: str
) -> list[list[Mapping[str, float]]]:
    """Return what was measured with a shape, objects by lights; empty where a cell is missing."""

    def one(key: CellKey) -> Mapping[str, float]:
        row = status.rows.get(key)
        return row["values"] if row else {}

    return [
        [one((variant, name, shape, light)) for light in experiment.axes["light"]]
        for name in experiment.axes["object"]
    ]


def _errors_by_rule(values: list[list[Mapping[str, float]]]) -> dict[str, Float]:
    cells = tuple(tuple(cell_of_values(one) for one in row) for row in values)
    lights = np.array(
        [[[one.get(name, np.nan) for name in LIGHT_VALUES] for one in row] for row in values]
    )
    grid = CellGrid(cells, lights[0])
    weights = {
        "default": grid.constant(Weights(1.0, 1.0)),
        "oracle": grid.oracle,
        "regression": regressed_by_own_lights(grid.oracle, lights),
    }
    return {rule: grid.errors(weights[rule]) for rule in RULES}


def _missing(experiment: Experiment, status: GridStatus, key: CellKey) -> dict[str, str]:
    place = dict(zip(experiment.axes, key, strict=True))
    return {**place, "reason": missing_reason(status.rows.get(key))}


def _row_means(values: Float) -> Float:
    """Return the mean of the known values of each row, NaN where there are none."""
    return np.array([mean_of_known(row) for row in values])
