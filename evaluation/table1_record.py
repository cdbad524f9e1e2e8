"""Table 1 as it was measured: its entries, by object and over objects, and what is missing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from evaluation.known_values import mean_of_known
from evaluation.object_measurement import ObjectResult
from evaluation.object_sets import HELD_OUT, object_sets
from evaluation.sirfs_measurement import RIVAL, SIRFS_SHADING
from evaluation.table1_grid import BASELINE, DETAIL_SOURCES
from evaluation.weight_rules import MANUAL, WEIGHT_RULES, CellGrid, WeightRule, checked_weights
from shading_model.arrays import Float
from shading_model.object_model import Weights

RIVAL_ENTRY = {"method": "sirfs", "detail_source": "default", "weights": "none"}
"""What the row of B + M is called, as in the published table."""


@dataclass(frozen=True, eq=False)
class MissingCell:
    """A cell without a result, and why.

    Parameters
    ----------
    cell : dict of str
        Its value on each axis.
    reason : str
    """

    cell: dict[str, str]
    reason: str


@dataclass(frozen=True, eq=False)
class Table1:
    """Table 1 of one dataset.

    Parameters
    ----------
    dataset : str
    objects : tuple of str
        The objects reported.
    channels : str
    coefficients : (l, 9) array
        The lights.
    results : tuple of ObjectResult
        All objects of the dataset, in every setting.
    manual : Weights
    missing : tuple of MissingCell
        Cells of the grid without a result; means are over the others.
    method : str
        What the rows call it: ``ours``, and the parts of one's own.
    rules : dict of WeightRule
        Those of Table 1, and those of one's own.
    """

    dataset: str
    objects: tuple[str, ...]
    channels: str
    coefficients: Float
    results: tuple[ObjectResult, ...]
    manual: Weights = MANUAL
    missing: tuple[MissingCell, ...] = ()
    method: str = "ours"
    rules: Mapping[str, WeightRule] = field(default_factory=lambda: dict(WEIGHT_RULES))

    def rows(self) -> list[dict[str, str | float | int]]:
        """Return one row per table entry: for each setting our models, then B + M."""
        return [
            self._row(setting, entry, errors)
            for setting in self.settings()
            for entry, errors in self._entries(setting)
        ]

    def test_rows(self) -> list[dict[str, str | float | int]]:
        """Return the same entries over the test objects alone, where the dataset has such."""
        sets = object_sets(self.dataset, self.objects)
        if HELD_OUT not in sets:
            return []
        return replace(self, objects=sets[HELD_OUT]).rows()

    def baselines(self) -> list[dict[str, str | float | int]]:
        """Return the rows of the Retinex albedo on a flat shape, whose shading is constant."""
        entry = {"method": self.method, "detail_source": BASELINE, "weights": "coarse"}
        return [
            self._row(setting, entry, self.errors(setting, BASELINE, "coarse"))
            for setting in self.settings()
        ]

    def object_rows(self) -> list[dict[str, str | float | int]]:
        """Return the mean error of every object in every table entry."""
        return [
            {
                "dataset": self.dataset,
                "setting": setting,
                "object": name,
                **entry,
                "imse": mean_of_known(row),
                "relative_imse": mean_of_known(row) / self._power(setting, name),
                "cells": int(np.isfinite(row).sum()),
            }
            for setting in self.settings()
            for entry, errors in self._entries(setting)
            for name, row in zip(self.objects, errors, strict=True)
        ]

    def intrinsic_rows(self) -> list[dict[str, str | float | int]]:
        """Return the LMSE of Retinex and both illumination fits' residuals for every object."""
        return [
            {
                "dataset": self.dataset,
                "setting": result.setting,
                "object": result.name,
                "lmse": result.retinex_error,
                "point_light_residual": result.point_light_residual,
                "harmonic_residual": result.harmonic_residual,
            }
            for result in self.results
            if result.name in self.objects
        ]

    def missing_entries(self) -> tuple[MissingCell, ...]:
        """Return the missing cells that the reported entries lack."""
        return tuple(
            missing
            for missing in self.missing
            if missing.cell["object"] in self.objects and missing.cell["detail_source"] != BASELINE
        )

    @property
    def quick(self) -> bool:
        """Whether the entries that need SIRFS were left out."""
        return SIRFS_SHADING not in self.sources()

    def sources(self) -> tuple[str, ...]:
        """Return the detail sources measured, B + M and the baseline among them."""
        return tuple(dict.fromkeys(source for result in self.results for source in result.cells))

    def settings(self) -> tuple[str, ...]:
        """Return the settings measured, in order."""
        return tuple(dict.fromkeys(result.setting for result in self.results))

    def errors(self, setting: str, source: str, rule: str) -> Float:
        """Return the errors of the reported objects under one rule, (objects, lights).

        Parameters
        ----------
        setting, source, rule : str

        Returns
        -------
        (objects, lights) array
            NaN where a rule has nothing to learn from (regression on a set of one object).
        """
        chosen = [result for result in self.results if result.setting == setting]
        grid = CellGrid(
            tuple(result.cells[source] for result in chosen), self.coefficients, self.manual
        )
        known = {**WEIGHT_RULES, **self.rules}
        reported = [result.name in self.objects for result in chosen]
        return grid.errors(checked_weights(grid, rule, known[rule]))[reported]

    def _entries(self, setting: str) -> Iterator[tuple[dict[str, str], Float]]:
        measured = self.sources()
        for source in DETAIL_SOURCES:
            for rule in self.rules if source in measured else ():
                entry = {"method": self.method, "detail_source": source, "weights": rule}
                yield entry, self.errors(setting, source, rule)
        if RIVAL in measured:
            yield dict(RIVAL_ENTRY), self.errors(setting, RIVAL, "coarse")

    def _power(self, setting: str, name: str | None = None) -> float:
        powers = [
            cell.power
            for result in self.results
            if result.setting == setting
            and (result.name == name if name else result.name in self.objects)
            for cell in result.cells["default"]
        ]
        return mean_of_known(np.array(powers))

    def _row(
        self, setting: str, entry: Mapping[str, str], errors: Float
    ) -> dict[str, str | float | int]:
        imse = mean_of_known(errors)
        return {
            "dataset": self.dataset,
            "setting": setting,
            **entry,
            "imse": imse,
            "relative_imse": imse / self._power(setting),
            "cells": int(np.isfinite(errors).sum()),
        }
