"""The results document of a study: plain values that JSON takes, and the tables are made of.

``title, source``
    What was analysed.
``mark, simulated``
    Empty, or ``PILOT``, ``SIMULATED`` or both with a comma between; whether any answer was made up.
``started``
    ``subjects`` and ``trials`` before anything was left out.
``rates``
    Rows with the keys `studies.analysis.rates.RATE_COLUMNS`; shares from 0 to 1, None where there
    is none. ``rates_with_everyone`` are those before exclusions.
``deviations``
    The paper's own mean and deviation for the same rows, ``mean`` and ``deviation``.
``models``
    Rows ``model, term, estimate, se``, in log-odds; ``notes`` are sentences about them.
``tests``
    Planned tests, `studies.analysis.planned_tests.TEST_COLUMNS`.
``exclusions``
    Rows ``reason, subjects, trials, remaining_subjects, remaining_trials``, in order;
    ``excluded`` has a row for each subject.
``published, consistency, disagreements``
    The paper's rates, whether their printed deviations can be, and where they disagree.
``table3, figures``
    Which conditions belong in Table 3 and in each forest plot.
``provenance``
    Facts by name.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

MARKED_MODES = ("simulated", "pilot")


def mark_of_modes(modes: Iterable[object]) -> str:
    """Return the mark that answers of these modes must carry.

    Parameters
    ----------
    modes : iterable
        Words such as ``live``, ``pilot`` and ``simulated``.

    Returns
    -------
    str
        Empty for answers that people gave to the study itself.

    Examples
    --------
    >>> mark_of_modes({"live", "pilot", "simulated"}), mark_of_modes({"live"})
    ('SIMULATED, PILOT', '')
    """
    given = set(modes)
    return ", ".join(mode.upper() for mode in MARKED_MODES if mode in given)


def plain_value(value: Any) -> Any:
    """Return results as JSON takes them: NumPy's numbers as Python's, NaN as None.

    Parameters
    ----------
    value : object
        Mappings and sequences are gone through.

    Returns
    -------
    object

    Examples
    --------
    >>> plain_value({"rate": float("nan"), "levels": ("a", "b")})
    {'rate': None, 'levels': ['a', 'b']}
    """
    if isinstance(value, Mapping):
        return {str(key): plain_value(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain_value(part) for part in value]
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def chosen_keys(rows: Iterable[Mapping[str, Any]], keys: Iterable[str]) -> list[dict[str, Any]]:
    """Return rows with these keys alone, in this order.

    Parameters
    ----------
    rows : iterable of mappings
    keys : iterable of str

    Returns
    -------
    list of dict

    Examples
    --------
    >>> chosen_keys([{"a": 1, "b": 2}], ["b"])
    [{'b': 2}]
    """
    wanted = tuple(keys)
    return [{key: row[key] for key in wanted} for row in rows]
