"""Reading the tables of a TOML file so that every fault is told in one sentence."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from shading_model.errors import RelightlabError, unknown_name

NAME = re.compile(r"[A-Za-z0-9]+(?:[._-][A-Za-z0-9]+)*")
LONGEST_NAME = 60
LONGEST_TEXT = 20_000
# Tabs and line ends are text; other control characters are a slip that no reader would see.
CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")


@dataclass(frozen=True)
class TomlTable:
    """A table whose keys are all known.

    Parameters
    ----------
    values : mapping
    place : str
        What a message calls it: ``[trials]``.

    Examples
    --------
    >>> table = checked_table({"question": "Which?"}, "[trials]", ("question", "allow_tie"))
    >>> table.text("question"), table.flag("allow_tie", default=False)
    ('Which?', False)
    """

    values: Mapping[str, Any]
    place: str

    def fault(self, key: str, expected: str) -> RelightlabError:
        """Return the error for a value that is missing or not as expected."""
        came = _shown(self.values[key]) if key in self.values else "nothing"
        return RelightlabError(f"{self.place}: expected {key} to be {expected}, got {came}")

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text that is not blank, or the default where the key is absent."""
        if key not in self.values and default is not None:
            return default
        value = self.values.get(key)
        if not isinstance(value, str) or not value.strip() or CONTROL.search(value):
            raise self.fault(key, "a text that is not empty")
        if len(value) > LONGEST_TEXT:
            raise self.fault(key, f"at most {LONGEST_TEXT} characters long")
        return value.strip()

    def name(self, key: str, default: str | None = None) -> str:
        """Return a name of letters and digits with '-', '_' or '.' between them."""
        value = self.text(key, default)
        if not NAME.fullmatch(value) or len(value) > LONGEST_NAME:
            raise self.fault(
                key,
                f"letters and digits with '-', '_' or '.' between them, at most {LONGEST_NAME}",
            )
        return value

    def flag(self, key: str, *, default: bool) -> bool:
        """Return true or false."""
        value = self.values.get(key, default)
        if not isinstance(value, bool):
            raise self.fault(key, "true or false")
        return value

    def whole(self, key: str, low: int, high: int, default: int | None = None) -> int:
        """Return a whole number from `low` to `high`."""
        value = self.values.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise self.fault(key, f"a whole number from {low} to {high}")
        return value

    def optional_whole(self, key: str, low: int, high: int) -> int | None:
        """Return a whole number from `low` to `high`, or None where the key is absent."""
        return self.whole(key, low, high) if key in self.values else None

    def number(self, key: str, low: float, high: float, default: float | None = None) -> float:
        """Return a finite number from `low` to `high`."""
        value = self.values.get(key, default)
        fits = isinstance(value, int | float) and not isinstance(value, bool)
        if not fits or not math.isfinite(value) or not low <= value <= high:
            raise self.fault(key, f"a number from {low:g} to {high:g}")
        return float(value)

    def optional_number(self, key: str, low: float, high: float) -> float | None:
        """Return a number from `low` to `high`, or None where the key is absent."""
        return self.number(key, low, high) if key in self.values else None

    def texts(self, key: str, default: tuple[str, ...] | None = None) -> tuple[str, ...]:
        """Return a list of different texts."""
        if key not in self.values and default is not None:
            return default
        value = self.values.get(key)
        if not isinstance(value, list) or not all(_is_text(one) for one in value):
            raise self.fault(key, "a list of texts")
        if len(set(value)) < len(value):
            raise self.fault(key, "a list of texts that all differ")
        return tuple(value)

    def choice(self, key: str, known: Collection[str]) -> str:
        """Return one of the known words.

        Raises
        ------
        RelightlabError
            If the word is another, with the nearest known one.
        """
        value = self.text(key)
        if value not in known:
            raise unknown_name(f"{key} in {self.place}", value, known)
        return value

    def table(self, key: str, known: Collection[str]) -> TomlTable:
        """Return the table under a key, empty where it is absent."""
        return checked_table(self.values.get(key, {}), f"[{key}]", known)

    def tables(self, key: str, known: Collection[str]) -> tuple[TomlTable, ...]:
        """Return the list of tables under a key, empty where it is absent."""
        value = self.values.get(key, [])
        if not isinstance(value, list):
            raise self.fault(key, f"a list of tables, [[{key}]]")
        return tuple(
            checked_table(one, _place(key, number, one), known)
            for number, one in enumerate(value, 1)
        )


def checked_table(values: object, place: str, known: Collection[str]) -> TomlTable:
    """Return a table after a look at its keys.

    Parameters
    ----------
    values : object
        What the TOML reader gave.
    place : str
        What messages call the table.
    known : collection of str
        The keys it may have.

    Returns
    -------
    TomlTable

    Raises
    ------
    RelightlabError
        If it is not a table, or has a key that is not known.

    Examples
    --------
    >>> checked_table({"allow_ties": True}, "[trials]", ("question", "allow_tie"))
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: Unknown key in [trials] 'allow_ties'. Did you mean
    'allow_tie'? Available: question, allow_tie.
    """
    if not isinstance(values, Mapping):
        raise RelightlabError(f"expected {place} to be a table, got {_shown(values)}")
    for key in values:
        if key not in known:
            raise unknown_name(f"key in {place}", key, known)
    return TomlTable(values, place)


def _place(key: str, number: int, values: object) -> str:
    name = values.get("name") if isinstance(values, Mapping) else None
    return f"[[{key}]] {name if isinstance(name, str) and name else number}"


def _is_text(value: object) -> bool:
    return isinstance(value, str) and bool(value.strip()) and not CONTROL.search(value)


def _shown(value: object) -> str:
    words = {True: "true", False: "false"}[value] if isinstance(value, bool) else repr(value)
    return words if len(words) <= 60 else f"{words[:57]}..."
