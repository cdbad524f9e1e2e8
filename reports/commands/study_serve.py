"""The commands that run a study: ``relightlab study serve``, and what a lab does besides."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.commands.options import JsonFile
from reports.commands.study import app
from shading_model.errors import RelightlabError

if TYPE_CHECKING:
    from studies.response_store import ResponseStore

NOT_VALID = 1
"""Exit code of a check that found a code not valid."""

Served = Annotated[
    Path | None,
    typer.Argument(metavar="STUDY.toml", help="The study; by default the example that ships."),
]
Database = Annotated[
    str, typer.Argument(metavar="DATABASE", help="A SQLite file or postgresql://USER@HOST/NAME.")
]
Where = Annotated[
    str | None,
    typer.Option(metavar="URL", help="Keep the answers here; by default in a file by the study."),
]
Key = Annotated[
    Path | None,
    typer.Option("--key", metavar="FILE", help="The secret key, if it is not by the database."),
]
Subject = Annotated[
    str | None, typer.Argument(metavar="SUBJECT", help="As in the table of subjects.")
]
Worker = Annotated[
    str | None, typer.Option(metavar="ID", help="The subject's id at the panel, instead.")
]


@app.command("serve")
def serve_command(
    study_file: Served = None,
    database: Where = None,
    host: Annotated[str, typer.Option(help="Address to listen at; 0.0.0.0 for all.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port to listen at; 0 for a free one.")] = 8000,
    pilot: Annotated[bool, typer.Option("--pilot", help="Keep all answers apart.")] = False,
    simulated: Annotated[
        bool, typer.Option("--simulated", help="Take simulated subjects, and only them.")
    ] = False,
    key: Key = None,
) -> None:
    """Serve a study, until Ctrl-C; without a file, the example study."""
    from tempfile import TemporaryDirectory

    from reports.console import say
    from studies.example_study import write_example
    from studies.page_build import page_folder
    from studies.response_store import ResponseStore
    from studies.server import make_app
    from studies.serving import READY, serve_app
    from studies.study_file import load_study

    if pilot and simulated:
        raise RelightlabError("expected --pilot or --simulated, got both: choose one")
    mode = "pilot" if pilot else "simulated" if simulated else "live"
    page = page_folder()
    with TemporaryDirectory() as folder:
        study = load_study(study_file or write_example(folder))
        store = ResponseStore(database or _default_database(study_file, mode), key_file=key)
        # Anyone may try the example; a study of one's own is for whom the panel sends.
        server = make_app(study, store, mode=mode, page=page, require_ids=study_file is not None)
        say(f"study: {study_file or study.name}, {mode} sessions")
        say(f"answers: {store.database.url}")
        serve_app(server, host, port, lambda address: say(f"{READY}{address} (Ctrl-C stops)"))
        store.close()


@app.command("verify-codes")
def verify_codes_command(
    database: Database,
    codes_file: Annotated[
        Path | None,
        typer.Argument(metavar="CODES.csv", help="A panel's export, with the codes handed in."),
    ] = None,
    pilot: Annotated[bool, typer.Option("--pilot", help="Codes of pilot sessions, too.")] = False,
    key: Key = None,
    json: JsonFile = None,
) -> None:
    """Check completion codes against the stored answers; without a file, list them all."""
    from reports.console import print_table, say
    from reports.result_files import write_json
    from studies.completion_codes import check_codes, completion_codes, read_codes
    from studies.tables import MODES

    store = _opened(database, key)
    # Anyone may open a pilot session, so its code earns nothing unless it is asked for.
    modes = MODES if pilot else tuple(mode for mode in MODES if mode != "pilot")
    codes = completion_codes(store.key, store.read(modes))
    if codes_file is None:
        print_table("Completion codes", ["subject", "code"], [list(one) for one in codes.items()])
        checked = []
    else:
        handed_in = read_codes(codes_file)
        known = {worker: store.subjects_of(worker) for worker, _ in handed_in if worker}
        checked = check_codes(handed_in, codes, known)
        rows = [[one.worker, one.code, one.subject, one.verdict] for one in checked]
        print_table("Completion codes", ["worker", "code", "subject", "verdict"], rows)
    if json is not None:
        write_json(json, {"codes": codes, "checked": [vars(one) for one in checked]})
        say(f"written: {json}")
    if any(one.verdict != "valid" for one in checked):
        raise typer.Exit(NOT_VALID)


@app.command("export-subject")
def export_subject_command(
    database: Database,
    subject: Subject = None,
    worker: Worker = None,
    key: Key = None,
    json: JsonFile = None,
) -> None:
    """Show all that is kept of one subject, as JSON."""
    from json import dumps

    from reports.console import say
    from reports.result_files import write_json

    store = _opened(database, key)
    kept = {one: store.export_subject(one) for one in _subjects(store, subject, worker)}
    if json is None:
        say(dumps(kept, indent=2))
    else:
        write_json(json, kept)
        say(f"written: {json}")


@app.command("delete-subject")
def delete_subject_command(
    database: Database,
    subject: Subject = None,
    worker: Worker = None,
    key: Key = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask first.")] = False,
) -> None:
    """Delete all that is kept of one subject, for good."""
    from reports.console import say

    store = _opened(database, key)
    for one in _subjects(store, subject, worker):
        if not yes:
            typer.confirm(f"Delete all answers of {one} for good?", abort=True)
        say(f"{one}: {store.delete_subject(one)} rows deleted")


def _default_database(study_file: Path | None, mode: str) -> Path:
    named = study_file or Path("example.toml")
    mark = "" if mode == "live" else f"-{mode}"
    return named.with_name(f"{named.stem}{mark}.sqlite")


def _opened(database: str, key: Path | None) -> ResponseStore:
    from studies.response_store import ResponseStore

    return ResponseStore(database, key_file=key, must_exist=True)


def _subjects(store: ResponseStore, subject: str | None, worker: str | None) -> list[str]:
    if (subject is None) == (worker is None):
        raise RelightlabError("expected SUBJECT or --worker ID: name one of the two")
    if subject is not None:
        return [subject]
    found = sorted(store.subjects_of(str(worker)))
    if not found:
        raise RelightlabError(f"no subject came with the id {worker!r}: see the panel's export")
    return found
