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
    normals of the contour shape's height. Detail layers enter as they are (`eq:model`); the mean
    shading of every source photograph is one half.
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

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

from datasets.records import Capture, Dataset
from evaluation.intrinsic_metrics import intrinsic_error
from evaluation.rerendering import RerenderingCell, rerendering_cells
from evaluation.retinex_thresholds import thresholds_for
from evaluation.weight_rules import MANUAL, WEIGHT_RULES, CellGrid
from shading_model.arrays import Float
from shading_model.errors import RelightlabError, unknown_name
from shading_model.illumination import LogHarmonics
from shading_model.illumination_fit import fit_harmonics
from shading_model.object_model import (
    CoarseShape,
    ModelParameters,
    ObjectModel,
    Weights,
    assemble_model,
    contour_base,
    split_by_shading,
)
from shading_model.retinex import IntrinsicImages, retinex

PROTOCOL = "table-1"
PROTOCOL_VERSION = 1
DETAIL_SOURCES = ("default", "gt-shading")
DARKEST_SHADING = 1e-3
"""A true shading is not taken below this when a photograph is divided by it."""

PUBLISHED: tuple[dict[str, str | float], ...] = tuple(
    {"setting": setting, "method": method, "detail_source": source, "weights": rule, "imse": imse}
    for setting, method, source, rule, imse in (
        ("natural", "sirfs", "default", "none", 0.0172),
        ("laboratory", "sirfs", "default", "none", 0.0372),
        ("natural", "ours", "default", "regression", 0.0358),
        ("natural", "ours", "default", "oracle", 0.0329),
        ("natural", "ours", "sirfs-shading", "regression", 0.0320),
        ("natural", "ours", "sirfs-shading", "oracle", 0.0274),
        ("natural", "ours", "gt-shading", "regression", 0.0243),
        ("natural", "ours", "gt-shading", "oracle", 0.0206),
        ("laboratory", "ours", "default", "regression", 0.0641),
        ("laboratory", "ours", "default", "oracle", 0.0586),
        ("laboratory", "ours", "sirfs-shading", "regression", 0.0360),
        ("laboratory", "ours", "sirfs-shading", "oracle", 0.0341),
        ("laboratory", "ours", "gt-shading", "regression", 0.0240),
        ("laboratory", "ours", "gt-shading", "oracle", 0.0228),
    )
)
"""The published Table 1 (`tab:mse`). Its lights, and so its scale, are not known."""

OPEN_ENTRIES: tuple[dict[str, str], ...] = tuple(
    {"setting": setting, "method": method, "detail_source": source}
    for setting in ("natural", "laboratory")
    for method, source in (("sirfs", "default"), ("ours", "sirfs-shading"))
)
"""Entries that are not computed yet, because they need SIRFS."""


