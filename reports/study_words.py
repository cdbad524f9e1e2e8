"""Words and numbers of a study's report: what a row is called, and how its values are written."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, TypeAlias

Row: TypeAlias = Mapping[str, Any]
"""A row of results: plain values, None where there is none."""

NOTHING = "–"  # noqa: RUF001  an en dash: no value
SMALLEST_P = 0.001
EVERYBODY = "all"
GROUPS = {
    "all": "everybody",
    "expertise": "expertise",
    "tests": "perspective-shading tests",
    "gender": "gender",
    "age": "age",
    "half": "half of the session",
    "side": "side of the own picture",
}
"""Names of groups that their column alone does not say."""


def condition_words(task: str, condition: str) -> str:
    """Return what a condition of a task is called: its task says it where it begins with it.

    Parameters
    ----------
    task, condition : str

    Returns
    -------
    str

    Examples
    --------
    >>> condition_words("ours-karsch", "ours"), condition_words("real", "ours")
    ('ours-karsch', 'real: ours')
    """
    said = task.startswith(condition)
    return task if said else f"{task}: {condition}" if task else condition


def level_words(group: str, level: str) -> str:
    """Return what a level of a group is called.

    Parameters
    ----------
    group, level : str

    Returns
    -------
    str

    Examples
    --------
    >>> level_words("all", "all"), level_words("checked", "yes"), level_words("gender", "male")
    ('all', 'checked: yes', 'male')
    """
    if group == "side":
        return f"target on the {level}"
    plain = group in GROUPS or level.startswith(group)
    return level if plain else f"{group}: {level}"


def number_or_nan(value: Any) -> float:
    """Return a value as a number, NaN for None.

    Parameters
    ----------
    value : object

    Returns
    -------
    float

    Examples
    --------
    >>> number_or_nan(None)
    nan
    """
    return math.nan if value is None else float(value)


def counted(count: int, word: str) -> str:
    """Return a count with its noun, which takes an s for more than one.

    Parameters
    ----------
    count : int
    word : str

    Returns
    -------
    str

    Examples
    --------
    >>> counted(1, "subject"), counted(0, "trial")
    ('1 subject', '0 trials')
    """
    return f"{count} {word}" if count == 1 else f"{count} {word}s"


def percent(value: Any, digits: int = 1) -> str:
    """Return a share in percent, without its sign, a dash where there is none.

    Parameters
    ----------
    value : float or None
    digits : int

    Returns
    -------
    str

    Examples
    --------
    >>> percent(0.4404), percent(None)
    ('44.0', '–')
    """
    number = number_or_nan(value)
    return decimal(100 * number, digits)


def interval(low: Any, high: Any, digits: int = 1) -> str:
    """Return an interval of shares in percent, a dash where an end is missing.

    Parameters
    ----------
    low, high : float or None
    digits : int

    Returns
    -------
    str

    Examples
    --------
    >>> interval(-0.014, 0.47), interval(None, 0.5)
    ('−1.4 to 47.0', '–')
    """
    ends = [percent(end, digits) for end in (low, high)]
    return NOTHING if NOTHING in ends else " to ".join(ends)


def decimal(value: Any, digits: int = 3) -> str:
    """Return a number with fixed digits and a proper minus, a dash where there is none.

    Parameters
    ----------
    value : float or None
    digits : int

    Returns
    -------
    str

    Examples
    --------
    >>> decimal(-0.06391), decimal(None)
    ('−0.064', '–')
    """
    number = number_or_nan(value)
    if not math.isfinite(number):
        return NOTHING
    return f"{number:.{digits}f}".replace("-", "−")  # noqa: RUF001  a minus


def probability(value: Any) -> str:
    """Return a p-value: three digits, and no value below what they show.

    Parameters
    ----------
    value : float or None

    Returns
    -------
    str

    Examples
    --------
    >>> probability(0.0412), probability(1e-9), probability(None)
    ('0.041', '< 0.001', '–')
    """
    number = number_or_nan(value)
    return f"< {SMALLEST_P}" if number < SMALLEST_P else decimal(number)
