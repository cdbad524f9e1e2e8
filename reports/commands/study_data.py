"""The commands that move answers: ``relightlab study export``, ``import`` and ``simulate``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.commands.options import JsonFile
from reports.commands.study import StudyFile, app
from shading_model.errors import RelightlabError, unknown_name

if TYPE_CHECKING:
    from studies.observers import ObserverModel
    from studies.study_records import Study
    from studies.tables import StudyData

PROLIFIC = "prolific"
"""The format of `import` that adds to subjects who are there, rather than new ones."""

Database = Annotated[
    str | None,
    typer.Option(metavar="URL", help="A SQLite file or postgresql://USER@HOST/NAME."),
]
Key = Annotated[
    Path | None,
    typer.Option("--key", metavar="FILE", help="The secret key, if it is not by the database."),
]


@app.command("export")
def export_command(
    database: Annotated[
        str, typer.Argument(metavar="DATABASE", help="A SQLite file or postgresql://...")
    ],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder to make, or to make again.")],
    pilot: Annotated[
        bool, typer.Option("--pilot", help="The pilot sessions, instead of all others.")
    ] = False,
    key: Key = None,
) -> None:
    """Write the answers as CSV and Parquet, with a data dictionary."""
    from studies.response_store import COUNTED, ResponseStore

    store = ResponseStore(database, key_file=key, must_exist=True)
    data = store.read(("pilot",) if pilot else COUNTED)
    store.close()
    _export(data, out)


@app.command("import")
def import_command(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="A CSV file, or the folder of an export or a set."),
    ],
    file_format: Annotated[
        str,
        typer.Option(
            "--format",
            metavar="FORMAT",
            help="export, csv, mturk, dynavect-2afc, gengap-realfake; or prolific: what the panel"
            " says of subjects that are there.",
        ),
    ],
    database: Annotated[
        str, typer.Option(metavar="URL", help="A SQLite file or postgresql://USER@HOST/NAME.")
    ],
    mapping: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="What the columns of a csv file mean, in TOML."),
    ] = None,
    name: Annotated[
        str, typer.Option(help="Of the study the answers belong to; by default the file's.")
    ] = "",
    key: Key = None,
    json: JsonFile = None,
) -> None:
    """Add answers that were collected elsewhere; adding them again changes nothing."""
    from reports.console import say
    from reports.result_files import write_json
    from studies.importing import FORMATS, ImportOptions, import_answers
    from studies.response_store import ResponseStore
    from studies.simulation import write_apart
    from studies.trial_mapping import read_mapping

    if file_format not in (*FORMATS, PROLIFIC):
        raise unknown_name("format", file_format, (*FORMATS, PROLIFIC))
    columns = read_mapping(mapping) if mapping is not None else None
    if file_format == PROLIFIC:
        _join(file, database, key, json)
        return
    store = ResponseStore(database, key_file=key)
    data = import_answers(file, file_format, ImportOptions(name, store.key, columns))
    added = write_apart(store, data)
    store.close()
    counts = ", ".join(f"{count} {table}" for table, count in added.items())
    say(f"added to {store.database.url}: {counts}", *_marks(data))
    if json is not None:
        write_json(json, {"added": added, "marks": list(data.marks)})


@app.command("simulate")
def simulate_command(
    study_file: StudyFile,
    subjects: Annotated[int, typer.Option(metavar="N", help="Simulated subjects.")],
    http: Annotated[
        str | None,
        typer.Option("--http", metavar="URL", help="Take part at this server, as subjects do."),
    ] = None,
    database: Database = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write an export to this folder.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Whole number; the same seed, the same answers.")] = 0,
    rate: Annotated[
        list[str] | None,
        typer.Option(
            metavar="[TASK=]RATE", help="How often the target is taken; again for more tasks."
        ),
    ] = None,
    subject_sd: Annotated[float, typer.Option(help="Spread of subjects, in log odds.")] = 0.5,
    item_sd: Annotated[float, typer.Option(help="Spread of pairs, in log odds.")] = 0.3,
    side: Annotated[float, typer.Option(help="Pull of the left side, in log odds.")] = 0.0,
    learning: Annotated[float, typer.Option(help="Gain per trial, in log odds.")] = 0.0,
    expertise: Annotated[float, typer.Option(help="Gain of experts, in log odds.")] = 0.0,
    expert_share: Annotated[float, typer.Option(help="Share that declares expertise.")] = 0.2,
    lapse: Annotated[float, typer.Option(help="Share of trials left to a coin.")] = 0.02,
    dropout: Annotated[float, typer.Option(help="Share that stops before the end.")] = 0.0,
    at_once: Annotated[int, typer.Option(help="Sessions under way together, with --http.")] = 20,
    key: Key = None,
    json: JsonFile = None,
) -> None:
    """Let simulated subjects take part: at a server, into a database, or into files."""
    from studies.observers import ObserverModel
    from studies.study_file import load_study

    if sum(target is not None for target in (http, database, out)) != 1:
        raise RelightlabError("expected one of --http URL, --database URL and --out DIR: name one")
    if at_once < 1:
        raise RelightlabError(f"expected --at-once to be 1 or more, got {at_once}")
    study = load_study(study_file)
    rates = _rates(rate or [], study)
    usual = rates.pop("", 0.5)
    model = ObserverModel(
        rates=rates,
        rate=usual,
        subject_sd=subject_sd,
        item_sd=item_sd,
        side=side,
        learning=learning,
        expertise=expertise,
        expert_share=expert_share,
        lapse=lapse,
        dropout=dropout,
    )
    if http is not None:
        _take_part(http, study, subjects, model, seed, at_once, json)
    else:
        _simulate(study, subjects, model, seed, database, key, out)


def _export(data: StudyData, out: Path) -> None:
    from reports.console import say
    from studies.exporting import export_study

    export_study(data, out)
    say(f"written: {out} ({len(data.subjects)} subjects, {len(data.trials)} trials)", *_marks(data))


def _marks(data: StudyData) -> list[str]:
    from studies.exporting import marks_sentence

    return [sentence] if (sentence := marks_sentence(data)) else []


def _join(file: Path, database: str, key: Path | None, json: Path | None) -> None:
    from dataclasses import asdict

    from reports.console import say
    from reports.result_files import write_json
    from studies.prolific_exports import join_prolific
    from studies.response_store import ResponseStore

    store = ResponseStore(database, key_file=key, must_exist=True)
    done = join_prolific(store, file)
    store.close()
    say(done.sentence())
    if json is not None:
        write_json(json, asdict(done))


def _simulate(
    study: Study,
    subjects: int,
    model: ObserverModel,
    seed: int,
    database: str | None,
    key: Path | None,
    out: Path | None,
) -> None:
    from reports.console import say
    from studies.response_store import ResponseStore
    from studies.simulation import simulate, write_apart

    data = simulate(study, subjects, model, seed=seed)
    if out is not None:
        _export(data, out)
        return
    store = ResponseStore(str(database), key_file=key)
    added = write_apart(store, data)
    store.close()
    counts = ", ".join(f"{count} {table}" for table, count in added.items())
    say(f"added to {store.database.url}: {counts}", *_marks(data))


def _take_part(
    url: str,
    study: Study,
    subjects: int,
    model: ObserverModel,
    seed: int,
    at_once: int,
    json: Path | None,
) -> None:
    import numpy as np

    from reports.console import say
    from reports.result_files import write_json
    from studies.simulated_sessions import simulate_http

    done = simulate_http(url, study, subjects, model, seed=seed, at_once=at_once)
    median, late = np.percentile(done.milliseconds or [0.0], [50, 95])
    say(
        f"simulated: {len(done.codes)} sessions complete, {len(done.unfinished)} stopped,"
        f" {len(done.acknowledged)} trials acknowledged",
        f"milliseconds to acknowledge a trial: median {median:.1f}, 95th percentile {late:.1f};"
        f" {done.repeats} requests sent again",
    )
    if json is not None:
        times = {"median_ms": float(median), "p95_ms": float(late), "repeats": done.repeats}
        counts = {"complete": len(done.codes), "stopped": len(done.unfinished)}
        write_json(json, {**counts, "trials": len(done.acknowledged), **times, "simulated": True})


def _rates(texts: list[str], study: Study) -> dict[str, float]:
    """Return rates by task; that of all others under the empty name."""
    tasks = [task.name for task in study.tasks]
    rates: dict[str, float] = {}
    for text in texts:
        task, _, number = text.rpartition("=")
        if task and task not in tasks:
            raise unknown_name("task", task, tasks)
        try:
            rates[task] = float(number)
        except ValueError as error:
            raise RelightlabError(
                f"expected --rate TASK=RATE with a number from 0 to 1, got {text!r}"
            ) from error
    return rates
