"""The commands that plan a study: ``relightlab study design`` and ``relightlab study example``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from reports.commands.study import app


@app.command("example")
def example_command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder to make.")],
) -> None:
    """Write the example study with its stimuli, ready to be served."""
    from reports.console import say
    from studies.example_study import write_example

    say(f"written: {write_example(folder)}")
