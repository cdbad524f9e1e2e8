"""What a report says, whichever way it is shown: sections of prose, tables, equations and figures.

Tables and figures name the rows they were made from by a hash over them, so that a printed number
can be traced to the results file. Prose carries the marks of `reports.prose`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from reports.figures import PanelFigure, PlotFigure
from reports.rows_behind import Rows
from shading_model.errors import RelightlabError


@dataclass(frozen=True)
class Prose:
    """A paragraph; `role` is empty, ``lead`` or ``verdict``."""

    text: str
    role: str = ""


@dataclass(frozen=True)
class Stamp:
    """A warning at the head of a report: a word, a sentence, and what it is about."""

    word: str
    text: str
    items: tuple[str, ...] = ()


@dataclass(frozen=True)
class Equation:
    """An equation of the paper.

    Parameters
    ----------
    label : str
        The paper's.
    text : str
        What it says, in prose.
    typst, mathml, words : str
        The equation for the printed report, for the page, and for who listens.
    """

    label: str
    text: str
    typst: str
    mathml: str
    words: str


@dataclass(frozen=True)
class Judgement:
    """A statement with the word for whether it holds, how often, and the numbers."""

    state: str
    statement: str
    count: str
    evidence: str = ""


@dataclass(frozen=True)
class Judgements:
    """Statements that were checked."""

    items: tuple[Judgement, ...]


@dataclass(frozen=True)
class Definitions:
    """Terms, each with a text."""

    items: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Cell:
    """A cell of a table.

    Parameters
    ----------
    text : str
        Shown as it is, without marks.
    note : str
        A second, smaller line.
    role : str
        Empty, or ``head``, ``ours``, ``published``, ``absent``, ``quiet`` or ``code``.
    columns, rows : int
        How many it spans.
    edge : bool
        Whether a rule stands to its left.
    """

    text: str
    note: str = ""
    role: str = ""
    columns: int = 1
    rows: int = 1
    edge: bool = False


@dataclass(frozen=True)
class Group:
    """Rows of a table under a heading of their own, which may be empty."""

    title: str
    rows: tuple[tuple[Cell, ...], ...]


@dataclass(frozen=True)
class Table:
    """A table.

    Parameters
    ----------
    identifier : str
        Unique in the report, fit for an address.
    caption : str
        Prose.
    head : tuple of tuples of Cell
    groups : tuple of Group
    rows : Rows, optional
        What it was made from; None for a table that is itself about the run.
    layout : str
        Tables of one layout look alike; by default the identifier, a layout of its own.
    """

    identifier: str
    caption: str
    head: tuple[tuple[Cell, ...], ...]
    groups: tuple[Group, ...]
    rows: Rows | None = None
    layout: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "layout", self.layout or self.identifier)
        wrong = [row for group in self.groups for row in group.rows if _width(row) != self.width]
        if wrong:
            raise RelightlabError(
                f"expected rows of {self.width} columns in the table {self.identifier},"
                f" got one of {_width(wrong[0])}"
            )

    @property
    def width(self) -> int:
        """Number of columns."""
        return _width(self.head[0] if self.head else self.groups[0].rows[0])

    def head_columns(self) -> tuple[tuple[int | None, ...], ...]:
        """Return the column that each cell of the head is alone above, None where it is not."""
        taken: set[tuple[int, int]] = set()
        found = []
        for line, cells in enumerate(self.head):
            starts: list[int | None] = []
            for cell in cells:
                column = next(c for c in range(self.width) if (line, c) not in taken)
                taken |= {
                    (line + down, column + right)
                    for down in range(cell.rows)
                    for right in range(cell.columns)
                }
                alone = cell.columns == 1 and line + cell.rows == len(self.head)
                starts.append(column if alone else None)
            found.append(tuple(starts))
        return tuple(found)


@dataclass(frozen=True)
class Plot:
    """A plot and the rows behind it."""

    figure: PlotFigure
    rows: Rows


@dataclass(frozen=True)
class Pictures:
    """Rows of pictures and the rows of results that they illustrate."""

    figure: PanelFigure
    rows: Rows


@dataclass(frozen=True)
class Folded:
    """Tables that the page shows on demand, and print always."""

    summary: str
    blocks: tuple[Table, ...]


@dataclass(frozen=True)
class Remarks:
    """Short texts with a title each, side by side where there is room."""

    items: tuple[Section, ...]


Block: TypeAlias = (
    Prose | Equation | Judgements | Definitions | Table | Plot | Pictures | Folded | Remarks
)


@dataclass(frozen=True)
class Section:
    """Blocks under a title."""

    identifier: str
    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Report:
    """A whole report.

    Parameters
    ----------
    title, eyebrow : str
        The eyebrow is the line above the title.
    name : str
        What the browser's tab says.
    description : str
    authors, keywords : tuple of str
    lead : Prose
    stamps : tuple of Stamp
    teaser : Pictures, optional
    sections : tuple of Section
    maker : str
        What made the report, for its last line.
    stops : tuple of str
        Colours of the scale of signed maps, from low to high.
    """

    title: str
    eyebrow: str
    name: str
    description: str
    authors: tuple[str, ...]
    keywords: tuple[str, ...]
    lead: Prose
    stamps: tuple[Stamp, ...]
    teaser: Pictures | None
    sections: tuple[Section, ...]
    maker: str
    stops: tuple[str, ...]


def kind(block: object) -> str:
    """Return what kind of block something is, in lower case.

    Parameters
    ----------
    block : object
        One of this module's types.

    Examples
    --------
    >>> kind(Prose("words"))
    'prose'
    """
    return type(block).__name__.lower()


def tied_blocks(report: Report) -> Iterator[tuple[str, Rows]]:
    """Return the tables and figures made from rows, with what they were made from.

    Parameters
    ----------
    report : Report

    Yields
    ------
    str, Rows
        Identifier and rows.
    """
    for section in report.sections:
        for block in section.blocks:
            for inner in block.blocks if isinstance(block, Folded) else (block,):
                if isinstance(inner, Table) and inner.rows is not None:
                    yield inner.identifier, inner.rows
                elif isinstance(inner, Plot | Pictures):
                    yield inner.figure.identifier, inner.rows


def _width(cells: tuple[Cell, ...]) -> int:
    return sum(cell.columns for cell in cells)
