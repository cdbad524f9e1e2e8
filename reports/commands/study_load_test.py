"""The command that measures a study's server under load: ``relightlab study load-test``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from reports.commands.options import JsonFile
from reports.commands.study import app
from shading_model.errors import RelightlabError

FAULTY = 1
"""Exit code of a run that lost or doubled an answer."""


@app.command("load-test")
def load_test_command(
    study_file: Annotated[
        Path | None,
        typer.Argument(metavar="STUDY.toml", help="The study; by default the example that ships."),
    ] = None,
    database: Annotated[
        str | None,
        typer.Option(metavar="URL", help="An empty database; by default a file for the time."),
    ] = None,
    subjects: Annotated[int, typer.Option(help="Subjects, all at once.")] = 200,
    think: Annotated[
        float, typer.Option(metavar="SECONDS", help="Mean time from one answer to the next.")
    ] = 2.0,
    json: JsonFile = None,
) -> None:
    """Let many simulated subjects do the study at once; exit code 1 if an answer is lost."""
    from tempfile import TemporaryDirectory

    from reports.console import print_table, say
    from reports.result_files import write_json
    from studies.example_study import write_example
    from studies.response_store import ResponseStore
    from studies.server_process import running_server
    from studies.simulated_load import LoadPlan, judge_load, run_load

    with TemporaryDirectory() as folder:
        where = database or str(Path(folder) / "answers.sqlite")
        store = ResponseStore(where)
        if len(store.read().subjects):
            raise RelightlabError(
                f"expected an empty database, got answers in {where}: name another"
            )
        file = study_file or write_example(Path(folder) / "study")
        with running_server(file, where) as address:
            logs, seconds = run_load(address, LoadPlan(subjects=subjects, think_seconds=think))
        result = judge_load(logs, seconds, store.read(), store.key)
        store.close()
    rows = [[name.replace("_", " "), f"{value:.4g}"] for name, value in vars(result).items()]
    print_table("Load test", ["what", "value"], rows)
    if json is not None:
        write_json(json, vars(result))
        say(f"written: {json}")
    if result.lost or result.doubled or result.wrong_codes:
        raise typer.Exit(FAULTY)
