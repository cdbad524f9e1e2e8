"""Values of options that hold several parts: lists of names and of numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from shading_model.errors import RelightlabError

DataRoot = Annotated[
    Path | None,
    typer.Option("--data", metavar="ROOT", help="Folder that holds mit-berkeley/ and other sets."),
]
JsonFile = Annotated[
    Path | None,
    typer.Option("--json", metavar="FILE", help="Write the same numbers to this file."),
]
Workers = Annotated[int, typer.Option(help="Processes; results do not depend on them.")]
Scheduler = Annotated[
    str | None,
    typer.Option(metavar="tcp://HOST:PORT", help="Measure on this Dask cluster instead."),
]
Only = Annotated[
    list[str] | None,
    typer.Option(metavar="AXIS=VALUE", help="Measure only these cells; may be given again."),
]
Force = Annotated[bool, typer.Option("--force", help="Measure again what is done.")]
TaskSeconds = Annotated[
    float | None, typer.Option(metavar="SECONDS", help="Stop a task that takes longer.")
]
Store = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Keep the rows in this folder, and resume.")
]
KeepModels = Annotated[
    bool, typer.Option("--keep-models", help="Keep the object models in the store, too.")
]
Without = Annotated[
    list[str] | None,
    typer.Option(metavar="TERM", help="Leave a term of the loss out; again for more."),
]
Quick = Annotated[
    bool, typer.Option("--quick", help="Leave out what needs SIRFS; the results say so.")
]
Plan = Annotated[
    bool, typer.Option("--plan", help="Say what would be measured and its cost; run nothing.")
]
Dataset = Annotated[
    str | None,
    typer.Option(help="mit-berkeley, synthetic or a folder; by default the first that is found."),
]
Objects = Annotated[str | None, typer.Option(metavar="A,B", help="Report these objects only.")]
Channels = Annotated[str, typer.Option(help="Compare 'gray' or all three, 'color'.")]
Size = Annotated[int, typer.Option(help="Side of the synthetic pictures in pixels.")]
Manual = Annotated[str, typer.Option(metavar="W_P,W_G", help="The weights reported as 'manual'.")]

Methods = Annotated[
    list[str] | None,
    typer.Option("--method", metavar="MODULE:BUILD", help="A method beside ours; again for more."),
]
MethodCommands = Annotated[
    list[str] | None,
    typer.Option(
        "--method-command",
        metavar="COMMAND",
        help="A method in another environment, with {inputs} and {outputs}.",
    ),
]
MethodSeconds = Annotated[
    float, typer.Option(help="Time limit of a method command for one object.")
]
Shape = Annotated[
    str | None, typer.Option(metavar="MODULE:SHAPE", help="Base shape of a model beside ours.")
]
DetailLayer = Annotated[
    str | None, typer.Option(metavar="MODULE:LAYER", help="Its layer in place of S_g.")
]
WeightRules = Annotated[
    list[str] | None,
    typer.Option(
        "--weight-rule", metavar="MODULE:RULE", help="A weight rule more; again for more."
    ),
]


def names_of(text: str | None) -> tuple[str, ...]:
    """Return the names of a list with commas between them; none where nothing was given.

    Parameters
    ----------
    text : str or None

    Returns
    -------
    tuple of str

    Raises
    ------
    RelightlabError
        If something was given but it names nothing.

    Examples
    --------
    >>> names_of("raccoon, sun")
    ('raccoon', 'sun')
    """
    names = tuple(part.strip() for part in (text or "").split(",") if part.strip())
    if text is not None and not names:
        raise RelightlabError(f"expected names with commas between them, got {text!r}")
    return names


def numbers_of(text: str, count: int, option: str) -> tuple[float, ...]:
    """Return the finite numbers of a list with commas between them.

    Parameters
    ----------
    text : str
    count : int
        How many are expected.
    option : str
        What the user knows the list by.

    Returns
    -------
    tuple of float

    Raises
    ------
    RelightlabError
        If there are more or fewer, or a part is not a finite number.

    Examples
    --------
    >>> numbers_of("1, 0.5", 2, "--weights")
    (1.0, 0.5)
    """
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != count or not all(abs(number) < float("inf") for number in numbers):
        raise RelightlabError(
            f"expected {count} numbers with commas between them for {option}, got {text!r}"
        )
    return numbers
