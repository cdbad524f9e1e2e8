"""SIRFS as a grid: every object, setting and number of channels is fitted and measured.

A cell's values are the six errors of `evaluation.sirfs.metrics`, as far as the truth is known, and
the loss and evaluations of the fit. Each cell is a task of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from typing import Any

import numpy as np

from datasets.records import Dataset
from evaluation.code_version import code_hash
from evaluation.experiment import Cell, Experiment, Values
from evaluation.grid_run import DEFAULT_OPTIONS, Progress, RunOptions, run_grid
from evaluation.grid_status import GridStatus
from evaluation.object_sets import object_sets
from evaluation.row_store import MemoryRows, Rows
from evaluation.sirfs.metrics import (
    ERROR_NAMES,
    SirfsErrors,
    geometric_mean_errors,
    sirfs_errors,
)
from evaluation.sirfs.settings import CHANNELS, term_weights
from evaluation.sirfs_fits import SirfsFits, priors_in_use
from evaluation.stored_cells import missing_reason
from shading_model.errors import unknown_name

NAME, VERSION = "sirfs", 1
_FIT_VALUES = ("final_loss", "evaluations")
Row = dict[str, Any]


@dataclass(frozen=True, eq=False)
class SirfsContext:
    """What cells are measured with.

    Parameters
    ----------
    dataset : Dataset
    fits : SirfsFits
    """

    dataset: Dataset
    fits: SirfsFits


@dataclass(frozen=True, eq=False)
class SirfsTable:
    """The errors of SIRFS on a dataset.

    Parameters
    ----------
    dataset : str
    rows : tuple of dict
        One for each fit: ``object, setting, channels``, the six errors, their geometric ``mean``,
        ``final_loss, evaluations, seconds``. An error is None where the truth is not known. Seconds
        are those of the cell: loading, fitting and measuring, or reading a fit that is kept.
    summary : tuple of dict
        The same keys for sets of objects (see `evaluation.object_sets`): ``object`` is the set's
        name and ``objects`` how many of it were measured. Errors are geometric means; loss,
        evaluations and seconds arithmetic ones.
    missing : tuple of dict of str
        The cells that failed or were not measured, with the ``reason``.
    """

    dataset: str
    rows: tuple[Row, ...]
    summary: tuple[Row, ...]
    missing: tuple[dict[str, str], ...]


def sirfs_experiment(
    context: SirfsContext,
    objects: Sequence[str] = (),
    settings: Sequence[str] = (),
    channels: Sequence[str] = CHANNELS,
    seed: str = "",
) -> Experiment:
    """Return the measuring of SIRFS as an experiment.

    Parameters
    ----------
    context : SirfsContext
    objects, settings : sequence of str
        All of the dataset by default.
    channels : sequence of str
        Of ``gray`` and ``color``.
    seed : str
        Plays no part: nothing is drawn.

    Returns
    -------
    Experiment

    Raises
    ------
    RelightlabError
        For unknown objects, settings, channels, or terms to leave out.
    """
    dataset, without = context.dataset, context.fits.without
    axes = {
        "setting": _chosen("setting", settings, dataset.settings),
        "object": _chosen("object", objects, dataset.objects),
        "channels": _chosen("channels", channels, CHANNELS),
    }
    term_weights("laboratory", "color", without)  # tells of unknown terms
    return Experiment(
        name=" ".join([NAME, *(f"without {term}" for term in sorted(without))]),
        version=VERSION,
        axes=axes,
        together=(),
        measure=measure_fits,
        context=context,
        inputs={
            "dataset": dataset.name,
            "data": dataset.fingerprint(),
            "priors": priors_in_use()[1],
            "code": code_hash(),
        },
        seed=seed,
    )


def measure_fits(context: SirfsContext, cells: Sequence[Cell]) -> Iterator[tuple[Cell, Values]]:
    """Fit and measure cells.

    Parameters
    ----------
    context : SirfsContext
    cells : sequence of mappings

    Yields
    ------
    cell, values
    """
    for cell in cells:
        name, setting = cell["object"], cell["setting"]
        fit = context.fits.fit(context.dataset, name, setting, cell["channels"])
        errors = sirfs_errors(fit, context.dataset.load(name, setting).truth)
        known = {key: value for key, value in _errors(errors).items() if np.isfinite(value)}
        yield cell, {**known, **{key: getattr(fit, key) for key in _FIT_VALUES}}


def run_sirfs(
    context: SirfsContext,
    objects: Sequence[str] = (),
    settings: Sequence[str] = (),
    channels: Sequence[str] = CHANNELS,
    *,
    store: Rows | None = None,
    options: RunOptions = DEFAULT_OPTIONS,
    progress: Progress | None = None,
) -> SirfsTable:
    """Fit SIRFS to the chosen photographs of a dataset and return its errors.

    Parameters
    ----------
    context : SirfsContext
    objects, settings, channels : sequence of str
        As for `sirfs_experiment`.
    store : Rows, optional
        Cells that it holds are not measured again.
    options : RunOptions
        The numbers do not depend on them.
    progress : callable, optional

    Returns
    -------
    SirfsTable

    Raises
    ------
    RelightlabError
        As `sirfs_experiment` and `evaluation.grid_run.run_grid`; a fit that fails is a missing
        row.
    """
    experiment = sirfs_experiment(context, objects, settings, channels)
    status = run_grid(experiment, store or MemoryRows(), options, progress)
    return sirfs_table(experiment, status)


def sirfs_table(experiment: Experiment, status: GridStatus) -> SirfsTable:
    """Return the table that the rows of a store hold.

    Parameters
    ----------
    experiment : Experiment
        As `sirfs_experiment` makes it.
    status : GridStatus

    Returns
    -------
    SirfsTable
    """
    absent = set(status.missing)
    done = [key for key in map(experiment.key, experiment.cells()) if key not in absent]
    rows = tuple(_row(status.rows[key]) for key in done)
    missing = tuple(
        {
            **dict(zip(experiment.axes, key, strict=True)),
            "reason": missing_reason(status.rows.get(key)),
        }
        for key in status.missing
    )
    dataset: Dataset = experiment.context.dataset
    return SirfsTable(dataset.name, rows, tuple(_summary(dataset, experiment, rows)), missing)


def _chosen(kind: str, wanted: Sequence[str], available: Sequence[str]) -> tuple[str, ...]:
    for name in wanted:
        if name not in available:
            raise unknown_name(kind, name, available)
    return tuple(name for name in available if not wanted or name in wanted)


def _errors(errors: SirfsErrors) -> dict[str, float]:
    return {**dict(zip(ERROR_NAMES, astuple(errors), strict=True)), "mean": errors.mean}


def _row(measured: Row) -> Row:
    cell, values = measured["cell"], measured["values"]
    return {
        **{axis: cell[axis] for axis in ("object", "setting", "channels")},
        **{name: values.get(name) for name in (*ERROR_NAMES, "mean", *_FIT_VALUES)},
        "seconds": measured["seconds"],
    }


def _summary(dataset: Dataset, experiment: Experiment, rows: Sequence[Row]) -> Iterator[Row]:
    for setting in experiment.axes["setting"]:
        for channels in experiment.axes["channels"]:
            for name, members in object_sets(dataset.name, dataset.objects).items():
                place = {"object": name, "setting": setting, "channels": channels}
                chosen = [
                    row
                    for row in rows
                    if (row["setting"], row["channels"]) == (setting, channels)
                    and row["object"] in members
                ]
                if chosen:
                    yield {**place, **_means(chosen), "objects": len(chosen)}


def _means(rows: Sequence[Row]) -> Row:
    """Return the means of rows; an error that one object lacks has none."""
    names = (*ERROR_NAMES, "mean")
    table = np.array([[row[name] for name in names] for row in rows], dtype=np.float64)
    errors = geometric_mean_errors([SirfsErrors(*line[:-1].tolist()) for line in table])
    found = {
        **_errors(errors),
        **{name: float(np.mean([row[name] for row in rows])) for name in (*_FIT_VALUES, "seconds")},
    }
    return {name: value if np.isfinite(value) else None for name, value in found.items()}
