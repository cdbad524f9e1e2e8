"""The pairs of a study file: of tasks, of the qualification and of the closing tests."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePosixPath

from shading_model.errors import RelightlabError
from studies.study_records import ClosingPair, Pair, Task
from studies.toml_table import TomlTable, checked_table

TASK_KEYS = ("name", "title", "target", "other", "family", "pairs", "target_files", "other_files")
PAIR_KEYS = ("name", "target", "other")
QUALIFICATION_KEYS = ("name", "real", "cartoon")
CLOSING_KEYS = ("name", "plausible", "implausible", "question")

CLOSING_TESTS = ("spheres", "perspective")
SUFFIXES = (".png", ".jpg", ".jpeg", ".webp")
PLACEHOLDER = "{pair}"
MOST_PAIRS = 200
"""Of a task: it has two orders for each pair, so that every pair stands at every place."""


def read_task(table: TomlTable) -> Task:
    """Return one of ``[[tasks]]``.

    Parameters
    ----------
    table : TomlTable

    Returns
    -------
    Task

    Raises
    ------
    RelightlabError
        If a value is wrong or missing, or two pairs have one name.

    Examples
    --------
    >>> files = {"target_files": "ours/{pair}.png", "other_files": "real/{pair}.png"}
    >>> values = {"name": "a", "target": "ours", "other": "real", "pairs": ["kitchen"]}
    >>> read_task(checked_table(values | files, "[[tasks]] a", TASK_KEYS)).pairs
    (Pair(name='kitchen', target='ours/kitchen.png', other='real/kitchen.png'),)
    """
    name = table.name("name")
    target, other = table.name("target"), table.name("other")
    if target == other:
        raise table.fault("other", "another condition than the target")
    pairs = table.values.get("pairs")
    if not isinstance(pairs, list) or not 1 <= len(pairs) <= MOST_PAIRS:
        raise table.fault("pairs", f"a list of 1 to {MOST_PAIRS} pairs")
    records = tuple(_task_pair(table, value, number) for number, value in enumerate(pairs, 1))
    refuse_duplicates([pair.name for pair in records], f"pairs of {table.place}")
    family = table.name("family", default=name)
    return Task(name, table.text("title", default=name), target, other, records, family)


def _task_pair(task: TomlTable, value: object, number: int) -> Pair:
    """Return a pair from a table of its own, or from a name to put into the task's patterns."""
    place = f"pair {number} of {task.place}"
    if not isinstance(value, str):
        return _pair(checked_table(value, place, PAIR_KEYS), "target", "other")
    for key in ("target_files", "other_files"):
        if PLACEHOLDER not in str(task.values.get(key, "")):
            raise task.fault(key, f"a path with {PLACEHOLDER} in it, as pairs are names")
    values = {
        "name": value,
        "target": task.text("target_files").replace(PLACEHOLDER, value),
        "other": task.text("other_files").replace(PLACEHOLDER, value),
    }
    return _pair(TomlTable(values, place), "target", "other")


def read_qualification(table: TomlTable) -> Pair:
    """Return one of ``[[qualification]]``, whose target is the real picture.

    Parameters
    ----------
    table : TomlTable

    Returns
    -------
    Pair

    Examples
    --------
    >>> values = {"name": "street", "real": "a.png", "cartoon": "b.png"}
    >>> read_qualification(checked_table(values, "[[qualification]] 1", QUALIFICATION_KEYS))
    Pair(name='street', target='a.png', other='b.png')
    """
    return _pair(table, "real", "cartoon")


def read_closing(table: TomlTable) -> ClosingPair:
    """Return one of ``[[closing]]``, whose target is the plausible picture.

    Parameters
    ----------
    table : TomlTable

    Returns
    -------
    ClosingPair

    Examples
    --------
    >>> values = {"name": "spheres", "plausible": "a.png", "implausible": "b.png"}
    >>> read_closing(checked_table(values, "[[closing]] 1", CLOSING_KEYS)).target
    'a.png'
    """
    table.choice("name", CLOSING_TESTS)
    pair = _pair(table, "plausible", "implausible")
    return ClosingPair(pair.name, pair.target, pair.other, table.text("question", default=""))


def _pair(table: TomlTable, target: str, other: str) -> Pair:
    first, second = _picture(table, target), _picture(table, other)
    if first == second:
        raise table.fault(other, f"another picture than {target}")
    return Pair(table.name("name"), first, second)


def _picture(table: TomlTable, key: str) -> str:
    """Return a path below the study's folder, so that nothing else can be served."""
    path = PurePosixPath(table.text(key))
    inside = not path.is_absolute() and ".." not in path.parts and "\\" not in str(path)
    if not inside or path.suffix.lower() not in SUFFIXES:
        raise table.fault(key, f"a {', '.join(SUFFIXES)} below the study's folder, with '/'")
    return str(path)


def refuse_duplicates(names: Sequence[str], what: str) -> None:
    """Do nothing, if no name is there twice.

    Parameters
    ----------
    names : sequence of str
    what : str
        Whose names they are.

    Raises
    ------
    RelightlabError
        If one is.

    Examples
    --------
    >>> refuse_duplicates(["a", "b", "a"], "tasks")
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: expected the tasks to have different names, got 'a' twice
    """
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise RelightlabError(
            f"expected the {what} to have different names, got {twice[0]!r} twice"
        )
