"""The results of a study as the command line prints them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from reports.study_words import condition_words, counted, interval, level_words, percent

COLUMNS = ("condition", "subpopulation", "trials", "subjects", "%", "Wilson", "by subject", "items")


def rate_lines(document: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the rates as lines of a table, an empty line between two conditions.

    Parameters
    ----------
    document : mapping
        See `reports.study_results`.

    Returns
    -------
    list of tuple of str
        Of `COLUMNS`; ``items`` is the interval for subjects and items.
    """
    lines: list[tuple[str, ...]] = []
    for row in document["rates"]:
        words = condition_words(row["task"], row["condition"])
        if lines and lines[-1][0] != words:
            lines.append(())
        lines.append(
            (
                words,
                level_words(row["group"], row["level"]),
                str(row["trials"]),
                str(row["subjects"]),
                percent(row["rate"]),
                *(
                    interval(row[f"{name}_low"], row[f"{name}_high"])
                    for name in ("wilson", "cluster", "twoway")
                ),
            )
        )
    return lines


def summary_lines(document: Mapping[str, Any]) -> list[str]:
    """Return how many were left out and why, and the mark of the data.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    list of str

    Examples
    --------
    >>> step = {"reason": "did not finish", "subjects": 2, "trials": 7}
    >>> started = {"subjects": 30, "trials": 287}
    >>> summary_lines({"mark": "PILOT", "started": started, "exclusions": [step]})
    ['30 subjects started, with 287 trials', 'left out: 2 subjects, 7 trials: did not finish',
     'PILOT DATA: not the result of a study']
    """
    started = document["started"]
    people, answers = counted(started["subjects"], "subject"), counted(started["trials"], "trial")
    lines = [f"{people} started, with {answers}"]
    lines += [
        f"left out: {counted(step['subjects'], 'subject')}, {counted(step['trials'], 'trial')}:"
        f" {step['reason']}"
        for step in document["exclusions"]
        if step["subjects"] or step["trials"]
    ]
    mark = document["mark"]
    return lines + ([f"{mark} DATA: not the result of a study"] if mark else [])
