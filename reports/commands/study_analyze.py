"""The command ``relightlab study analyze``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from reports.commands.options import JsonFile
from reports.commands.study import app
from shading_model.errors import RelightlabError


@app.command("analyze")
def analyze_command(
    source: Annotated[
        str,
        typer.Argument(
            metavar="DATABASE|CSV", help="A database, the folder of an export, or a CSV file."
        ),
    ],
    mapping: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="What the columns of a foreign CSV file mean, in TOML."),
    ] = None,
    study: Annotated[
        Path | None,
        typer.Option(metavar="STUDY.toml", help="Analyse as this study plans; else as the paper."),
    ] = None,
    json: JsonFile = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for results and report.")] = Path(
        "study-report"
    ),
    pilot: Annotated[
        bool, typer.Option("--pilot", help="Analyse the pilot sessions, and mark all as such.")
    ] = False,
) -> None:
    """Analyse a study's answers: rates with intervals, tests, models, tables, figures, a page."""
    from reports.console import print_table, say
    from reports.result_files import require_writable
    from reports.study_files import write_study_files
    from reports.study_text import COLUMNS, rate_lines, summary_lines

    if mapping is not None and (study is not None or pilot):
        raise RelightlabError("give --mapping for a foreign file, or --study and --pilot, not both")
    require_writable(json, out / "report" / "report.pdf")
    document = _document(source, mapping, study, pilot=pilot)
    print_table(_title(document), COLUMNS, rate_lines(document))
    say(*summary_lines(document))
    say(*(f"written: {path}" for path in write_study_files(out, document, json)))


def _document(
    source: str, mapping: Path | None, study: Path | None, *, pilot: bool
) -> dict[str, Any]:
    if mapping is not None:
        from reports.foreign_run import analyze_foreign

        return analyze_foreign(Path(source), mapping)
    from reports.study_run import analyze_study

    return analyze_study(source, study, pilot=pilot)


def _title(document: dict[str, Any]) -> str:
    mark = f"{document['mark']} DATA: " if document["mark"] else ""
    return f"{mark}{document['title']}, chosen in percent, with 95 % intervals"
