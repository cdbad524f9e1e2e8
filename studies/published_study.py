"""The paper's user study as it was printed, and what its numbers say about each other.

Rates and deviations are shares, as printed to 0.1 %. The paper calls the deviation of a cell its
"mean standard deviation"; for 1040 trials at 44 % it prints 1.5 %, the standard error of a share of
1040 independent trials. What the answers of a subject have in common makes the error of a mean
larger than that, hardly ever smaller: a deviation below the binomial one asks for an explanation.
"""

from __future__ import annotations

import math
from typing import Any

Row = dict[str, Any]

ROUNDING = 0.0005
"""Half of the last digit printed."""
TABLE3 = "tab:study_vs_real"

_LEVELS = (
    ("all", "all", 1040, 0.440, 0.015, 0.418, 0.016),
    ("expertise", "expert", 200, 0.435, 0.034, 0.362, 0.037),
    ("expertise", "non-expert", 840, 0.442, 0.017, 0.429, 0.018),
    ("tests", "passed p-s test", 740, 0.442, 0.018, 0.405, 0.021),
    ("tests", "failed p-s test", 300, 0.437, 0.027, 0.439, 0.025),
    ("gender", "male", 680, 0.447, 0.019, 0.426, 0.018),
    ("gender", "female", 360, 0.428, 0.024, 0.390, 0.035),
    ("age", "age ≤ 25", 380, 0.432, 0.025, 0.417, 0.025),
    ("age", "age > 25", 660, 0.445, 0.019, 0.419, 0.020),
    ("half", "1st half", 520, 0.456, 0.022, 0.430, 0.023),
    ("half", "2nd half", 520, 0.425, 0.020, 0.418, 0.021),
)
_FIGURES = (
    ("ours-barron-malik", "ours", "all", "all", 1000, 0.60, "fig:study_vs_barron_karsch"),
    ("ours-barron-malik", "ours", "expertise", "expert", None, 0.66, "fig:study_vs_barron_karsch"),
    ("ours-karsch", "ours", "all", "all", 1840, None, "fig:study_vs_barron_karsch"),
    ("one-layer-none", "one-layer", "all", "all", 764, 0.61, "fig:controlled_details"),
    ("two-layers-one", "two-layers", "all", "all", 756, 0.65, "fig:controlled_details"),
)
_FAMILIES = {
    "ours-real": "against-real",
    "barron-malik-real": "against-real",
    "ours-barron-malik": "against-others",
    "ours-karsch": "against-others",
    "one-layer-none": "detail-layers",
    "two-layers-one": "detail-layers",
}
_SUBJECTS_USED = 294
_PAIRS_PER_SUBJECT = 10


def _row(
    task: str,
    condition: str,
    group: str,
    level: str,
    trials: int | None,
    rate: float | None,
    deviation: float | None,
    source: str,
) -> Row:
    return {
        "family": _FAMILIES[task],
        "task": task,
        "condition": condition,
        "group": group,
        "level": level,
        "trials": trials,
        "rate": rate,
        "deviation": deviation,
        "source": source,
    }


PUBLISHED: tuple[Row, ...] = (
    *(
        _row("ours-real", "ours", group, level, trials, rate, deviation, TABLE3)
        for group, level, trials, rate, deviation, _, _ in _LEVELS
    ),
    *(
        _row("barron-malik-real", "barron-malik", group, level, trials, rate, deviation, TABLE3)
        for group, level, trials, _, _, rate, deviation in _LEVELS
    ),
    *(
        _row(task, condition, group, level, trials, rate, None, source)
        for task, condition, group, level, trials, rate, source in _FIGURES
    ),
)
"""The printed rates, ``family, task, condition, group, level, trials, rate, deviation, source``.

The one column of trials of Table 3 stands for both methods. What is not printed is None.
"""


def consistency() -> list[Row]:
    """Return each printed deviation of Table 3 beside the binomial standard error of its rate.

    Returns
    -------
    list of dict
        ``task, condition, group, level, trials, rate, deviation, binomial, below, finding``;
        `below` where no number that rounds to the one printed reaches the smallest error that the
        printed rate allows. For the other method, trials are taken to be as many as ours.

    Examples
    --------
    >>> [(row["condition"], row["level"]) for row in consistency() if row["below"]][:3]
    [('ours', 'expert'), ('ours', 'failed p-s test'), ('ours', 'female')]
    """
    return [_checked(row) for row in PUBLISHED if row["deviation"] is not None]


def _checked(row: Row) -> Row:
    names = ("task", "condition", "group", "level", "trials", "rate", "deviation")
    rate, trials = row["rate"], row["trials"]
    binomial = binomial_error(rate, trials)
    farthest = rate - ROUNDING if rate < 0.5 else rate + ROUNDING
    below = row["deviation"] + ROUNDING < binomial_error(farthest, trials)
    ratio = row["deviation"] / binomial
    share = f"{ratio:.2f} of the binomial error"
    finding = f"below: {share}" if below else share
    return {
        **{name: row[name] for name in names},
        "binomial": binomial,
        "below": below,
        "finding": finding,
    }


def binomial_error(rate: float, trials: int) -> float:
    """Return the standard error of a share of independent trials.

    Parameters
    ----------
    rate : float
    trials : int

    Returns
    -------
    float

    Examples
    --------
    >>> round(binomial_error(0.44, 1040), 4)
    0.0154
    """
    return math.sqrt(rate * (1 - rate) / trials)


def disagreements() -> list[str]:
    """Return, as sentences, where the printed numbers disagree with each other.

    Returns
    -------
    list of str

    Examples
    --------
    >>> print(disagreements()[0])
    barron-malik by half: 43.0 % and 41.8 % of equally many trials make 42.4 %, printed is 41.8 %.
    """
    used = _SUBJECTS_USED * _PAIRS_PER_SUBJECT
    printed = {row["task"]: row["trials"] for row in PUBLISHED if row["group"] == "all"}
    printed.pop("barron-malik-real")
    total = sum(printed.values())
    odd = [str(count) for count in printed.values() if count % _PAIRS_PER_SUBJECT]
    too_many = (
        f"{_SUBJECTS_USED} usable studies of {_PAIRS_PER_SUBJECT} pairs make {used} trials; those"
        f" printed, without the other method's against real, sum to {total}."
    )
    broken = (
        f"{' and '.join(odd)} trials are no multiple of the {_PAIRS_PER_SUBJECT} pairs that each"
        " subject saw."
    )
    ages = "The text parts ages at <25 and ≥25, Table 3 at ≤25 and >25."
    return [*_means_of_levels(), too_many, broken, ages]


def _means_of_levels() -> list[str]:
    """Groups whose levels, weighted by the printed trials, do not make the printed whole.

    The trials printed are taken for the other method too only where the design fixes them: halves.
    """
    found = []
    for condition in ("ours", "barron-malik"):
        rows = [row for row in PUBLISHED if row["source"] == TABLE3]
        own = [row for row in rows if row["condition"] == condition]
        for group in dict.fromkeys(row["group"] for row in own[1:]):
            levels = [row for row in own if row["group"] == group]
            if condition != "ours" and group != "half":
                continue
            total = sum(row["trials"] for row in levels)
            mean = sum(row["rate"] * row["trials"] for row in levels) / total
            if abs(mean - own[0]["rate"]) > 2 * ROUNDING + 1e-9:
                parts = " and ".join(f"{100 * row['rate']:.1f} %" for row in levels)
                found.append(
                    f"{condition} by {group}: {parts} of equally many trials make"
                    f" {100 * mean:.1f} %, printed is {100 * own[0]['rate']:.1f} %."
                )
    return found
