"""Table 1: re-rendering error of our object models (`tab:mse`, section `subsec:rerender_error`).

The protocol, with the choices the paper leaves open
----------------------------------------------------
Objects and settings
    All objects of a dataset, each photographed in the settings ``natural`` (shaded by a log-linear
    spherical-harmonic light, no cast shadows) and ``laboratory`` (a real photograph).
Lights
    Twenty draws without replacement from the pool of natural lights, the same for every object and
    every run (seeded by name), each the mean over its colour channels: monochrome, nine
    coefficients.
Target
    ``I = A* exp(B(N*) . L)`` with the true albedo and normals. The light multiplies all colours
    alike and the colour of the light in the source photograph is not the model's fault, so albedos
    are compared as the mean of their channels (``gray``); ``color`` compares all three.
Model
    Built from one photograph of the object in that setting with no knowledge of the truth. The
    coarse shading is ``shade(Z, L) = exp(B(N_Z) . L)``, in the dataset's own convention, with the
    normals of the contour shape's height (epsilon = 1, chosen on the ten training objects of
    MIT-Berkeley). Detail layers enter as they are (`eq:model`); the mean shading of every source
    photograph is one half.
Retinex thresholds
    On a measured set each object's thresholds are learned on the other objects of the same setting
    (`evaluation.retinex_thresholds`); elsewhere the shipped defaults are used.
Detail sources
    (a) ``default``: shading and albedo by colour Retinex. (c) ``gt-shading``: the true shading S*
    of the photograph, and the albedo I / S*. (b) ``sirfs-shading`` and the row of B + M need an
    implementation of SIRFS and are listed as open.
Weights
    ``oracle``: joint least squares over k, k w_p, k w_g for each cell. ``regression``: see
    `evaluation.weight_rules.regressed`; its training points always come from all other objects of
    the dataset, whichever are reported. ``default``: (1, 1). ``manual``: what the user gives, by
    default (0.5, 0.5). ``coarse``: (0, 0).
Error
    ``IMSE' = min_k |I - k A S|^2 / n`` (`eq:MSEmetric`) over the n pixels of the mask whose true
    normal is known, k >= 0 for each cell; a table entry is the mean over its cells, and its
    relative error is that mean over the cells' mean of I^2.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from datasets.records import Dataset
from evaluation.experiment import Experiment
from evaluation.grid_run import DEFAULT_OPTIONS, Progress, RunOptions, run_grid
from evaluation.grid_status import GridStatus
from evaluation.kept_models import KeptModels
from evaluation.model_parts import PAPER_PARTS, ModelParts
from evaluation.object_measurement import ObjectResult
from evaluation.rerendering import monochrome_coefficients
from evaluation.row_store import MemoryRows, Rows
from evaluation.table1_grid import (
    DETAIL_SOURCES,
    NAME,
    VERSION,
    Table1Context,
    object_results,
    table1_experiment,
)
from evaluation.weight_rules import MANUAL, WEIGHT_RULES, CellGrid, WeightRule, checked_weights
from shading_model.arrays import Float
from shading_model.errors import unknown_name
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ModelParameters, Weights

PROTOCOL, PROTOCOL_VERSION = NAME, VERSION


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
        """Return one row per table entry, in the order of the published table."""
        return [
            self._row(setting, source, rule, errors)
            for setting, source, rule, errors in self._entries(DETAIL_SOURCES)
        ]

    def baselines(self) -> list[dict[str, str | float | int]]:
        """Return the rows of the Retinex albedo on a flat shape, whose shading is constant."""
        entries = self._entries(("flat",))
        return [self._row(s, source, r, e) for s, source, r, e in entries if r == "coarse"]

    def object_rows(self) -> list[dict[str, str | float | int]]:
        """Return the mean error of every object in every table entry."""
        return [
            {
                "dataset": self.dataset,
                "setting": setting,
                "object": name,
                "detail_source": source,
                "weights": rule,
                "imse": _mean(row),
                "relative_imse": _mean(row) / self._power(setting, name),
                "cells": int(np.isfinite(row).sum()),
            }
            for setting, source, rule, errors in self._entries(DETAIL_SOURCES)
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
            if missing.cell["object"] in self.objects
            and missing.cell["detail_source"] in DETAIL_SOURCES
        )

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
        reported = [result.name in self.objects for result in chosen]
        return grid.errors(checked_weights(grid, rule, self.rules[rule]))[reported]

    def _entries(self, sources: Iterable[str]) -> Iterator[tuple[str, str, str, Float]]:
        for setting in self.settings():
            for source in sources:
                for rule in self.rules:
                    yield setting, source, rule, self.errors(setting, source, rule)

    def _power(self, setting: str, name: str | None = None) -> float:
        powers = [
            cell.power
            for result in self.results
            if result.setting == setting
            and (result.name == name if name else result.name in self.objects)
            for cell in result.cells["default"]
        ]
        return _mean(np.array(powers))

    def _row(
        self, setting: str, source: str, rule: str, errors: Float
    ) -> dict[str, str | float | int]:
        imse = _mean(errors)
        return {
            "dataset": self.dataset,
            "setting": setting,
            "method": self.method,
            "detail_source": source,
            "weights": rule,
            "imse": imse,
            "relative_imse": imse / self._power(setting),
            "cells": int(np.isfinite(errors).sum()),
        }


def _mean(values: Float) -> float:
    """Return the mean of the finite values, NaN if there are none."""
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else float("nan")


def run_table1(
    dataset: Dataset,
    lights: Sequence[LogHarmonics],
    parameters: ModelParameters,
    *,
    objects: Sequence[str] = (),
    channels: str = "gray",
    manual: Weights = MANUAL,
    seed: str = "",
    parts: ModelParts = PAPER_PARTS,
    rules: Mapping[str, WeightRule] = WEIGHT_RULES,
    store: Rows | None = None,
    kept: KeptModels | None = None,
    options: RunOptions = DEFAULT_OPTIONS,
    progress: Progress | None = None,
) -> Table1:
    """Measure Table 1 on a dataset; the protocol is in this module's docstring.

    Time grows with objects times settings; memory holds as many objects as there are workers. The
    numbers depend on neither workers nor store.

    Parameters
    ----------
    dataset : Dataset
    lights : sequence of LogHarmonics
        One colour each.
    parameters : ModelParameters
        Their Retinex thresholds are used where none were learned for the dataset.
    objects : sequence of str
        The objects to report; all of the dataset by default.
    channels : {"gray", "color"}
    manual : Weights
    seed : str
        Name that the lights were drawn by.
    parts : ModelParts
        Base shape and detail layer of one's own.
    rules : mapping of str to WeightRule
        The weight rules reported.
    store : Rows, optional
        Cells it holds are not measured again; without one, rows are kept in memory.
    kept : KeptModels, optional
        Where object models are kept; without it they are built for each run.
    options : RunOptions
        Workers, scheduler, cells to measure, time limit.
    progress : callable, optional

    Returns
    -------
    Table1

    Raises
    ------
    RelightlabError
        For unknown objects or axes, coloured lights, a store of another protocol version, or data
        that cannot be read.
    """
    for name in objects:
        if name not in dataset.objects:
            raise unknown_name("object", name, dataset.objects)
    coefficients = monochrome_coefficients(lights).T
    experiment = table1_experiment(
        Table1Context(dataset, tuple(lights), parameters, channels, parts, kept), seed
    )
    status = run_grid(experiment, store or MemoryRows(), options, progress)
    chosen = tuple(name for name in dataset.objects if not objects or name in objects)
    results = object_results(experiment, status)
    return Table1(
        dataset.name,
        chosen,
        channels,
        coefficients,
        results,
        manual,
        _missing(experiment, status),
        parts.method,
        rules,
    )


def _missing(experiment: Experiment, status: GridStatus) -> tuple[MissingCell, ...]:
    found = []
    for key in status.missing:
        row = status.rows.get(key)
        reason = row["reason"].strip().splitlines()[-1] if row else "not measured"
        found.append(MissingCell(dict(zip(experiment.axes, key, strict=True)), reason))
    return tuple(found)
