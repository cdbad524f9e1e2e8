"""Running the study of base shapes (Table 2) from the command line: data, document, lines."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from datasets.locations import find_data_root, find_root_of, missing_data_sentence
from datasets.model_parameters import shipped_parameters
from datasets.psm_uw import PsmUw
from datasets.records import Dataset
from datasets.rgbd_mitten import RgbdMitten
from evaluation.base_shape_grid import (
    NAME,
    VERSION,
    available_shapes,
    base_shape_experiment,
)
from evaluation.base_shape_models import BaseShapeContext
from evaluation.base_shape_table import BaseShapeTable, base_shape_table
from evaluation.base_shapes import FITTED_SHAPES
from evaluation.experiment import Experiment
from evaluation.grid_run import DEFAULT_OPTIONS, RunOptions, run_grid
from evaluation.grid_status import grid_summary
from evaluation.known_values import rows_without_nan
from evaluation.provenance import provenance_of
from evaluation.published_table2 import PUBLISHED
from evaluation.rerendering import CHANNELS
from evaluation.row_store import ROWS, MemoryRows, RowStore
from evaluation.sirfs_fits import SirfsFits
from evaluation.study_variants import TABLE, VARIANTS
from reports.console import progress, say
from reports.table1_run import open_source
from shading_model.errors import RelightlabError, unknown_name

STUDY_SETS: dict[str, Callable[[Path], Dataset]] = {"psm-uw": PsmUw, "rgbd-mitten": RgbdMitten}
"""Sets of photographs under known lights that Table 1 cannot be measured on."""
COLUMNS = ("shape", "weights", "IMSE", "95 %", "relative", "to contour", "95 %", "published")


@dataclass(frozen=True)
class StudyChoice:
    """What of the study is measured.

    Parameters
    ----------
    objects : tuple of str
        All by default.
    variants : tuple of str
        Of `evaluation.study_variants.VARIANTS`.
    shapes : tuple of str
        All that the set allows by default.
    channels : {"gray", "color"}
    quick : bool
        Without the shapes that take a fit of SIRFS.
    """

    objects: tuple[str, ...] = ()
    variants: tuple[str, ...] = (TABLE,)
    shapes: tuple[str, ...] = ()
    channels: str = "gray"
    quick: bool = False

    def shapes_of(self, dataset: Dataset) -> tuple[str, ...]:
        """Return the base shapes measured on a dataset.

        Parameters
        ----------
        dataset : Dataset
        """
        wanted = self.shapes or available_shapes(dataset)
        return tuple(s for s in wanted if not (self.quick and s in FITTED_SHAPES))


@dataclass(frozen=True, eq=False)
class BaseShapeStudy:
    """The study as measured on one dataset, with all that its figures need.

    Parameters
    ----------
    document : dict
        See `measure_base_shapes`.
    context : BaseShapeContext
        The dataset, parameters and fits that it was measured with.
    """

    document: dict[str, Any]
    context: BaseShapeContext


def open_study_set(
    data: Path | None = None, dataset: str | None = None, *, size: int = 300, workers: int = 2
) -> tuple[Dataset, str]:
    """Find a set of photographs under known lights, or make the synthetic one.

    Parameters
    ----------
    data : Path, optional
        A data root.
    dataset : str, optional
        ``psm-uw``, ``rgbd-mitten``, or as for `reports.table1_run.open_source`.
    size, workers : int
        Of the synthetic set, where it has to be made.

    Returns
    -------
    Dataset, str
        The set, and a sentence that says where it was found.

    Raises
    ------
    RelightlabError
        If it is unknown, or was asked for and is not found.
    """
    if dataset is None or dataset not in STUDY_SETS:
        source = open_source(data, dataset, size=size, workers=workers)
        return source.dataset, source.notice
    find_data_root(data)  # tells if the root that was named is none
    root = find_root_of(dataset, data)
    if root is None:
        raise RelightlabError(missing_data_sentence(dataset, data))
    folder = root / dataset
    return STUDY_SETS[dataset](folder), f"{dataset} found in {folder}"


def study_experiment(
    dataset: Dataset, choice: StudyChoice, store: Path | None = None
) -> Experiment:
    """Return the grid of cells that `measure_base_shapes` measures.

    Parameters
    ----------
    dataset : Dataset
    choice : StudyChoice
    store : Path, optional
        Keeps the fits of SIRFS.

    Returns
    -------
    Experiment

    Raises
    ------
    RelightlabError
        For unknown names, a dataset without photographs under known lights, or a quick choice of
        nothing but shapes that take a fit.
    """
    if choice.channels not in CHANNELS:
        raise unknown_name("channels", choice.channels, CHANNELS)
    fits = SirfsFits.in_store(store)
    context = BaseShapeContext(dataset, shipped_parameters(), choice.channels, fits)
    shapes = choice.shapes_of(dataset)
    if not shapes:
        raise RelightlabError(
            f"a quick study leaves out {' and '.join(FITTED_SHAPES)}, and no other base shape was"
            " asked for: drop --quick, or name another one"
        )
    return base_shape_experiment(context, choice.variants, shapes, choice.objects)


def measure_base_shapes(
    dataset: Dataset,
    choice: StudyChoice = StudyChoice(),
    *,
    store: Path | None = None,
    options: RunOptions = DEFAULT_OPTIONS,
) -> BaseShapeStudy:
    """Measure the study on a dataset and say where its numbers come from.

    Parameters
    ----------
    dataset : Dataset
    choice : StudyChoice
    store : Path, optional
        Folder that keeps rows and fits; what it holds is not measured again.
    options : RunOptions
        The numbers do not depend on them.

    Returns
    -------
    BaseShapeStudy
        Its document has ``rows``, ``tests``, ``pairs`` and ``objects`` (see
        `evaluation.base_shape_table.BaseShapeTable`) of the first variant measured,
        ``sensitivity`` over all, ``published``, ``quick``, ``missing``, ``protocol`` and
        ``provenance``. NaN becomes None.

    Raises
    ------
    RelightlabError
        As `study_experiment`, or if the store cannot be used.
    """
    experiment = study_experiment(dataset, choice, store)
    rows = None if store is None else RowStore(store / ROWS)
    if rows is not None:
        say(grid_summary(experiment, rows).sentence())
    started = time.monotonic()
    with progress(f"relighting {dataset.name}") as report:
        status = run_grid(experiment, rows or MemoryRows(), options, report)
    table = base_shape_table(experiment, status)
    seconds = time.monotonic() - started
    document = _document(table, experiment, choice, seconds, options.workers)
    return BaseShapeStudy(document, experiment.context)


def study_lines(document: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the lines of the printed table, rules apart.

    Parameters
    ----------
    document : mapping
        Of a `BaseShapeStudy`.

    Returns
    -------
    list of tuples of str
        In the order of `COLUMNS`; an empty tuple between weight rules.
    """
    published = {(row["shape"], row["weights"]): row["imse"] for row in document["published"]}
    lines: list[tuple[str, ...]] = []
    for row in document["rows"]:
        if lines and lines[-1][1] != row["weights"]:
            lines.append(())
        lines.append(_line(row, published.get((row["shape"], row["weights"]))))
    return lines


