"""One row of the table of rates: how often the target was chosen, with every interval."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from shading_model.arrays import Mask
from shading_model.seeds import generator_for
from studies.analysis.cluster_bootstrap import bootstrap_rates
from studies.analysis.intervals import (
    cluster_interval,
    paper_mean,
    two_way_interval,
    wilson_interval,
)
from studies.analysis.subpopulations import EVERYBODY

Row = dict[str, Any]

RATE_COLUMNS = (
    "task",
    "condition",
    "group",
    "level",
    "trials",
    "subjects",
    "rate",
    "wilson_low",
    "wilson_high",
    "cluster_low",
    "cluster_high",
    "twoway_low",
    "twoway_high",
)
"""The columns of a table of rates, in order."""
DEVIATION_COLUMNS = (
    *("task", "condition", "group", "level"),
    *("mean", "deviation", "bootstrap_low", "bootstrap_high"),
)
"""The columns of the paper's own mean and deviation, and of the bootstrap by subjects."""


def rate_row(
    task: str, condition: str, group: str, level: str, trials: pd.DataFrame, alpha: float = 0.05
) -> Row:
    """Return the rate of some trials with its intervals, and the paper's mean and deviation.

    Parameters
    ----------
    task, condition, group, level : str
        What the row is of.
    trials : DataFrame
        Columns ``subject``, ``pair`` and ``chose_target`` without NaN.
    alpha : float
        Intervals cover 1 - alpha.

    Returns
    -------
    dict
        The keys of `RATE_COLUMNS`, ``mean`` and ``deviation``; None where there is no value.

    Examples
    --------
    >>> trials = pd.DataFrame({"subject": ["a", "a", "b"], "pair": ["1", "2", "1"],
    ...                        "chose_target": [1.0, 0.0, 1.0]})
    >>> row = rate_row("real", "ours", "all", "all", trials)
    >>> row["trials"], row["subjects"], round(row["rate"], 3), row["mean"]
    (3, 2, 0.667, 0.75)
    """
    outcome, subject = trials["chose_target"].to_numpy(dtype=float), trials["subject"].to_numpy()
    paper = paper_mean(outcome, subject)
    row: Row = {
        "task": task,
        "condition": condition,
        "group": group,
        "level": level,
        "trials": len(trials),
        "subjects": int(trials["subject"].nunique()),
        "rate": float(outcome.mean()) if len(outcome) else math.nan,
    }
    found = {
        "wilson": wilson_interval(float(outcome.sum()), len(outcome), alpha),
        "cluster": cluster_interval(outcome, subject, alpha),
        "twoway": two_way_interval(outcome, subject, trials["pair"].to_numpy(), alpha),
    }
    for name, interval in found.items():
        row |= {f"{name}_low": interval.low, f"{name}_high": interval.high}
    return plain(row | paper._asdict())


def rate_rows(trials: pd.DataFrame, groups: Mapping[str, pd.Series], alpha: float) -> Iterator[Row]:
    """Yield the rates of every task and condition: everybody's, then each level of each group.

    Parameters
    ----------
    trials : DataFrame
        Main trials: columns ``task, condition, subject, pair, chose_target``.
    groups : mapping of str to categorical Series
        The level of every trial, with the index of `trials`; NaN where it is not known.
    alpha : float

    Yields
    ------
    dict
        As `rate_row` gives them, and ``bootstrap_low, bootstrap_high``: percentiles of the rates of
        subjects drawn with replacement, the same draws for all levels. A level that nobody is of
        has no row.
    """
    for (task, condition), own in trials.groupby(["task", "condition"], sort=True):
        names = (str(task), str(condition))
        sets = _sets(own, groups)
        drawn = bootstrap_rates(
            own["chose_target"],
            own["subject"].to_numpy(),
            np.column_stack([members for _, _, members in sets]),
            generator_for("cluster bootstrap", *names),
            alpha=alpha,
        )
        ends = zip(drawn.low.tolist(), drawn.high.tolist(), strict=True)
        for (group, level, members), (low, high) in zip(sets, ends, strict=True):
            row = rate_row(*names, group, level, own[members], alpha)
            yield plain(row | {"bootstrap_low": low, "bootstrap_high": high})


def _sets(own: pd.DataFrame, groups: Mapping[str, pd.Series]) -> list[tuple[str, str, Mask]]:
    sets: list[tuple[str, str, Mask]] = [(EVERYBODY, EVERYBODY, np.ones(len(own), dtype=bool))]
    for group, levels in groups.items():
        places, categories = levels.loc[own.index].cat.codes.to_numpy(), levels.cat.categories
        sets += [(group, str(level), places == k) for k, level in enumerate(categories)]
    return [(group, level, members) for group, level, members in sets if members.any()]


def plain(row: Mapping[str, Any]) -> Row:
    """Return a row with None for values that are not finite, ready for JSON.

    Parameters
    ----------
    row : mapping

    Returns
    -------
    dict

    Examples
    --------
    >>> plain({"rate": float("nan"), "trials": 3})
    {'rate': None, 'trials': 3}
    """
    return {
        key: None if isinstance(value, float) and not math.isfinite(value) else value
        for key, value in row.items()
    }
