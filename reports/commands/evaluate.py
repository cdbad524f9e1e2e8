"""The commands that measure: ``relightlab evaluate ...``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

from typing import Annotated

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
    Objects,
    Only,
    Plan,
    Quick,
    Scheduler,
    Shape,
    Size,
    Store,
    TaskSeconds,
    WeightRules,
    Without,
    Workers,
    names_of,
    numbers_of,
)

app = typer.Typer(help="Measure the model.")


@app.command("rerendering")
def rerendering_command(
    dataset: Dataset = None,
    data: DataRoot = None,
    objects: Objects = None,
    channels: Channels = "gray",
    manual: Manual = "0.5,0.5",
    size: Size = 300,
    workers: Workers = 2,
    scheduler: Scheduler = None,
    store: Store = None,
    only: Only = None,
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
    """Relight every object under natural lights and compare with the truth (Table 1)."""
    from evaluation.experiment import parse_only
    from evaluation.grid_run import RunOptions
    from evaluation.method_command import CommandMethod
    from evaluation.own_rows import own_choices
    from reports.commands.grid import say_plan
    from reports.console import print_table, say
    from reports.result_files import require_writable, write_json
    from reports.table1_run import measure_table1, open_source
    from reports.table1_text import COLUMNS, stop_if_incomplete, table1_lines, table1_title
    from shading_model.object_model import Weights

    weights = Weights(*numbers_of(manual, 2, "--manual"))
    commands = [CommandMethod(words, method_seconds) for words in method_command or []]
    own = own_choices(method or [], commands, shape, detail_layer, weight_rule or [])
    source = open_source(data, dataset, size=size, workers=workers)
    say(source.notice)
    if plan:
        wanted = parse_only(only or [])
        say_plan(source, channels, store, only=wanted, force=force, quick=quick, json=json)
        return
    require_writable(json)
    run = measure_table1(
        source,
        objects=names_of(objects),
        channels=channels,
        manual=weights,
        own=own,
        store=store,
        keep_models=keep_models,
        quick=quick,
        options=RunOptions(workers, scheduler, parse_only(only or []), force, task_seconds),
    )
    print_table(table1_title(run.document), COLUMNS, table1_lines(run.document))
    if json is not None:
        write_json(json, run.document)
        say(f"written: {json}")
    stop_if_incomplete(run.document)


@app.command("sirfs")
def sirfs_command(
    dataset: Dataset = None,
    data: DataRoot = None,
    objects: Objects = None,
    setting: Annotated[
        str, typer.Option(help="'natural', 'laboratory' or 'both'; its lights are the likely ones.")
    ] = "both",
    channels: Annotated[str, typer.Option(help="Fit 'color' or 'gray' photographs.")] = "color",
    without: Without = None,
    size: Size = 300,
    workers: Workers = 2,
    scheduler: Scheduler = None,
    store: Store = None,
    force: Force = False,
    task_seconds: TaskSeconds = None,
    plan: Plan = False,
    json: JsonFile = None,
) -> None:
    """Fit SIRFS to the photographs and compare shape, albedo, shading and light with the truth."""
    from evaluation.grid_run import RunOptions
    from reports.commands.grid import say_plan_of
    from reports.console import print_table, say
    from reports.result_files import require_writable, write_json
    from reports.sirfs_run import (
        COLUMNS,
        SirfsChoice,
        choice_experiment,
        measure_sirfs_errors,
        sirfs_lines,
        sirfs_title,
    )
    from reports.table1_run import open_source
    from reports.table1_text import stop_if_incomplete

    left_out = tuple(term for words in without or () for term in names_of(words))
    choice = SirfsChoice(names_of(objects), setting, channels, left_out)
    source = open_source(data, dataset, size=size, workers=workers)
    say(source.notice)
    if plan:
        say_plan_of(choice_experiment(source, choice, store), store, force=force, json=json)
        return
    require_writable(json)
    options = RunOptions(workers, scheduler, None, force, task_seconds)
    document = measure_sirfs_errors(source, choice, store=store, options=options)
    print_table(sirfs_title(document), COLUMNS, sirfs_lines(document))
    if json is not None:
        write_json(json, document)
        say(f"written: {json}")
    stop_if_incomplete(document)


@app.command("base-shapes")
def base_shapes_command(
    dataset: Annotated[
        str | None,
        typer.Option(help="mit-berkeley, psm-uw, rgbd-mitten or synthetic; first found if none."),
    ] = None,
    data: DataRoot = None,
    objects: Objects = None,
    shapes: Annotated[
        str | None, typer.Option(metavar="A,B", help="Measure these base shapes only.")
    ] = None,
    variants: Annotated[
        str,
        typer.Option(metavar="A,B", help="What is built from and changed; 'all' for every one."),
    ] = "mean",
    channels: Channels = "gray",
    size: Size = 300,
    workers: Workers = 2,
    scheduler: Scheduler = None,
    store: Store = None,
    force: Force = False,
    task_seconds: TaskSeconds = None,
    quick: Quick = False,
    plan: Plan = False,
    json: JsonFile = None,
) -> None:
    """Relight models on several base shapes and compare with real photographs (Table 2)."""
    from evaluation.base_shape_grid import available_variants
    from evaluation.grid_run import RunOptions
    from reports.base_shape_run import (
        COLUMNS,
        StudyChoice,
        finding_lines,
        measure_base_shapes,
        open_study_set,
        study_experiment,
        study_lines,
        study_title,
    )
    from reports.commands.grid import say_plan_of
    from reports.console import print_table, say
    from reports.result_files import require_writable, write_json
    from reports.table1_text import stop_if_incomplete

    found, notice = open_study_set(data, dataset, size=size, workers=workers)
    say(notice)
    chosen = available_variants(found) if variants == "all" else names_of(variants)
    choice = StudyChoice(names_of(objects), chosen, names_of(shapes), channels, quick)
    if plan:
        say_plan_of(study_experiment(found, choice, store), store, force=force, json=json)
        return
    require_writable(json)
    options = RunOptions(workers, scheduler, None, force, task_seconds)
    document = measure_base_shapes(found, choice, store=store, options=options).document
    print_table(study_title(document), COLUMNS, study_lines(document))
    say(*finding_lines(document))
    if json is not None:
        write_json(json, document)
        say(f"written: {json}")
    stop_if_incomplete(document)
