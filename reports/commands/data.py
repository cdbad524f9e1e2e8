"""The commands for pictures and their sets: ``relightlab data ...``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from datasets.catalogue import MIT_BERKELEY_LICENCE, known_datasets
from datasets.locations import download_root, find_data_root, missing_data_sentence
from reports.commands.options import DataRoot, JsonFile, Size, names_of
from shading_model.errors import RelightlabError, unknown_name

FETCHED = ("mit-berkeley",)
"""Sets with a recorded SHA-256 for each file."""

app = typer.Typer(help="List, fetch, verify and make sets of pictures.")


@app.command("list")
def list_command(data: DataRoot = None, json: JsonFile = None) -> None:
    """List the known sets: which are here, their size and licence."""
    from reports.console import print_table, say
    from reports.result_files import write_json

    root = find_data_root(data)
    rows = known_datasets(root)
    say(f"data root: {root}" if root else missing_data_sentence("mit-berkeley"))
    print_table(
        "Sets of pictures and answers",
        ("name", "files", "MB", "licence", "holds"),
        [
            (
                *(row.name, str(row.files) if row.present else "not here"),
                *(f"{row.bytes / 1e6:.1f}", row.licence, row.description),
            )
            for row in rows
        ],
    )
    if json is not None:
        document = {"root": str(root) if root else None, "rows": [asdict(row) for row in rows]}
        write_json(json, document)


@app.command("fetch")
def fetch_command(
    name: Annotated[str, typer.Argument(help="mit-berkeley")],
    data: DataRoot = None,
    accept_licence: Annotated[
        bool, typer.Option("--accept-licence", help="You accept the licence that is shown.")
    ] = False,
) -> None:
    """Download a set from its public repository, or complete it; every file is verified."""
    from datasets.fetching import fetch_mit_berkeley
    from reports.console import progress, say

    _check_fetched(name)
    root = download_root(data)
    if accept_licence:
        say(MIT_BERKELEY_LICENCE)
    with progress(f"fetching {name}") as report:
        done = fetch_mit_berkeley(
            root,
            accept_licence=accept_licence,
            progress=lambda step: report(step.done, step.total, step.name),
        )
    say(
        f"{done.folder}: {done.downloaded} files downloaded,"
        f" {done.already_there} were there, all verified"
    )


@app.command("verify")
def verify_command(
    name: Annotated[
        str, typer.Argument(help="mit-berkeley, or the folder of a set of your own.")
    ] = "mit-berkeley",
    data: DataRoot = None,
    json: JsonFile = None,
) -> None:
    """Check every file of a set, by its recorded SHA-256 or by use; exit code 2 at any fault."""
    from datasets.verification import verify_mit_berkeley
    from reports.console import print_table
    from reports.result_files import write_json

    if name not in FETCHED and Path(name).is_dir():
        _verify_own(Path(name), json)
        return
    _check_fetched(name)
    root = find_data_root(data)
    if root is None:
        raise RelightlabError(missing_data_sentence(name))
    report = verify_mit_berkeley(root)
    counts = {
        "whole": report.whole,
        "missing": len(report.missing),
        "damaged": len(report.damaged),
        "not of the set": len(report.extra),
    }
    rows = [(words, str(count)) for words, count in counts.items()]
    print_table(f"{name} in {report.folder}", ("files", "count"), rows)
    if json is not None:
        write_json(json, {**asdict(report), "folder": str(report.folder)})
    if not report.complete:
        raise RelightlabError(f"{report.sentence()}: run 'relightlab data fetch {name}'")


@app.command("synthesize")
def synthesize_command(
    out: Annotated[
        Path | None, typer.Option(help="Folder to make the set in; by default the user's cache.")
    ] = None,
    size: Size = 300,
    seed: Annotated[int, typer.Option(help="Whole number; the same seed, the same set.")] = 0,
    objects: Annotated[
        str | None, typer.Option(metavar="A,B", help="Make these objects only.")
    ] = None,
    samples: Annotated[
        int, typer.Option(help="Light paths per pixel of a laboratory photograph.")
    ] = 16,
    workers: Annotated[int | None, typer.Option(help="Processes; one per processor.")] = None,
) -> None:
    """Make the synthetic set of twenty procedural objects, deterministic from its seed."""
    from datasets.synthetic import Synthetic, synthesize, synthetic_root
    from reports.console import progress, say

    names = names_of(objects) or None
    with progress("making objects") as report:
        make: Callable[..., Path | Synthetic] = synthetic_root if out is None else synthesize
        made = make(
            out,
            size=size,
            seed=seed,
            objects=names,
            samples=samples,
            workers=workers,
            progress=report,
        )
    finished = made if isinstance(made, Synthetic) else Synthetic(made)
    say(f"{finished.root}: {len(finished.objects)} objects, fingerprint {finished.fingerprint()}")


def _verify_own(folder: Path, json: Path | None) -> None:
    from datasets.own_folder import OwnFolder
    from datasets.own_folder_check import check_own_folder
    from reports.console import say
    from reports.result_files import write_json

    report = check_own_folder(OwnFolder(folder))
    for name, found in report.found.items():
        say(f"{name}: {', '.join(found) or 'nothing that can be used'}")
        for sentence in [sentence for of, sentence in report.faults if of == name]:
            say(f"{name}: WRONG: {sentence}")
    lacking = report.lacking()
    say(
        *(f"{name}: no re-rendering without {' and '.join(p)}" for name, p in lacking.items()),
        f"{len(report.found)} objects, {len(report.faults)} faults,"
        f" {len(report.found) - len(lacking)} with depth and albedo",
    )
    if json is not None:
        write_json(json, {**asdict(report), "folder": str(folder), "lacking": lacking})
    if not report.usable:
        raise RelightlabError(f"{folder} cannot be used as it is: {len(report.faults)} faults")


def _check_fetched(name: str) -> None:
    if name not in FETCHED:
        raise unknown_name("set to fetch or verify", name, FETCHED)
