"""The main job: ``relightlab reproduce``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.commands.options import (
    Channels,
    DataRoot,
    Dataset,
    DetailLayer,
    Force,
    JsonFile,
    KeepModels,
    Manual,
    MethodCommands,
    Methods,
    MethodSeconds,
    Plan,
    Quick,
    Scheduler,
    Shape,
    Size,
    TaskSeconds,
    WeightRules,
    Workers,
    numbers_of,
)

if TYPE_CHECKING:
    from evaluation.grid_run import RunOptions
    from reports.base_shape_run import BaseShapeStudy
    from reports.base_shape_studies import ReportStudy
    from reports.table1_run import Table1Run, Table1Source

app = typer.Typer()


@app.command("reproduce")
def reproduce_command(
    data: DataRoot = None,
    out: Annotated[Path, typer.Option(help="Folder for results and report.")] = Path("out"),
    dataset: Dataset = None,
    workers: Workers = 2,
    size: Size = 300,
    manual: Manual = "0.5,0.5",
    channels: Channels = "gray",
    scheduler: Scheduler = None,
    force: Force = False,
    task_seconds: TaskSeconds = None,
    method: Methods = None,
    method_command: MethodCommands = None,
    method_seconds: MethodSeconds = 600.0,
    shape: Shape = None,
    detail_layer: DetailLayer = None,
    weight_rule: WeightRules = None,
    keep_models: KeepModels = False,
    quick: Quick = False,
    plan: Plan = False,
    json: JsonFile = None,
) -> None:
    """Build the object models, print Tables 1 and 2 beside the published ones, write the report."""
    from evaluation.grid_run import RunOptions
    from evaluation.method_command import CommandMethod
    from evaluation.own_rows import own_choices
    from reports.base_shape_studies import report_studies, study_paths
    from reports.console import print_table, say
    from reports.result_files import require_writable
    from reports.sirfs_run import measure_sirfs_errors, with_errors_of_fits
    from reports.table1_run import measure_table1, open_source
    from reports.table1_text import COLUMNS, summary_lines, table1_lines, table1_title
    from shading_model.object_model import Weights

    weights = Weights(*numbers_of(manual, 2, "--manual"))
    results = [out / "results" / "table1.json", *([json] if json else [])]
    table = out / "results" / "table1.csv"
    commands = [CommandMethod(words, method_seconds) for words in method_command or []]
    own = own_choices(method or [], commands, shape, detail_layer, weight_rule or [])
    source = open_source(data, dataset, size=size, workers=workers)
    say(source.notice)
    store = out / "store"
    chosen = report_studies(source.dataset, data, dataset, channels=channels, quick=quick)
    if plan:
        _say_plans(source, chosen, channels, store, force=force, quick=quick, json=json)
        return
    require_writable(*results, table, *study_paths(table.parent, chosen))
    require_writable(out / "report" / "report.pdf")
    options = RunOptions(workers, scheduler, None, force, task_seconds)
    errors = None if quick else measure_sirfs_errors(source, store=store, options=options)
    run = measure_table1(
        source,
        channels=channels,
        manual=weights,
        own=own,
        store=store,
        keep_models=keep_models,
        quick=quick,
        options=options,
    )
    if errors is not None:
        run = with_errors_of_fits(run, errors, store)
    print_table(table1_title(run.document), COLUMNS, table1_lines(run.document))
    studies = _measured(chosen, store, options)
    written = _write(run, studies, results, table, out / "report")
    say(*(f"written: {path}" for path in written))
    say(*summary_lines(run.document))
    _stop_if_incomplete(run, studies)


def _say_plans(
    source: Table1Source,
    chosen: tuple[ReportStudy, ...],
    channels: str,
    store: Path,
    *,
    force: bool,
    quick: bool,
    json: Path | None,
) -> None:
    """Print what fits, Table 1 and Table 2 would cost; the file has Table 1."""
    from reports.commands.grid import say_plan, say_plan_of
    from reports.sirfs_run import SirfsChoice, choice_experiment

    if not quick:
        say_plan_of(choice_experiment(source, SirfsChoice(), store), store, force=force)
    say_plan(source, channels, store, force=force, quick=quick, json=json)
    for study in chosen:
        for experiment in study.experiments(store):
            say_plan_of(experiment, store, force=force)


def _measured(
    chosen: tuple[ReportStudy, ...], store: Path, options: RunOptions
) -> tuple[BaseShapeStudy, ...]:
    """Measure Table 2 on every set, and print it."""
    from reports.base_shape_studies import measure_report_study, print_study

    studies = []
    for one in chosen:
        studies.append(measure_report_study(one, store=store, options=options))
        print_study(studies[-1])
    return tuple(studies)


def _write(
    run: Table1Run,
    studies: tuple[BaseShapeStudy, ...],
    results: list[Path],
    table: Path,
    folder: Path,
) -> tuple[Path, ...]:
    """Write the numbers and the report; return the paths of all files."""
    from reports.base_shape_studies import write_study
    from reports.result_files import write_csv, write_json
    from reports.table1_report import write_report

    for path in results:
        write_json(path, run.document)
    write_csv(table, run.document["rows"])
    tables = [path for study in studies for path in write_study(table.parent, study)]
    report = write_report(
        folder,
        document=run.document,
        dataset=run.dataset,
        lights=run.lights,
        parameters=run.parameters,
        fits=run.fits,
        studies=studies,
    )
    return (*results, table, *tables, *report)


def _stop_if_incomplete(run: Table1Run, studies: tuple[BaseShapeStudy, ...]) -> None:
    """End the command with exit code 3 if cells of a table are missing, and name them."""
    from reports.table1_text import stop_if_incomplete

    documents = [run.document, *(study.document for study in studies)]
    stop_if_incomplete({"missing": [cell for one in documents for cell in one["missing"]]})