def study_title(document: Mapping[str, Any]) -> str:
    """Return the title of the printed table, which says if cells are missing or left out.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    str

    Examples
    --------
    >>> study_title({"missing": [], "quick": True, "protocol": {"words": "mean"},
    ...              "provenance": {"dataset": "synthetic"}})
    'QUICK, without SIRFS. Table 2: error by base shape on synthetic (models from the mean)'
    """
    missing = len(document["missing"])
    stamps = (
        [f"INCOMPLETE, {missing} cell{'s' if missing > 1 else ''} missing. "] if missing else []
    )
    stamps += ["QUICK, without SIRFS. "] if document["quick"] else []
    return (
        f"{''.join(stamps)}Table 2: error by base shape on"
        f" {document['provenance']['dataset']} (models from the {document['protocol']['words']})"
    )


def finding_lines(document: Mapping[str, Any]) -> list[str]:
    """Return what the tests say, a sentence for each weight rule that they apply to.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    list of str
    """
    lines = []
    for test in document["tests"]:
        clear = [
            f"{_better(pair)} (p {pair['p_holm']:.2g})"
            for pair in document["pairs"]
            if pair["weights"] == test["weights"] and pair["p_holm"] < 0.05
        ]
        found = "; ".join(clear) or "no pair differs after Holm's correction"
        lines.append(
            f"{test['weights']}: Friedman p {test['p']:.2g} over {test['objects']} objects; {found}"
        )
    return lines


def _line(row: Mapping[str, Any], published: float | None) -> tuple[str, ...]:
    low, high = (_number(row[f"difference_{end}"], signed=True) for end in ("low", "high"))
    return (
        *(row["shape"], row["weights"], _number(row["imse"])),
        f"{_number(row['low'])} to {_number(row['high'])}",
        _number(row["relative_imse"], 3),
        _number(row["difference"], signed=True),
        f"{low} to {high}",
        "-" if published is None else f"{published:.4f}",
    )


def _better(pair: Mapping[str, Any]) -> str:
    first, second = pair["first"], pair["second"]
    ahead = pair["median_difference"] < 0
    return f"{first} below {second}" if ahead else f"{second} below {first}"


def _document(
    table: BaseShapeTable,
    experiment: Experiment,
    choice: StudyChoice,
    seconds: float,
    workers: int,
) -> dict[str, Any]:
    dataset: Dataset = experiment.context.dataset
    variant = table.variants[0]
    missing: Sequence[Mapping[str, str]] = table.missing
    provenance = provenance_of(
        protocol=f"{NAME} {VERSION}",
        dataset=dataset.name,
        data_hash=dataset.fingerprint(),
        seeds={"sensor": "time of flight, dataset, object; bootstrap: base shapes, dataset"},
        seconds=seconds,
        workers=workers,
        cells_done=experiment.size - len(missing),
        cells_missing=len(missing),
    )
    return {
        "protocol": {
            "name": NAME,
            "version": VERSION,
            "variant": variant,
            "words": VARIANTS[variant].words,
            "channels": choice.channels,
            "lights": len(experiment.axes["light"]),
        },
        "rows": rows_without_nan(table.rows(variant)),
        "objects": rows_without_nan(table.object_rows(variant)),
        "tests": table.tests(variant),
        "pairs": rows_without_nan(table.pairs(variant)),
        "sensitivity": [
            {**row, "imse": rows_without_nan([row["imse"]])[0]} for row in table.sensitivity()
        ],
        "published": [dict(row) for row in PUBLISHED],
        "quick": choice.quick,
        "missing": [dict(one) for one in missing],
        "provenance": provenance.document(),
    }


def _number(value: float | None, digits: int = 5, *, signed: bool = False) -> str:
    if value is None:
        return "-"
    return f"{value:+.{digits}f}" if signed else f"{value:.{digits}f}"
