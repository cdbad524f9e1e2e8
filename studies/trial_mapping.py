"""What the columns of a foreign file of choices mean, as a small TOML file tells it.

::

    title = "A study"
    name = "edits"              # optional: of the task, the file's name by default
    groups = ["gender"]         # optional: columns to give rates by

    [columns]
    subject = "worker"
    item = "question"
    outcome = "chose_ours"      # 1 or true where the target was chosen, 0 where not, 0.5 for a tie
    condition = "baseline"      # optional, as are the next three
    side = "ours_side"          # where the target was
    left = "A"                  # the side's value that means left
    position = "position"       # place in the session, from 1

    [keep]                      # only rows with these values, in this order
    complete = ["1"]

    [made.older]                # a number made of another column
    column = "age_band"
    values = {"50-59" = 1, "60-69" = 1}
    otherwise = 0

    [[models]]
    name = "mixed model"
    kind = "mixed"              # or gee-independence, gee-exchangeable
    formula = "chose_ours ~ baseline + (1|worker) + (1|question)"
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from shading_model.errors import RelightlabError
from studies.toml_table import TomlTable, checked_table

FIELDS = ("subject", "item", "outcome", "condition", "side", "left", "position")
NEEDED = ("subject", "item", "outcome")
KINDS = ("mixed", "gee-independence", "gee-exchangeable")


@dataclass(frozen=True)
class MadeColumn:
    """A column of numbers made of a column of words."""

    name: str
    column: str
    values: Mapping[str, float]
    otherwise: float


@dataclass(frozen=True)
class PlannedModel:
    """A model of the choices: its name, its kind and its formula, over columns of the file."""

    name: str
    kind: str
    formula: str


@dataclass(frozen=True)
class TrialMapping:
    """What the columns of a file mean.

    Parameters
    ----------
    title : str
    subject, item, outcome : str
        Columns of the file.
    condition, side, position : str
        Columns of the file, empty where there is none.
    left : str
        The value of `side` that means left.
    keep : mapping of str to tuple of str
        Rows with other values are left out.
    made : tuple of MadeColumn
    groups : tuple of str
        Columns to give rates by.
    models : tuple of PlannedModel
    name : str
        Of the task; empty for the file's.
    """

    title: str
    subject: str
    item: str
    outcome: str
    condition: str
    side: str
    position: str
    left: str
    keep: Mapping[str, tuple[str, ...]]
    made: tuple[MadeColumn, ...]
    groups: tuple[str, ...]
    models: tuple[PlannedModel, ...]
    name: str = ""

    def columns(self) -> tuple[str, ...]:
        """Return the columns that the file must have."""
        made = {column.name for column in self.made}
        wanted = (
            *(self.subject, self.item, self.outcome, self.condition, self.side, self.position),
            *self.keep,
            *(column.column for column in self.made),
            *(group for group in self.groups if group not in made),
        )
        return tuple(dict.fromkeys(name for name in wanted if name))


def read_mapping(path: str | os.PathLike[str]) -> TrialMapping:
    """Return the mapping of a TOML file.

    Parameters
    ----------
    path : path

    Returns
    -------
    TrialMapping

    Raises
    ------
    RelightlabError
        If the file cannot be read, a key is unknown or lacking, or a value is not as expected.
    """
    try:
        values = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise RelightlabError(f"cannot read the mapping {path}: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise RelightlabError(f"the mapping {path} is not TOML: {error}") from error
    return mapping_of(values)


def mapping_of(values: Mapping[str, object]) -> TrialMapping:
    """Return the mapping that the values of a TOML file say.

    Parameters
    ----------
    values : mapping

    Returns
    -------
    TrialMapping

    Raises
    ------
    RelightlabError
        If a key is unknown or lacking, or a value is not as expected.

    Examples
    --------
    >>> columns = {"subject": "worker", "item": "question", "outcome": "chose"}
    >>> mapping_of({"title": "A study", "columns": columns}).columns()
    ('worker', 'question', 'chose')
    """
    known = ("title", "name", "columns", "keep", "made", "groups", "models")
    root = checked_table(values, "the mapping", known)
    columns = root.table("columns", FIELDS)
    keep = TomlTable(checked_mapping(root, "keep"), "[keep]")
    return TrialMapping(
        title=root.text("title", "A study"),
        **{name: columns.text(name) for name in NEEDED},
        **{
            name: columns.text(name) if name in columns.values else ""
            for name in ("condition", "side", "position")
        },
        left=columns.text("left", "left"),
        keep={name: keep.texts(name) for name in keep.values},
        made=tuple(_made(name, one) for name, one in checked_mapping(root, "made").items()),
        groups=root.texts("groups", ()),
        name=root.text("name", ""),
        models=tuple(_model(one) for one in root.tables("models", ("name", "kind", "formula"))),
    )


def checked_mapping(root: TomlTable, key: str) -> Mapping[str, object]:
    """Return a table with names of columns for keys, empty where it is absent.

    Parameters
    ----------
    root : TomlTable
    key : str

    Returns
    -------
    mapping

    Raises
    ------
    RelightlabError
        If it is not a table.
    """
    value = root.values.get(key, {})
    if not isinstance(value, Mapping):
        raise RelightlabError(
            f"expected [{key}] to be a table with names of columns, got {value!r}"
        )
    return value


def _made(name: str, values: object) -> MadeColumn:
    table = checked_table(values, f"[made.{name}]", ("column", "values", "otherwise"))
    numbers = table.values.get("values")
    if not isinstance(numbers, Mapping) or not all(
        isinstance(number, int | float) for number in numbers.values()
    ):
        raise table.fault("values", "a table of numbers such as {A = 0.5}")
    otherwise = table.number("otherwise", -1e9, 1e9, 0.0)
    return MadeColumn(name, table.text("column"), dict(numbers), otherwise)


def _model(table: TomlTable) -> PlannedModel:
    return PlannedModel(table.text("name"), table.choice("kind", KINDS), table.text("formula"))
