"""The command ``relightlab``: its sub-commands, and how it fails.

Whatever is the user's to mend is one sentence on standard error and exit code 2.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.metadata import version
from typing import Annotated

import typer

from reports.commands.data import app as data_app
from reports.commands.evaluate import app as evaluate_app
from reports.commands.gate import app as gate_app
from reports.commands.grid import app as grid_app
from reports.commands.model import app as model_app
from reports.commands.probe import app as probe_app
from reports.commands.reproduce import app as reproduce_app
from reports.commands.sirfs import app as sirfs_app
from reports.commands.study_group import app as study_app
from shading_model.errors import RelightlabError

WRONG_USE = 2
INTERRUPTED = 130
BROKEN_PIPE = 141

app = typer.Typer(
    name="relightlab",
    help="Relight objects cut from photographs, and measure how well that works.",
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.add_typer(reproduce_app)
app.add_typer(data_app, name="data")
app.add_typer(model_app, name="model")
app.add_typer(probe_app, name="probe")
app.add_typer(evaluate_app, name="evaluate")
app.add_typer(gate_app, name="gate")
app.add_typer(grid_app, name="grid")
app.add_typer(sirfs_app, name="sirfs")
app.add_typer(study_app, name="study")


@app.callback(invoke_without_command=True)
def relightlab_command(
    context: typer.Context,
    show_version: Annotated[
        bool, typer.Option("--version", help="Print the version and exit.")
    ] = False,
) -> None:
    """Relight objects cut from photographs, and measure how well that works."""
    if show_version:
        typer.echo(f"relightlab {version('relightlab')}")
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(WRONG_USE)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit: 0, or 2 for wrong use, 130 for Ctrl-C."""
    sys.exit(run(arguments))


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those the process was started with by default.

    Returns
    -------
    int
        0 if all went well; 2 after one sentence on standard error; 130 after Ctrl-C; 141 if
        whoever reads the output has gone.

    Examples
    --------
    >>> run(["evaluate", "rerendering", "--manual", "1"])
    2
    """
    try:
        given = None if arguments is None else list(arguments)
        code = app(given, prog_name="relightlab", standalone_mode=False)
        sys.stdout.flush()
    except BrokenPipeError:
        return _leave_quietly()
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    except (RelightlabError, typer.TyperException, OSError, MemoryError) as error:
        return _fail(_sentence(error))
    return _fail("stopped before the end", INTERRUPTED) if code == INTERRUPTED else int(code or 0)


def _fail(sentence: str, code: int = WRONG_USE) -> int:
    typer.echo(f"relightlab: {sentence}", err=True)
    return code


def _sentence(error: Exception) -> str:
    if isinstance(error, typer.TyperException):
        message = error.format_message().strip().rstrip(".")
        return f"{message}: see 'relightlab --help' or 'relightlab COMMAND --help'"
    if isinstance(error, MemoryError):
        return "there is not enough memory for this: use a smaller picture or fewer workers"
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    return str(error)


def _leave_quietly() -> int:
    # Python would flush standard output once more on its way out, and complain.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return BROKEN_PIPE
