"""Table 1 as a grid: its axes, what is measured in a cell, and the table made of the rows.

A cell is an object in a setting, relit under one light by the model of one detail source. Its
values are the inner products that the error depends on at any weights, so every weight rule is
evaluated on the rows alone. The cells of one object in one setting share its models and are
measured together.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from datasets.records import Dataset
from evaluation.cell_values import cell_of_values, cell_values
from evaluation.experiment import Cell, Experiment, Values
from evaluation.grid_status import GridStatus
from evaluation.input_hashes import parameters_hash, shared_inputs
from evaluation.kept_models import KeptModels
from evaluation.model_parts import PAPER_PARTS, ModelParts
from evaluation.object_measurement import ObjectResult, measure_object
from evaluation.sirfs_fits import SirfsFits, priors_in_use
from evaluation.sirfs_measurement import (
    RIVAL,
    SIRFS_SHADING,
    SIRFS_SOURCES,
    measure_sirfs,
)
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ModelParameters

NAME, VERSION = "table-1", 1
QUICK_SOURCES = ("default", "gt-shading")
DETAIL_SOURCES = ("default", SIRFS_SHADING, "gt-shading")
"""The sources of the rows of our models; those of `QUICK_SOURCES` need no SIRFS."""
BASELINE = "flat"
_OBJECT_VALUES = ("retinex_error", "point_light_residual", "harmonic_residual")


@dataclass(frozen=True, eq=False)
class Table1Context:
    """What the cells of Table 1 are measured with; see `evaluation.table1.run_table1`.

    Without `fits`, the cells that need SIRFS are not part of the grid.
    """

    dataset: Dataset
    lights: tuple[LogHarmonics, ...]
    parameters: ModelParameters
    channels: str
    parts: ModelParts = PAPER_PARTS
    kept: KeptModels | None = None
    fits: SirfsFits | None = None

    def sources(self) -> tuple[str, ...]:
        """Return the detail sources whose cells are measured, the baseline last."""
        if self.fits is None:
            return (*QUICK_SOURCES, BASELINE)
        # B + M has none of our parts, so it stands once, beside the paper's own model.
        rival = (RIVAL,) if self.parts == PAPER_PARTS else ()
        return (*DETAIL_SOURCES, *rival, BASELINE)


def table1_experiment(context: Table1Context, seed: str = "") -> Experiment:
    """Return Table 1 on a dataset as an experiment.

    Parameters
    ----------
    context : Table1Context
    seed : str
        Name that the lights were drawn by.

    Returns
    -------
    Experiment
    """
    dataset, parts = context.dataset, context.parts
    return Experiment(
        name=NAME if parts == PAPER_PARTS else f"{NAME} {parts.method}",
        version=VERSION,
        axes={
            "setting": dataset.settings,
            "object": dataset.objects,
            "detail_source": context.sources(),
            "light": tuple(f"{number:02d}" for number in range(len(context.lights))),
        },
        together=("detail_source", "light"),
        measure=measure_cells,
        context=context,
        inputs={
            **shared_inputs(dataset, context.lights, context.channels),
            "parameters": parameters_hash(context.parameters),
            **({} if parts == PAPER_PARTS else {"parts": parts.identity}),
            # In a quick run too, so that a later one with SIRFS finds its rows.
            "priors": priors_in_use()[1],
        },
        seed=seed,
        cost_axis="detail_source",
    )


def measure_cells(context: Table1Context, cells: Sequence[Cell]) -> Iterator[tuple[Cell, Values]]:
    """Measure cells of one object in one setting.

    Parameters
    ----------
    context : Table1Context
    cells : sequence of mappings

    Yields
    ------
    cell, values
    """
    # What SIRFS cannot do leaves the others their results.
    fitted = [cell for cell in cells if cell["detail_source"] in SIRFS_SOURCES]
    own = [cell for cell in cells if cell["detail_source"] not in SIRFS_SOURCES]
    if own:
        yield from _measure_own(context, own)
    if fitted:
        yield from _measure_fitted(context, fitted)


def _measure_own(context: Table1Context, cells: Sequence[Cell]) -> Iterator[tuple[Cell, Values]]:
    first = cells[0]
    result = measure_object(
        context.dataset,
        first["object"],
        first["setting"],
        context.lights,
        context.parameters,
        context.channels,
        context.parts,
        context.kept,
    )
    shared = {name: getattr(result, name) for name in _OBJECT_VALUES}
    known = {name: value for name, value in shared.items() if np.isfinite(value)}
    for cell in cells:
        measured = result.cells[cell["detail_source"]][int(cell["light"])]
        yield cell, {**cell_values(measured), **known}


def _measure_fitted(context: Table1Context, cells: Sequence[Cell]) -> Iterator[tuple[Cell, Values]]:
    first = cells[0]
    if context.fits is None:
        raise ValueError("cells of SIRFS are no part of a grid without fits")
    found = measure_sirfs(
        context.dataset,
        first["object"],
        first["setting"],
        context.lights,
        context.parameters,
        context.fits,
        context.channels,
        context.parts,
        context.kept,
        sources=[cell["detail_source"] for cell in cells],
    )
    for cell in cells:
        yield cell, cell_values(found[cell["detail_source"]][int(cell["light"])])


def object_results(experiment: Experiment, status: GridStatus) -> tuple[ObjectResult, ...]:
    """Return the results by object that the rows of a store hold; NaN where a cell is missing.

    Parameters
    ----------
    experiment : Experiment
        As `table1_experiment` makes it.
    status : GridStatus

    Returns
    -------
    tuple of ObjectResult
        Settings by objects, in the order of the axes.
    """
    axes = experiment.axes
    return tuple(
        _object_result(axes, status, setting, name)
        for setting in axes["setting"]
        for name in axes["object"]
    )


def _object_result(
    axes: dict[str, tuple[str, ...]], status: GridStatus, setting: str, name: str
) -> ObjectResult:
    def values(source: str, light: str) -> Values:
        row = status.rows.get((setting, name, source, light))
        return row["values"] if row else {}

    cells = {
        source: tuple(cell_of_values(values(source, light)) for light in axes["light"])
        for source in axes["detail_source"]
    }
    found = [values(s, light) for s in axes["detail_source"] for light in axes["light"]]
    shared: Values = next((row for row in found if row), {})
    numbers = {key: shared.get(key, float("nan")) for key in _OBJECT_VALUES}
    return ObjectResult(name, setting, cells, **numbers)
