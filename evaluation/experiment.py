"""What an experiment is: its axes, the function that measures its cells, and its protocol version.

A cell is one combination of values, one for each axis. Cells that share costly work (the models of
one object, say) are measured together, by one task.
"""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from shading_model.errors import RelightlabError, unknown_name

Cell: TypeAlias = Mapping[str, str]
"""Axis names to values."""
Values: TypeAlias = Mapping[str, float]
"""What was measured in one cell, by name; finite numbers."""
CellKey: TypeAlias = tuple[str, ...]
"""The values of a cell in the order of the axes."""
Measure: TypeAlias = Callable[[Any, Sequence[Cell]], Iterator[tuple[Cell, Values]]]
"""Takes the experiment's context and the cells of a task; yields each cell with its values."""


@dataclass(frozen=True, eq=False)
class Experiment:
    """The declaration of a grid of cells.

    Parameters
    ----------
    name : str
    version : int
        Of the protocol; it changes whenever the same inputs would give other numbers.
    axes : dict of tuples of str
        Every combination of their values is a cell, in this order.
    together : tuple of str
        Axes along which cells are measured by one task.
    measure : callable
        See `Measure`; a module-level function, so that it can be sent to another process.
    context : object
        What `measure` needs besides the cells (dataset, lights, parameters); picklable.
    inputs : dict of str
        All that the values depend on, by name: content hashes, parameters, versions.
    seed : str
        Name that random draws were seeded from.
    cost_axis : str
        Axis whose values cost differently, for estimates; empty where all cells cost alike.
    """

    name: str
    version: int
    axes: dict[str, tuple[str, ...]]
    together: tuple[str, ...]
    measure: Measure
    context: Any
    inputs: dict[str, str]
    seed: str
    cost_axis: str = ""

    @property
    def size(self) -> int:
        """Number of cells."""
        size = 1
        for values in self.axes.values():
            size *= len(values)
        return size

    @property
    def protocol(self) -> str:
        """Name and version, as printed beside every number."""
        return f"{self.name} {self.version}"

    def input_hash(self) -> str:
        """Return a SHA-256 over the protocol and all inputs: equal hashes, equal numbers."""
        document = json.dumps([self.name, self.version, self.inputs], sort_keys=True)
        return hashlib.sha256(document.encode()).hexdigest()

    def key(self, cell: Cell) -> CellKey:
        """Return the values of a cell in the order of the axes.

        Parameters
        ----------
        cell : mapping
        """
        return tuple(cell[axis] for axis in self.axes)

    def has(self, cell: Cell) -> bool:
        """Return whether the grid has a cell: the same axes, and on each a value of it.

        Parameters
        ----------
        cell : mapping
        """
        return cell.keys() == self.axes.keys() and all(
            cell[axis] in values for axis, values in self.axes.items()
        )

    def cells(self, only: Mapping[str, Sequence[str]] | None = None) -> Iterator[dict[str, str]]:
        """Return all cells, or those with the given values on some axes, in grid order.

        Parameters
        ----------
        only : mapping of sequences of str, optional

        Raises
        ------
        RelightlabError
            For an axis or a value that the experiment does not have.
        """
        chosen = dict(self.axes)
        for axis, values in (only or {}).items():
            if axis not in self.axes:
                raise unknown_name("axis", axis, self.axes)
            for value in values:
                if value not in self.axes[axis]:
                    raise unknown_name(axis.replace("_", " "), value, self.axes[axis])
            chosen[axis] = tuple(value for value in self.axes[axis] if value in values)
        for combination in itertools.product(*chosen.values()):
            yield dict(zip(self.axes, combination, strict=True))

    def tasks(self, cells: Iterable[Cell]) -> list[tuple[Cell, ...]]:
        """Return the cells grouped into tasks, each ordered as given.

        Parameters
        ----------
        cells : iterable of mappings
        """
        apart = [axis for axis in self.axes if axis not in self.together]
        groups: dict[CellKey, list[Cell]] = {}
        for cell in cells:
            groups.setdefault(tuple(cell[axis] for axis in apart), []).append(cell)
        return [tuple(group) for group in groups.values()]


def parse_only(words: Iterable[str]) -> dict[str, list[str]]:
    """Return ``axis=value[,value]`` words as the values wanted on each axis.

    Parameters
    ----------
    words : iterable of str

    Raises
    ------
    RelightlabError
        If a word has no equals sign or no value.

    Examples
    --------
    >>> parse_only(["object=sun,pear", "setting=natural"])
    {'object': ['sun', 'pear'], 'setting': ['natural']}
    """
    wanted: dict[str, list[str]] = {}
    for word in words:
        axis, equals, values = word.partition("=")
        listed = [value.strip() for value in values.split(",") if value.strip()]
        if not equals or not listed:
            raise RelightlabError(f"expected axis=value or axis=value,value, got {word!r}")
        wanted.setdefault(axis.strip(), []).extend(listed)
    return wanted
