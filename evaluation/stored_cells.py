"""The rows of a store that belong to an experiment, and what they say of its cells."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from evaluation.experiment import Cell, Experiment
from evaluation.row_lines import DamagedLine
from evaluation.row_store import Rows
from shading_model.errors import RelightlabError


def last_line(reason: str) -> str:
    r"""Return the last line of a traceback, which names the fault.

    Parameters
    ----------
    reason : str

    Examples
    --------
    >>> last_line("Traceback ...\n  ...\nValueError: no light\n")
    'ValueError: no light'
    """
    return (reason.strip().splitlines() or [""])[-1]


def missing_reason(row: Mapping[str, Any] | None) -> str:
    """Return why a cell has no result, in the words of the fault alone.

    Parameters
    ----------
    row : mapping, optional
        The cell's last row, if it has one.

    Examples
    --------
    >>> missing_reason(None)
    'not measured'
    >>> missing_reason({"reason": "shading_model.errors.RelightlabError: the mask is empty"})
    'the mask is empty'
    """
    if row is None:
        return "not measured"
    return last_line(row["reason"]).removeprefix(f"{RelightlabError.__module__}.RelightlabError: ")


def own_rows(
    experiment: Experiment, store: Rows
) -> Iterator[tuple[dict[str, Any] | DamagedLine, bool]]:
    """Yield the rows of an experiment, and whether its own inputs gave them; and damaged lines.

    Its own rows of cells that this grid leaves out, being a part of a larger one, are passed over.

    Parameters
    ----------
    experiment : Experiment
    store : Rows

    Yields
    ------
    row or DamagedLine, bool

    Raises
    ------
    RelightlabError
        If the store holds rows of another version of the experiment's protocol.
    """
    wanted = experiment.input_hash()
    for row in store.stream():
        if isinstance(row, DamagedLine):
            yield row, False
        elif row["experiment"] == experiment.name:
            if row["version"] != experiment.version:
                raise RelightlabError(
                    f"the store holds results of protocol {experiment.name} {row['version']}, this"
                    f" is version {experiment.version}: keep it and choose another folder for the"
                    " new"
                )
            own = row["inputs"] == wanted
            if not own or experiment.has(row["cell"]):
                yield row, own


def cell_place(experiment: Experiment) -> Callable[[Cell], int]:
    """Return the function from a cell to its place in grid order.

    Parameters
    ----------
    experiment : Experiment

    Returns
    -------
    callable
    """
    places = [
        (axis, {value: place for place, value in enumerate(values)})
        for axis, values in experiment.axes.items()
    ]

    def rank(cell: Cell) -> int:
        number = 0
        for axis, place in places:
            number = number * len(place) + place[cell[axis]]
        return number

    return rank
