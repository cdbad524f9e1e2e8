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
    of the photograph, and the albedo I / S*. (b) ``sirfs-shading``: the shading S' of SIRFS (see
    below), which is coloured, and the albedo I / S'. Albedos are per channel; the shading that
    detail is derived from is the mean over the channels.
B + M
    SIRFS (`evaluation.sirfs`) fits shape, albedo and light to the same photograph in colour, by the
    light model of the setting's name (``laboratory`` where there is none of that name). Its entry
    is its own albedo under the new light on its own shape, ``A exp(B(N) . L)``, without detail
    layers or weights; in ``gray`` the albedo of the colour fit is averaged as any other. The
    contour that its shape bends away at is that of the object: the mask of the laboratory
    photograph where there is one, for a natural photograph of MIT-Berkeley is blank where the
    depth is not known. Pixels of the mask that are black in a channel are not explained by the fit
    and count as black. Its priors were trained on the ten training objects of MIT-Berkeley, their
    albedos and shapes, so its errors on those are optimistic, and so are those of (b): the same
    entries over the ten test objects stand beside (``test_rows``).
    A fit that fails leaves its cells missing. A quick run leaves out (b) and B + M, and lists them
    as open.
Weights
    ``oracle``: joint least squares over k, k w_p, k w_g for each cell. ``regression``: see
    `evaluation.weight_rules.regressed`; its training points always come from all other objects of
    the dataset, whichever are reported. ``default``: (1, 1). ``manual``: what the user gives, by
    default (0.5, 0.5). ``coarse``: (0, 0). B + M: ``none``.
Error
    ``IMSE' = min_k |I - k A S|^2 / n`` (`eq:MSEmetric`) over the n pixels of the mask whose true
    normal is known, k >= 0 for each cell; a table entry is the mean over its cells, and its
    relative error is that mean over the cells' mean of I^2.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from datasets.records import Dataset
from evaluation.experiment import Experiment
from evaluation.grid_run import DEFAULT_OPTIONS, Progress, RunOptions, run_grid
from evaluation.grid_status import GridStatus
from evaluation.kept_models import KeptModels
from evaluation.model_parts import PAPER_PARTS, ModelParts
from evaluation.object_measurement import ObjectResult
from evaluation.object_sets import HELD_OUT, object_sets
from evaluation.rerendering import monochrome_coefficients
from evaluation.row_store import MemoryRows, Rows
from evaluation.sirfs_fits import SirfsFits
from evaluation.sirfs_measurement import RIVAL, SIRFS_SHADING
from evaluation.stored_cells import missing_reason
from evaluation.table1_grid import (
    BASELINE,
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
RIVAL_ENTRY = {"method": "sirfs", "detail_source": "default", "weights": "none"}
"""What the row of B + M is called, as in the published table."""
UNKEPT = SirfsFits()
"""Fits that are made whenever they are needed."""


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
                "imse": _mean(row),
                "relative_imse": _mean(row) / self._power(setting, name),
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
        return _mean(np.array(powers))

    def _row(
        self, setting: str, entry: Mapping[str, str], errors: Float
    ) -> dict[str, str | float | int]:
        imse = _mean(errors)
        return {
            "dataset": self.dataset,
            "setting": setting,
            **entry,
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
    quick: bool = False,
    fits: SirfsFits = UNKEPT,
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
    quick : bool
        Leave out the entries that need SIRFS, some seconds for each object and setting.
    fits : SirfsFits
        Where fits of SIRFS are kept.
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
        Table1Context(
            *(dataset, tuple(lights), parameters, channels, parts, kept),
            fits=None if quick else fits,
        ),
        seed,
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
        reason = missing_reason(status.rows.get(key))
        found.append(MissingCell(dict(zip(experiment.axes, key, strict=True)), reason))
    return tuple(found)
