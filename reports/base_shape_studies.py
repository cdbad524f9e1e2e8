"""The studies of base shapes that stand in a report: on which sets, in which variants, which files.

Leave-one-out is measured without the shapes that take a fit of SIRFS: each of its lights would
need a fit of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from datasets.locations import find_root_of
from datasets.records import Dataset
from evaluation.base_shape_grid import available_variants
from evaluation.base_shapes import HasSensor
from evaluation.experiment import Experiment
from evaluation.grid_run import DEFAULT_OPTIONS, RunOptions
from evaluation.study_variants import TABLE, VARIANTS
from reports.base_shape_run import (
    COLUMNS,
    STUDY_SETS,
    BaseShapeStudy,
    StudyChoice,
    finding_lines,
    measure_base_shapes,
    study_experiment,
    study_lines,
    study_title,
)
from reports.base_shape_views import with_generic_view
from reports.base_shape_words import file_of
from reports.console import print_table, say
from reports.result_files import write_csv, write_json
from shading_model.errors import RelightlabError

REPORT_VARIANTS = (
    TABLE,
    "diffuse",
    "half-height",
    "double-height",
    "linear-light",
    "own-exposure",
    "small-object",
)
"""Those of a report that is not a quick one, where a set has what they need."""
HELD_OUT = "leave-one-out"
SIMULATION_VARIANTS = ("small-object",)
"""Those that change the simulated sensor alone."""
PAPER_SET = "mit-berkeley"


@dataclass(frozen=True, eq=False)
class ReportStudy:
    """What of the study goes into a report, for one dataset.

    Parameters
    ----------
    dataset : Dataset
    channels : {"gray", "color"}
    quick : bool
        The table's own variant alone, and without the shapes that take a fit of SIRFS.
    """

    dataset: Dataset
    channels: str = "gray"
    quick: bool = False

    def choices(self) -> tuple[StudyChoice, ...]:
        """Return what is measured: the table with its variants, then leave-one-out."""
        if self.quick:
            return (StudyChoice(channels=self.channels, quick=True),)
        available = available_variants(self.dataset)
        simulated = not isinstance(self.dataset, HasSensor)
        variants = tuple(
            name
            for name in REPORT_VARIANTS
            if name in available and (simulated or name not in SIMULATION_VARIANTS)
        )
        return (
            StudyChoice(variants=variants, channels=self.channels),
            StudyChoice(variants=(HELD_OUT,), channels=self.channels, quick=True),
        )

    def experiments(self, store: Path | None = None) -> tuple[Experiment, ...]:
        """Return the grids of cells that are measured.

        Parameters
        ----------
        store : Path, optional
            Keeps the fits of SIRFS.

        Raises
        ------
        RelightlabError
            If the set cannot be studied.
        """
        return tuple(study_experiment(self.dataset, choice, store) for choice in self.choices())


def report_studies(
    dataset: Dataset,
    data: Path | None = None,
    named: str | None = None,
    *,
    channels: str = "gray",
    quick: bool = False,
) -> tuple[ReportStudy, ...]:
    """Return the studies of a report: on its own dataset, and on the other sets that are found.

    Those that cannot be studied, as they have no photographs under known lights, are told in a
    sentence and left out.

    Parameters
    ----------
    dataset : Dataset
        That of Table 1.
    data : Path, optional
        A data root.
    named : str, optional
        The dataset that was asked for; sets other than it are looked for if it is none, or the
        paper's.
    channels : {"gray", "color"}
    quick : bool

    Returns
    -------
    tuple of ReportStudy
    """
    beside = _found_beside(data) if named in {None, PAPER_SET} else ()
    studies = (ReportStudy(one, channels, quick) for one in (dataset, *beside))
    return tuple(study for study in studies if _can_be_measured(study))


def measure_report_study(
    study: ReportStudy, *, store: Path | None = None, options: RunOptions = DEFAULT_OPTIONS
) -> BaseShapeStudy:
    """Measure a study with its variants and the generic-view check.

    Parameters
    ----------
    study : ReportStudy
    store : Path, optional
    options : RunOptions

    Returns
    -------
    BaseShapeStudy
        Its ``sensitivity``, ``missing`` and counts of cells are over all that was measured.

    Raises
    ------
    RelightlabError
        As `reports.base_shape_run.measure_base_shapes`.
    """
    table, *others = (
        measure_base_shapes(study.dataset, choice, store=store, options=options)
        for choice in study.choices()
    )
    for other in others:
        table = joined(table, other)
    return with_generic_view(table)


def joined(table: BaseShapeStudy, other: BaseShapeStudy) -> BaseShapeStudy:
    """Return a study with the variants of another one on the same dataset.

    Parameters
    ----------
    table, other : BaseShapeStudy

    Returns
    -------
    BaseShapeStudy
        Table, tests and objects are those of the first.
    """
    first, second = table.document, other.document
    order = list(VARIANTS)
    counts = ("cells_done", "cells_missing", "seconds")
    origin, added = first["provenance"], second["provenance"]
    parts = {
        "sensitivity": sorted(
            [*first["sensitivity"], *second["sensitivity"]],
            key=lambda row: order.index(row["variant"]),
        ),
        "missing": [*first["missing"], *second["missing"]],
        "provenance": origin | {key: round(origin[key] + added[key], 1) for key in counts},
    }
    return replace(table, document=first | parts)


def print_study(study: BaseShapeStudy) -> None:
    """Print Table 2 of a study, and what its tests say.

    Parameters
    ----------
    study : BaseShapeStudy
    """
    print_table(study_title(study.document), COLUMNS, study_lines(study.document))
    say(*finding_lines(study.document))


def study_paths(folder: Path, studies: Iterable[ReportStudy]) -> tuple[Path, ...]:
    """Return the files that `write_study` will write for studies.

    Parameters
    ----------
    folder : Path
    studies : iterable of ReportStudy

    Returns
    -------
    tuple of Path
    """
    return tuple(path for study in studies for path in _paths(folder, study.dataset.name))


def write_study(folder: Path, study: BaseShapeStudy) -> tuple[Path, ...]:
    """Write a study's document as JSON and its table as CSV.

    Parameters
    ----------
    folder : Path
    study : BaseShapeStudy

    Returns
    -------
    tuple of Path

    Raises
    ------
    RelightlabError
        If a file cannot be written.
    """
    document, table = _paths(folder, study.context.dataset.name)
    write_json(document, study.document)
    write_csv(table, study.document["rows"])
    return document, table


def _paths(folder: Path, dataset: str) -> tuple[Path, Path]:
    document = folder / file_of({"provenance": {"dataset": dataset}})
    return document, document.with_suffix(".csv")


def _found_beside(data: Path | None) -> Iterator[Dataset]:
    for name, build in STUDY_SETS.items():
        root = find_root_of(name, data)
        if root is not None:
            yield build(root / name)


def _can_be_measured(study: ReportStudy) -> bool:
    try:
        study_experiment(study.dataset, study.choices()[0])
    except RelightlabError as error:
        say(f"Table 2 is left out on {study.dataset.name}: {error}")
        return False
    return True
