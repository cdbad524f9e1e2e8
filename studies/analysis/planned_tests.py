"""The planned tests of a study, and how they may be worded.

In each family: every condition against chance; equivalence with chance; differences of conditions.
Of each subpopulation only its interaction is tested (or, with one condition, whether its levels
differ): that one level is significant and another is not says nothing about their difference. Side
and learning come last. Holm's correction is over tests of one kind within a family.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd

from shading_model.errors import RelightlabError
from studies.analysis.arms import comparisons
from studies.analysis.cell_means import (
    Difference,
    cell_means,
    contrast,
    paired_difference,
)
from studies.analysis.equivalence import chance_test, equivalence_test, holm
from studies.analysis.group_tests import group_test, interaction_test
from studies.analysis.intervals import cluster_interval
from studies.analysis.rates import Row, plain
from studies.analysis.subpopulations import half_of_session
from studies.study_records import AnalysisPlan

TEST_COLUMNS = (
    *("family", "kind", "task", "condition", "group", "test"),
    *("estimate", "low", "high", "p", "p_holm", "result"),
)
FEWEST_IN_LEVEL = 5
"""A level of fewer subjects is left out of the tests of its group."""
_NO_ESTIMATE = {"estimate": np.nan, "low": np.nan, "high": np.nan}
_WORDS = {
    "chance": ("differs from chance", "no difference from chance shown"),
    "equivalence": ("equivalent to chance", "equivalence not shown"),
    "difference": ("the conditions differ", "no difference shown"),
    "interaction": ("the groups differ", "no difference between groups shown"),
    "group": ("the groups differ", "no difference between groups shown"),
    "side": ("a side is preferred", "no preference of a side shown"),
    "learning": ("the halves differ", "no difference between halves shown"),
}


def planned_tests(
    trials: pd.DataFrame,
    groups: Mapping[str, pd.Series],
    plan: AnalysisPlan,
) -> list[Row]:
    """Return every planned test, corrected within its family.

    Parameters
    ----------
    trials : DataFrame
        Main trials of `studies.analysis.arms.with_arms`.
    groups : mapping of str to Series
        The level of every trial, with the index of `trials`.
    plan : AnalysisPlan
        Margin and level.

    Returns
    -------
    list of dict
        `TEST_COLUMNS`; None where there is no value: an F test has no interval.
    """
    rows: list[Row] = []
    for name, own in trials.groupby("family", sort=True):
        if own["subject"].nunique() < 2:
            continue
        rows.extend({"family": str(name), **row} for row in _of_family(own, groups, plan))
    return [plain(row) for row in _corrected(rows, plan.alpha)]


def _of_family(
    trials: pd.DataFrame, groups: Mapping[str, pd.Series], plan: AnalysisPlan
) -> Iterator[Row]:
    yield from _of_conditions(trials, plan)
    for _, own in comparisons(trials):
        for first, second in itertools.combinations(sorted(own["arm"].unique()), 2):
            yield _difference(own, first, second, plan.alpha)
        for group, levels in groups.items():
            yield from _interaction(own, group, levels.loc[own.index])
    for (task, condition), own in trials.groupby(["task", "condition"], sort=True):
        for group, levels in groups.items():
            yield from _of_group(str(task), str(condition), own, group, levels.loc[own.index])
        yield from _of_order(str(task), str(condition), own, plan.alpha)


def _of_conditions(trials: pd.DataFrame, plan: AnalysisPlan) -> Iterator[Row]:
    for (task, condition), own in trials.groupby(["task", "condition"], sort=True):
        outcome, subject = own["chose_target"].to_numpy(dtype=float), own["subject"].to_numpy()
        low, high = cluster_interval(outcome, subject, plan.alpha)
        names = {"task": str(task), "condition": str(condition), "group": ""}
        yield {
            **names,
            "kind": "chance",
            "test": f"{condition} differs from 50 %",
            "estimate": float(outcome.mean()),
            "low": low,
            "high": high,
            "p": chance_test(outcome, subject),
        }
        margin = plan.equivalence_margin
        found = equivalence_test(outcome, subject, margin=margin, alpha=plan.alpha)
        yield {
            **names,
            "kind": "equivalence",
            "test": f"{condition} is within {100 * margin:g} points of 50 %",
            "estimate": found.rate,
            "low": found.low,
            "high": found.high,
            "p": found.p,
        }


def _difference(trials: pd.DataFrame, first: str, second: str, alpha: float) -> Row:
    outcome, subject = trials["chose_target"], trials["subject"]
    found = paired_difference(outcome, trials["arm"], subject, (first, second), alpha)
    return {
        "task": _tasks(trials[trials["arm"].isin([first, second])]),
        "condition": f"{first} - {second}",
        "group": "",
        "kind": "difference",
        "test": f"{first} differs from {second}",
        **_estimate(found),
    }


def _interaction(trials: pd.DataFrame, group: str, levels: pd.Series) -> Iterator[Row]:
    known, level = _known(trials, levels)
    try:
        test = interaction_test(known["chose_target"], known["arm"], level, known["subject"])
    except RelightlabError:
        return
    conditions = ", ".join(sorted(known["arm"].unique()))
    words = f"the difference of conditions differs by {group}"
    names = {"task": _tasks(known), "condition": conditions, "group": group}
    yield {**names, "kind": "interaction", "test": words, **_NO_ESTIMATE, "p": test.p}


def _of_group(
    task: str, condition: str, own: pd.DataFrame, group: str, levels: pd.Series
) -> Iterator[Row]:
    known, level = _known(own, levels)
    try:
        test = group_test(known["chose_target"], level, known["subject"])
    except RelightlabError:
        return
    names = {"task": task, "condition": condition, "group": group}
    words = f"{condition} differs by {group}"
    yield {**names, "kind": "group", "test": words, **_NO_ESTIMATE, "p": test.p}


def _known(trials: pd.DataFrame, levels: pd.Series) -> tuple[pd.DataFrame, pd.Series]:
    """Trials of levels that enough subjects are of, to estimate their spread."""
    subjects = trials.groupby(levels.astype(object))["subject"].nunique()
    known = levels.isin(subjects.index[subjects >= FEWEST_IN_LEVEL])
    return trials[known.to_numpy()], levels[known].astype(str)


def _tasks(trials: pd.DataFrame) -> str:
    return ", ".join(sorted(trials["task"].unique()))


def _of_order(task: str, condition: str, own: pd.DataFrame, alpha: float) -> Iterator[Row]:
    """Side bias and learning are always shown, whether in the plan or not."""
    for kind, labels, words in (
        ("side", own["target_side"], f"{condition} more often on the left"),
        ("learning", half_of_session(own), f"{condition} more often in the first half"),
    ):
        known = own[labels.notna().to_numpy()]
        if labels.nunique() < 2 or known["subject"].nunique() < 2:
            continue
        means = cell_means(known["chose_target"], labels[labels.notna()], known["subject"])
        found = contrast(means, [1, -1], alpha)
        names = {"task": task, "condition": condition, "group": ""}
        yield {**names, "kind": kind, "test": words, **_estimate(found)}


def _estimate(found: Difference) -> Row:
    return {"estimate": found.difference, "low": found.low, "high": found.high, "p": found.p}


def _corrected(rows: list[Row], alpha: float) -> list[Row]:
    key = [(row["family"], row["kind"]) for row in rows]
    corrected = np.full(len(rows), np.nan)
    for own in dict.fromkeys(key):
        places = [place for place, other in enumerate(key) if other == own]
        corrected[places] = holm([rows[place]["p"] for place in places])
    return [
        {**row, "p_holm": float(p), "result": _result(row["kind"], float(p), alpha)}
        for row, p in zip(rows, corrected, strict=True)
    ]


def _result(kind: str, p: float, alpha: float) -> str:
    if not np.isfinite(p):
        return "cannot be tested"
    return _WORDS[kind][0 if p < alpha else 1]
