"""The commands that plan a study: ``relightlab study design`` and ``relightlab study example``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.commands.options import JsonFile
from reports.commands.study import StudyFile, app

if TYPE_CHECKING:
    import pandas as pd

    from studies.study_records import Study


@app.command("example")
def example_command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder; made if missing.")],
) -> None:
    """Write the example study with its pictures, ready to be served."""
    from reports.console import say
    from studies.example_study import write_example

    say(f"written: {write_example(folder)}")


@app.command("design")
def design_command(
    file: StudyFile,
    summary: Annotated[
        bool, typer.Option("--summary", help="Leave out the table of single pairs.")
    ] = False,
    schedules: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write every trial of every schedule, as .csv."),
    ] = None,
    json: JsonFile = None,
) -> None:
    """Check a study and print how its schedules balance sides, places and halves."""
    from datasets.atomic import atomic_path
    from reports.console import say
    from reports.result_files import require_writable, write_json
    from studies.balance import balance_summary, balance_table, schedule_table
    from studies.schedules import make_schedules
    from studies.study_file import load_study

    study = load_study(file)
    require_writable(schedules, json)
    made = make_schedules(study)
    tasks, pairs = balance_summary(study, made), balance_table(study, made)
    say(*_head(study))
    _print("Schedules of each task", tasks)
    if not summary:
        _print("Pairs over all schedules of a task, by the side of the target", pairs)
    if schedules is not None:
        with atomic_path(schedules) as path:
            schedule_table(made).to_csv(path, index=False, lineterminator="\n")
        say(f"written: {schedules}")
    if json is not None:
        about = {"study": study.name, "hash": study.hash}
        write_json(json, about | {"tasks": _records(tasks), "pairs": _records(pairs)})
        say(f"written: {json}")


def _head(study: Study) -> list[str]:
    """Return what a study is, in a few lines."""
    rules = study.exclusions
    plan = study.analysis
    return [
        f"{study.name}: {study.title}",
        f"hash: {study.hash}",
        (
            f"{len(study.tasks)} tasks, {len(study.qualification)} qualification pairs,"
            f" {len(study.closing)} closing pairs, {len(study.questionnaire)} questions,"
            f" {len(study.stimuli())} pictures"
        ),
        f"left out: {', '.join(rules.in_words()) or 'nobody'}",
        (
            f"planned: level {plan.alpha:g}, equivalence within {plan.equivalence_margin:g} of 0.5,"
            f" groups {', '.join(plan.groups) or 'none'}"
        ),
    ]


def _print(title: str, table: pd.DataFrame) -> None:
    from reports.console import print_table

    columns = [str(name).replace("_", " ") for name in table.columns]
    print_table(title, columns, [[str(value) for value in row] for row in table.to_numpy()])


def _records(table: pd.DataFrame) -> list[dict[str, object]]:
    return [dict(zip(table.columns, row, strict=True)) for row in table.to_numpy().tolist()]
