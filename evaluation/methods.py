"""Methods of other people beside ours: one more row of Table 1 for each setting.

A method is measured on the pixels, under the lights and against the targets of Table 1. What it
returns is compared as it is, ``min_k |I - k M|^2 / n`` with k >= 0 for each cell.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from datasets.records import Dataset
from evaluation.experiment import Cell, Experiment, Values
from evaluation.grid_run import Progress, RunOptions, run_grid
from evaluation.grid_status import GridStatus
from evaluation.input_hashes import shared_inputs
from evaluation.rerendering import RerenderingCell, image_cell
from evaluation.row_store import Rows
from evaluation.stored_cells import missing_reason
from evaluation.table1_grid import VERSION
from shading_model.arrays import Float, Image, Mask
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics
from shading_model.object_model import Weights

DETAIL_SOURCE, WEIGHTS = "own", "none"
RESERVED = ("ours", "sirfs")


class Method(Protocol):
    """Whatever relights a photograph: a `Part` of kind ``method``, or a `CommandMethod`."""

    @property
    def name(self) -> str:
        """What tables call it."""
        ...

    @property
    def identity(self) -> str:
        """Changes when its results may."""
        ...

    def relit(
        self, image: Image, mask: Mask, lights: Mapping[str, LogHarmonics]
    ) -> Mapping[str, Float]:
        """Return an image (h, w, 3) for each light, by the light's name."""
        ...


@dataclass(frozen=True, eq=False)
class MethodContext:
    """What the cells of a method are measured with."""

    dataset: Dataset
    lights: tuple[LogHarmonics, ...]
    channels: str
    method: Method


@dataclass(frozen=True, eq=False)
class MethodResult:
    """What was measured of a method.

    Parameters
    ----------
    name : str
    errors, powers : dict of (objects, lights) arrays
        IMSE' and mean of I^2 by setting; NaN where a cell is missing.
    missing : tuple of (cell, reason)
    """

    name: str
    errors: dict[str, Float]
    powers: dict[str, Float]
    missing: tuple[tuple[dict[str, str], str], ...]


def method_experiment(context: MethodContext, seed: str = "") -> Experiment:
    """Return the measuring of one method as an experiment of its own.

    Parameters
    ----------
    context : MethodContext
    seed : str
        Name that the lights were drawn by.

    Returns
    -------
    Experiment
        Its rows stand in the same store as those of Table 1.
    """
    dataset, name = context.dataset, context.method.name
    return Experiment(
        name=f"table-1 method {name}",
        version=VERSION,
        axes={
            "setting": dataset.settings,
            "object": dataset.objects,
            "method": (name,),
            "light": tuple(f"{number:02d}" for number in range(len(context.lights))),
        },
        together=("method", "light"),
        measure=measure_method,
        context=context,
        inputs={
            **shared_inputs(dataset, context.lights, context.channels),
            "method": context.method.identity,
        },
        seed=seed,
    )


def measure_method(context: MethodContext, cells: Sequence[Cell]) -> Iterator[tuple[Cell, Values]]:
    """Measure cells of one object in one setting.

    Parameters
    ----------
    context : MethodContext
    cells : sequence of mappings

    Yields
    ------
    cell, values
        ``gram``, ``cross`` and ``power``: means of M^2, M I and I^2.
    """
    first = cells[0]
    capture = context.dataset.load(first["object"], first["setting"])
    image, mask = capture.photograph.image, capture.photograph.mask
    lights = {cell["light"]: context.lights[int(cell["light"])] for cell in cells}
    relit = context.method.relit(image, mask, lights)
    for cell in cells:
        light = cell["light"]
        found = image_cell(relit[light], mask, capture.truth, lights[light], context.channels)
        yield (
            cell,
            {
                "gram": float(found.gram[0, 0]),
                "cross": float(found.cross[0]),
                "power": found.power,
            },
        )


def run_methods(
    contexts: Sequence[MethodContext],
    store: Rows,
    options: RunOptions,
    *,
    seed: str = "",
    progress: Progress | None = None,
) -> tuple[MethodResult, ...]:
    """Measure methods, one after the other.

    Parameters
    ----------
    contexts : sequence of MethodContext
    store : Rows
    options : RunOptions
        Of `only`, the axes setting, object and light count here.
    seed : str
    progress : callable, optional

    Returns
    -------
    tuple of MethodResult

    Raises
    ------
    RelightlabError
        If two methods have one name, or one has the name of a row of the published table.
    """
    names = [context.method.name for context in contexts]
    for name in names:
        if names.count(name) > 1 or name in RESERVED:
            raise RelightlabError(
                f"the name {name!r} stands in Table 1 already: give the method another `name`"
            )
    results = []
    for context in contexts:
        experiment = method_experiment(context, seed)
        only = {k: v for k, v in (options.only or {}).items() if k in experiment.axes}
        status = run_grid(experiment, store, replace(options, only=only), progress)
        results.append(_result(experiment, status))
    return tuple(results)


def _result(experiment: Experiment, status: GridStatus) -> MethodResult:
    axes = experiment.axes
    cells = {
        setting: [
            [_cell(status, (setting, name, *axes["method"], light)) for light in axes["light"]]
            for name in axes["object"]
        ]
        for setting in axes["setting"]
    }
    coarse = Weights(0.0, 0.0)
    missing = tuple(
        (dict(zip(axes, key, strict=True)), missing_reason(status.rows.get(key)))
        for key in status.missing
    )
    return MethodResult(
        axes["method"][0],
        {s: np.array([[c.error(coarse) for c in row] for row in cells[s]]) for s in cells},
        {s: np.array([[c.power for c in row] for row in cells[s]]) for s in cells},
        missing,
    )


def _cell(status: GridStatus, key: tuple[str, ...]) -> RerenderingCell:
    row = status.rows.get(key)
    values: Mapping[str, float] = row["values"] if row else {}
    gram, cross = np.zeros((3, 3)), np.zeros(3)
    gram[0, 0], cross[0] = values.get("gram", np.nan), values.get("cross", np.nan)
    return RerenderingCell(gram, cross, values.get("power", float("nan")))