@dataclass(frozen=True, eq=False)
class ObjectResult:
    """What was measured on one object in one setting.

    Parameters
    ----------
    name, setting : str
    cells : dict of tuples of RerenderingCell
        By detail source, and ``flat`` for the Retinex albedo on a flat shape: one per light.
    retinex_error : float
        LMSE of the Retinex albedo and shading (`intrinsic_error`).
    point_light_residual, harmonic_residual : float
        Root mean square of the Retinex shading minus its fit by five point sources and by nine
        harmonics (`fig:SHlight`).
    """

    name: str
    setting: str
    cells: dict[str, tuple[RerenderingCell, ...]]
    retinex_error: float
    point_light_residual: float
    harmonic_residual: float


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
    """

    dataset: str
    objects: tuple[str, ...]
    channels: str
    coefficients: Float
    results: tuple[ObjectResult, ...]
    manual: Weights = MANUAL

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
                "imse": float(row.mean()),
                "relative_imse": float(row.mean() / self._power(setting, name)),
                "cells": row.size,
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
        return grid.errors(WEIGHT_RULES[rule](grid))[reported]

    def _entries(self, sources: Iterable[str]) -> Iterator[tuple[str, str, str, Float]]:
        for setting in self.settings():
            for source in sources:
                for rule in WEIGHT_RULES:
                    yield setting, source, rule, self.errors(setting, source, rule)

    def _power(self, setting: str, name: str | None = None) -> float:
        powers = [
            cell.power
            for result in self.results
            if result.setting == setting
            and (result.name == name if name else result.name in self.objects)
            for cell in result.cells["default"]
        ]
        return float(np.mean(powers))

    def _row(
        self, setting: str, source: str, rule: str, errors: Float
    ) -> dict[str, str | float | int]:
        imse = float(errors.mean())
        return {
            "dataset": self.dataset,
            "setting": setting,
            "method": "ours",
            "detail_source": source,
            "weights": rule,
            "imse": imse,
            "relative_imse": imse / self._power(setting),
            "cells": int(errors.size),
        }


Progress = Callable[[int, int, str], None]
"""Called with cells done, cells in all, and what was done last."""


def run_table1(
    dataset: Dataset,
    lights: Sequence[LogHarmonics],
    parameters: ModelParameters,
    *,
    objects: Sequence[str] = (),
    channels: str = "gray",
    manual: Weights = MANUAL,
    workers: int = 2,
    progress: Progress | None = None,
) -> Table1:
    """Measure Table 1 on a dataset; the protocol is in this module's docstring.

    Time grows with objects times settings; memory holds `workers` objects. The result does not
    depend on the number of workers.

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
    workers : int
        Processes, each with one BLAS thread.
    progress : callable, optional

    Returns
    -------
    Table1

    Raises
    ------
    RelightlabError
        For unknown objects, coloured lights, or data that cannot be read.
    """
    for name in objects:
        if name not in dataset.objects:
            raise unknown_name("object", name, dataset.objects)
    tasks = [(name, setting) for setting in dataset.settings for name in dataset.objects]
    jobs = (
        delayed(measure_object)(dataset, name, setting, lights, parameters, channels)
        for name, setting in tasks
    )
    results = []
    for result in Parallel(n_jobs=workers, return_as="generator")(jobs):
        results.append(result)
        if progress:
            done = len(results) * len(lights)
            progress(done, len(tasks) * len(lights), f"{result.name} {result.setting}")
    chosen = tuple(name for name in dataset.objects if not objects or name in objects)
    coefficients = np.stack([light.coefficients for light in lights])
    return Table1(dataset.name, chosen, channels, coefficients, tuple(results), manual)


def measure_object(
    dataset: Dataset,
    name: str,
    setting: str,
    lights: Sequence[LogHarmonics],
    parameters: ModelParameters,
    channels: str = "gray",
) -> ObjectResult:
    """Build an object's models in one setting and relight them under every light.

    Parameters
    ----------
    dataset : Dataset
    name, setting : str
    lights : sequence of LogHarmonics
    parameters : ModelParameters
    channels : {"gray", "color"}

    Returns
    -------
    ObjectResult
    """
    with threadpool_limits(limits=1):
        capture = dataset.load(name, setting)
        photograph, truth = capture.photograph, capture.truth
        shape = contour_base(photograph.mask, parameters)
        thresholds = thresholds_for(dataset.name, setting, name) or parameters.thresholds
        parts = retinex(photograph.image, photograph.mask, thresholds)
        models = {
            "default": assemble_model(photograph.mask, shape, parts, parameters),
            "gt-shading": assemble_model(photograph.mask, shape, true_parts(capture), parameters),
        }
        models["flat"] = _flattened(models["default"])
        cells = {
            source: rerendering_cells(model, truth, lights, channels)
            for source, model in models.items()
        }
        return ObjectResult(
            name,
            setting,
            cells,
            _retinex_error(parts, capture),
            _point_light_residual(models["default"]),
            fit_harmonics(parts.shading, shape.normals).root_mean_square,
        )


def true_parts(capture: Capture) -> IntrinsicImages:
    """Return albedo and shading of a photograph by its true shading, the source ``gt-shading``.

    Parameters
    ----------
    capture : Capture

    Returns
    -------
    IntrinsicImages

    Raises
    ------
    RelightlabError
        If the true shading is not known.
    """
    if capture.truth.shading is None:
        raise RelightlabError(f"the true shading of {capture.photograph.name} is not known")
    shading = np.maximum(capture.truth.shading, DARKEST_SHADING)
    return split_by_shading(capture.photograph.image, capture.photograph.mask, shading)


def _flattened(model: ObjectModel) -> ObjectModel:
    inside = model.mask[..., None]
    facing = np.where(inside, [0.0, 0.0, 1.0], np.nan)
    nothing = np.where(model.mask, 0.0, np.nan)
    shape = CoarseShape(nothing, facing)
    return ObjectModel(
        model.mask,
        model.albedo,
        shape.height,
        shape.normals,
        nothing,
        nothing,
        model.illumination,
    )


def _retinex_error(parts: IntrinsicImages, capture: Capture) -> float:
    truth = capture.truth
    if truth.albedo is None or truth.shading is None:
        return float("nan")
    mask = capture.photograph.mask
    return intrinsic_error(parts.albedo, parts.shading, truth.albedo, truth.shading, mask)


def _point_light_residual(model: ObjectModel) -> float:
    return float(np.sqrt(np.nanmean(model.parametric_residual**2)))
