"""The group ``relightlab study ...``: the modules ``study_*`` beside this one add its commands."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

StudyFile = Annotated[Path, typer.Argument(metavar="STUDY.toml", help="The study, in one file.")]

app = typer.Typer(help="Design, run and analyse two-alternative forced-choice studies.")
