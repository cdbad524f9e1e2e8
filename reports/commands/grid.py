"""The commands for stores of measured cells: ``relightlab grid ...``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.commands.options import Channels, DataRoot, Dataset, Force, JsonFile, Only, Quick, Size

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from evaluation.experiment import Experiment
    from reports.table1_run import Table1Source

DEFAULT_STORE = Path("out") / "store"
GridStore = Annotated[Path, typer.Option("--store", metavar="DIR", help="Folder of the rows.")]

app = typer.Typer(help="Look after the store of measured cells.")


@app.command("status")
def status_command(
    store: GridStore = DEFAULT_STORE,
    dataset: Dataset = None,
    data: DataRoot = None,
    size: Size = 300,
    channels: Channels = "gray",
    quick: Quick = False,
    json: JsonFile = None,
) -> None:
    """Say how many cells are done and to run, which failed and why, and what is damaged."""
    from evaluation.blob_store import BLOBS, blob_fault, blob_files
    from evaluation.grid_status import grid_summary
    from evaluation.row_store import ROWS, RowStore
    from reports.console import say
    from reports.result_files import write_json
    from reports.table1_run import open_source, source_experiment

    source = open_source(data, dataset, size=size)
    say(source.notice)
    experiment = source_experiment(source, channels, quick=quick)
    summary = grid_summary(experiment, RowStore(store / ROWS))
    faults = {path: blob_fault(path) for path in blob_files(store / BLOBS)}
    broken = {f"{path.parent.name}/{path.name}": why for path, why in faults.items() if why}
    say(f"{summary.protocol} in {store}: {summary.sentence()}")
    say(*(f"  failed: {count} x {why}" for why, count in summary.reasons.items()))
    say(*(f"  blob {name}: {why}; it is made again" for name, why in broken.items()))
    if json is not None:
        blobs = {"blobs": len(faults), "damaged_blobs": broken}
        write_json(json, {"store": str(store), **summary.document(), **blobs})


@app.command("plan")
def plan_command(
    store: GridStore = DEFAULT_STORE,
    dataset: Dataset = None,
    data: DataRoot = None,
    size: Size = 300,
    channels: Channels = "gray",
    only: Only = None,
    force: Force = False,
    quick: Quick = False,
    json: JsonFile = None,
) -> None:
    """Say what a run would measure and cost, from the cells measured so far; run nothing."""
    from evaluation.experiment import parse_only
    from reports.console import say
    from reports.table1_run import open_source

    source = open_source(data, dataset, size=size)
    say(source.notice)
    wanted = parse_only(only or [])
    say_plan(source, channels, store, only=wanted, force=force, quick=quick, json=json)


@app.command("archive")
def archive_command(
    store: Annotated[Path, typer.Argument(metavar="STORE", help="Folder of the rows.")],
    out: Annotated[Path, typer.Option(help="Archive to write, .zip.")],
    json: JsonFile = None,
) -> None:
    """Pack a store's rows and blobs into one file with the SHA-256 of each."""
    from evaluation.store_archive import archive_store
    from reports.console import say
    from reports.result_files import write_json

    summary = archive_store(store, out)
    say(f"written: {out} ({summary.sentence()})")
    say(*(f"  left out: {fault}" for fault in summary.left_out))
    if json is not None:
        write_json(json, summary.document())


@app.command("verify")
def verify_command(
    archive: Annotated[Path, typer.Argument(metavar="FILE", help="Made by 'grid archive'.")],
    json: JsonFile = None,
) -> None:
    """Check every member of an archive against its SHA-256, on any machine."""
    from evaluation.store_archive import verify_archive
    from reports.console import say
    from reports.result_files import write_json

    summary = verify_archive(archive)
    say(f"{archive} is whole: {summary.sentence()}")
    if json is not None:
        write_json(json, summary.document())


@app.command("merge")
def merge_command(
    target: Annotated[Path, typer.Argument(metavar="TARGET", help="Folder of the rows.")],
    sources: Annotated[
        list[Path], typer.Argument(metavar="SOURCE...", help="Stores, or archives of them.")
    ],
    json: JsonFile = None,
) -> None:
    """Add to a store the rows and blobs that it lacks of others."""
    from evaluation.store_merge import merge_stores
    from reports.console import say
    from reports.result_files import write_json

    summary = merge_stores(target, sources)
    say(f"{target}: {summary.sentence()}")
    if json is not None:
        write_json(json, summary.document())


def say_plan(
    source: Table1Source,
    channels: str,
    store: Path | None,
    *,
    only: Mapping[str, Sequence[str]] | None = None,
    force: bool = False,
    quick: bool = False,
    json: Path | None = None,
) -> None:
    """Print what a run of Table 1 would measure and cost, and write it to a file if one is given.

    Parameters
    ----------
    source : Table1Source
    channels : str
    store : Path or None
        Where measured cells are looked for.
    only, force : optional
        As in `evaluation.grid_run.RunOptions`.
    quick : bool
        Without the cells that need SIRFS.
    json : Path, optional
    """
    from reports.table1_run import source_experiment

    experiment = source_experiment(source, channels, quick=quick)
    say_plan_of(experiment, store, only=only, force=force, json=json)


def say_plan_of(
    experiment: Experiment,
    store: Path | None,
    *,
    only: Mapping[str, Sequence[str]] | None = None,
    force: bool = False,
    json: Path | None = None,
) -> None:
    """Print what a run of an experiment would measure and cost, as `say_plan` does.

    Parameters
    ----------
    experiment : Experiment
    store : Path or None
    only, force, json : optional
    """
    from evaluation.grid_plan import grid_plan
    from reports.console import say
    from reports.result_files import write_json

    plan = grid_plan(experiment, store, only, force=force)
    say(*plan.lines())
    if json is not None:
        write_json(json, plan.document())
