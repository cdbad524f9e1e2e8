"""Running Table 1 from the command line: which data, which lights, and the document of results."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from datasets.illumination_pools import TABLE1_SEED, pool_name, table1_lights
from datasets.locations import find_data_root, find_root_of, missing_data_sentence
from datasets.mit_berkeley import MitBerkeley
from datasets.model_parameters import shipped_parameters
from datasets.own_folder import OwnFolder
from datasets.own_folder_check import require_measurable
from datasets.records import Dataset
from datasets.synthetic import DEFAULT_SIZE, Synthetic, synthetic_root
from datasets.synthetic_manifest import MANIFEST
from evaluation.blob_store import BLOBS
from evaluation.experiment import Experiment
from evaluation.grid_run import DEFAULT_OPTIONS, RunOptions
from evaluation.grid_status import grid_summary
from evaluation.kept_models import KeptModels
from evaluation.own_rows import NOTHING, OwnChoices, OwnRows, run_own_rows
from evaluation.provenance import provenance_of
from evaluation.registry import EXPERIMENTS
from evaluation.rerendering import CHANNELS
from evaluation.row_store import ROWS, RowStore
from evaluation.sirfs_fits import SirfsFits
from evaluation.table1 import PROTOCOL, PROTOCOL_VERSION, run_table1
from evaluation.table1_grid import BASELINE
from evaluation.table1_record import Table1
from evaluation.table1_results import table1_document
from evaluation.weight_rules import MANUAL
from reports.console import progress, say
from shading_model.errors import RelightlabError, unknown_name
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ModelParameters, Weights

DATASETS = ("mit-berkeley", "synthetic")


@dataclass(frozen=True, eq=False)
class Table1Source:
    """What Table 1 is measured on.

    Parameters
    ----------
    dataset : Dataset
    lights : tuple of LogHarmonics
    pool : str
        In words, what the lights were drawn from.
    notice : str
        One sentence to be shown: where the data were found, or that they were not.
    """

    dataset: Dataset
    lights: tuple[LogHarmonics, ...]
    pool: str
    notice: str


@dataclass(frozen=True, eq=False)
class Table1Run:
    """Table 1 as measured, with all that a page needs to draw examples.

    Parameters
    ----------
    document : dict
        Of `evaluation.table1_results.table1_document`.
    dataset : Dataset
    lights : tuple of LogHarmonics
    parameters : ModelParameters
    fits : SirfsFits, optional
        Where the fits of SIRFS are kept, if one is to be drawn.
    """

    document: dict[str, Any]
    dataset: Dataset
    lights: tuple[LogHarmonics, ...]
    parameters: ModelParameters
    fits: SirfsFits | None = None


def open_source(
    data: Path | None = None,
    dataset: str | None = None,
    *,
    size: int = DEFAULT_SIZE,
    workers: int = 2,
) -> Table1Source:
    """Find the data of Table 1, or make the synthetic set where there are none.

    Parameters
    ----------
    data : Path, optional
        A data root, or the folder of a synthetic set.
    dataset : str, optional
        One of `DATASETS`, or the folder of a set of one's own; by default MIT-Berkeley if it is
        found, else the synthetic set.
    size, workers : int
        Of the synthetic set, where it has to be made.

    Returns
    -------
    Table1Source

    Raises
    ------
    RelightlabError
        If the dataset is unknown, or was asked for and is not found.
    """
    if dataset is not None and dataset not in DATASETS:
        if not Path(dataset).is_dir():
            raise unknown_name(
                "dataset", dataset, (*DATASETS, "or the folder of a set of your own")
            )
        return _own_source(Path(dataset), data)
    if data is not None and dataset != "mit-berkeley" and (data / MANIFEST).is_file():
        made = Synthetic(data)
        pool = pool_name(None)
        return Table1Source(made, table1_lights(None), pool, f"synthetic set found in {data}")
    find_data_root(data)  # tells if the root that was named is none
    lights_root = find_root_of("boundary-cues", data)
    lights, pool = table1_lights(lights_root), pool_name(lights_root)
    root = find_root_of("mit-berkeley", data)
    if dataset != "synthetic" and root is not None:
        found = MitBerkeley(root / "mit-berkeley")
        return Table1Source(found, lights, pool, f"MIT-Berkeley found in {found.root}")
    missing = missing_data_sentence("mit-berkeley", data)
    if dataset == "mit-berkeley":
        raise RelightlabError(missing)
    folder = _synthetic_folder(size, workers)
    notice = f"synthetic set in {folder}"
    return Table1Source(
        Synthetic(folder), lights, pool, notice if dataset else f"{missing}; now the {notice}"
    )


def measure_table1(
    source: Table1Source,
    *,
    objects: Sequence[str] = (),
    channels: str = "gray",
    manual: Weights = MANUAL,
    own: OwnChoices = NOTHING,
    store: Path | None = None,
    keep_models: bool = False,
    quick: bool = False,
    options: RunOptions = DEFAULT_OPTIONS,
) -> Table1Run:
    """Measure Table 1 and say where its numbers come from.

    Parameters
    ----------
    source : Table1Source
    objects : sequence of str
        Those to report; all by default.
    channels : {"gray", "color"}
    manual : Weights
    own : OwnChoices
        Methods and parts that stand beside ours.
    store : Path, optional
        Folder that keeps the rows; what it holds is not measured again.
    keep_models : bool
        Whether the store keeps the object models too; fits of SIRFS it always keeps.
    quick : bool
        Leave out the entries that need SIRFS.
    options : RunOptions
        The numbers do not depend on them.

    Returns
    -------
    Table1Run

    Raises
    ------
    RelightlabError
        For unknown names, fewer than one worker, or data or a store that cannot be used.
    """
    if channels not in CHANNELS:
        raise unknown_name("channels", channels, CHANNELS)
    parameters = shipped_parameters()
    rows = None if store is None else RowStore(store / ROWS)
    if rows is not None:
        experiment = source_experiment(source, channels, quick=quick)
        say(grid_summary(experiment, rows).sentence())
    started = time.monotonic()
    with progress("measuring cells") as report:
        table = run_table1(
            source.dataset,
            source.lights,
            parameters,
            objects=objects,
            channels=channels,
            manual=manual,
            seed=TABLE1_SEED,
            rules=own.weight_rules(),
            store=rows,
            kept=_kept_models(store, keep_models),
            quick=quick,
            fits=SirfsFits.in_store(store),
            options=options,
            progress=report,
        )
        brought = run_own_rows(
            own,
            source.dataset,
            source.lights,
            parameters,
            objects=objects,
            channels=channels,
            manual=manual,
            seed=TABLE1_SEED,
            store=rows,
            quick=quick,
            fits=SirfsFits.in_store(store),
            options=options,
            progress=report,
        )
    document = _document(table, brought, source, time.monotonic() - started, options.workers)
    return Table1Run(document, source.dataset, source.lights, parameters)


def _kept_models(store: Path | None, keep: bool) -> KeptModels | None:
    if not keep:
        return None
    if store is None:
        raise RelightlabError("--keep-models keeps them in a store: give its folder with --store")
    return KeptModels(store / BLOBS)


def source_experiment(
    source: Table1Source, channels: str = "gray", *, quick: bool = False
) -> Experiment:
    """Return the grid of cells that `measure_table1` measures.

    Parameters
    ----------
    source : Table1Source
    channels : {"gray", "color"}
    quick : bool
        Without the cells that need SIRFS.

    Returns
    -------
    Experiment

    Raises
    ------
    RelightlabError
        For unknown channels.
    """
    if channels not in CHANNELS:
        raise unknown_name("channels", channels, CHANNELS)
    build = EXPERIMENTS[PROTOCOL]
    parameters = shipped_parameters()
    return build(
        *(source.dataset, source.lights, parameters),
        channels=channels,
        seed=TABLE1_SEED,
        quick=quick,
    )


def _document(
    table: Table1, own: OwnRows, source: Table1Source, seconds: float, workers: int
) -> dict[str, Any]:
    """Return the document; a cell is an object under a light, for a detail source and setting."""
    tables = [one for one in (table, own.table) if one]
    sources = sum(len([name for name in one.sources() if name != BASELINE]) for one in tables)
    measured = (sources + len(own.methods)) * len(source.lights) * len(table.settings())
    expected = len(table.objects) * measured
    missing = len(table.missing_entries()) + len(own.missing_entries())
    provenance = provenance_of(
        protocol=f"{PROTOCOL} {PROTOCOL_VERSION}",
        dataset=source.dataset.name,
        data_hash=source.dataset.fingerprint(),
        seeds={"lights": f"{TABLE1_SEED}, drawn from {source.pool}"},
        seconds=seconds,
        workers=workers,
        cells_done=expected - missing,
        cells_missing=missing,
    )
    return table1_document(table, provenance, own)


def _own_source(folder: Path, data: Path | None) -> Table1Source:
    own = OwnFolder(folder)
    require_measurable(own)
    find_data_root(data)  # tells if the root that was named is none
    pool = find_root_of("boundary-cues", data)
    notice = f"{len(own.objects)} objects of your own in {folder}"
    return Table1Source(own, table1_lights(pool), pool_name(pool), notice)


def _synthetic_folder(size: int, workers: int) -> Path:
    with progress("making the synthetic set") as report:
        return synthetic_root(size=size, workers=workers, progress=report)
