"""Which rates may be compared: those of conditions held against the same thing.

In one task several conditions may be mixed; or each has a task of its own, and the tasks are of one
family and hold their targets against the same pictures. Our rate against real pictures may be
compared with another method's against real pictures; our rate against one rival with that against
another is no comparison of methods.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import pandas as pd


def with_arms(
    trials: pd.DataFrame, families: Mapping[str, str], others: Mapping[str, str]
) -> pd.DataFrame:
    """Return the trials with columns ``family``, ``comparison`` and ``arm``.

    Parameters
    ----------
    trials : DataFrame
        Columns ``task`` and ``condition``.
    families : mapping of str to str
        The family of each task; by default its own.
    others : mapping of str to str
        What each task holds its target against. Tasks of a family of which it is not known may be
        compared.

    Returns
    -------
    DataFrame
        `arm` is the condition, with the task before it where several tasks of a comparison have
        conditions of that name; arms of one `comparison` may be compared.

    Examples
    --------
    >>> trials = pd.DataFrame({"task": ["a", "b", "c"], "condition": ["ours", "theirs", "ours"]})
    >>> found = with_arms(trials, dict.fromkeys("abc", "f"), {"a": "real", "b": "real", "c": "b"})
    >>> found["comparison"].tolist(), found["arm"].tolist()
    (['f against real', 'f against real', 'f against b'], ['ours', 'theirs', 'ours'])
    """
    task, condition = trials["task"].astype(str), trials["condition"].astype(str)
    family = task.map(lambda name: families.get(name, name))
    against = task.map(lambda name: f" against {others[name]}" if name in others else "")
    comparison = family + against
    several = task.groupby([comparison, condition]).transform("nunique") > 1
    arm = condition.where(~several, task + " " + condition)
    return trials.assign(family=family, comparison=comparison, arm=arm)


def comparisons(trials: pd.DataFrame) -> Iterator[tuple[str, pd.DataFrame]]:
    """Yield the name and the trials of every comparison of two arms or more.

    Parameters
    ----------
    trials : DataFrame
        Of `with_arms`.

    Yields
    ------
    name : str
        The arms.
    trials : DataFrame
    """
    for _, own in trials.groupby("comparison", sort=True):
        arms = sorted(own["arm"].unique())
        if len(arms) > 1:
            yield " and ".join(arms), own
