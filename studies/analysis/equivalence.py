"""Equivalence to chance, and corrections for testing several things.

That a rate does not differ significantly from 50 % is no evidence that it is 50 %: too few subjects
have the same effect. Two one-sided tests against a margin set beforehand ask the right question.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import t as student

from shading_model.errors import RelightlabError
from studies.analysis.intervals import (
    FEWEST_CLUSTERS,
    cluster_variance,
    two_way_variance,
)


class Equivalence(NamedTuple):
    """Two one-sided tests of a rate against chance plus and minus a margin.

    `p` is the larger of the two; `low` and `high` bound the interval of 1 - 2 alpha, which lies
    within the margins exactly where `equivalent`.
    """

    rate: float
    low: float
    high: float
    p: float
    equivalent: bool


def equivalence_test(
    outcome: ArrayLike,
    subject: ArrayLike,
    item: ArrayLike | None = None,
    *,
    margin: float,
    chance: float = 0.5,
    alpha: float = 0.05,
) -> Equivalence:
    """Test whether a rate is within a margin of chance, robust to likeness within subjects.

    Parameters
    ----------
    outcome : (n,) array
    subject : (n,) array
    item : (n,) array, optional
        Also robust to likeness within items, if given.
    margin : float
        Set before the answers were seen: 0.05 for 45 to 55 %.
    chance : float
    alpha : float

    Returns
    -------
    Equivalence
        NaN, and not equivalent, with fewer than two subjects or items.

    Raises
    ------
    RelightlabError
        If the margin is not between 0 and 0.5.

    Examples
    --------
    >>> rng = np.random.default_rng(4)
    >>> chosen, subject = rng.random(4000) < 0.5, np.repeat(np.arange(400), 10)
    >>> equivalence_test(chosen, subject, margin=0.05).equivalent
    True
    >>> equivalence_test(chosen[:200], subject[:200], margin=0.05).equivalent
    False
    """
    if not 0 < margin < 0.5:
        raise RelightlabError(f"expected an equivalence margin between 0 and 0.5, got {margin}")
    values = np.asarray(outcome, dtype=float)
    labels = [np.asarray(subject)] + ([] if item is None else [np.asarray(item)])
    groups = min(len(np.unique(each)) for each in labels)
    rate = float(values.mean()) if values.size else np.nan
    if groups < FEWEST_CLUSTERS:
        return Equivalence(rate, np.nan, np.nan, np.nan, False)
    variance = (
        cluster_variance(values, labels[0])
        if item is None
        else two_way_variance(values, labels[0], labels[1])
    )
    return _tested(
        rate, float(np.sqrt(variance)), groups - 1, (chance - margin, chance + margin), alpha
    )


def _tested(
    rate: float, error: float, freedom: int, margins: tuple[float, float], alpha: float
) -> Equivalence:
    if error < 1e-9:
        return Equivalence(rate, np.nan, np.nan, np.nan, False)
    above = student.sf((rate - margins[0]) / error, freedom)
    below = student.sf((margins[1] - rate) / error, freedom)
    p = float(max(above, below))
    reach = float(student.isf(alpha, freedom)) * error
    return Equivalence(rate, rate - reach, rate + reach, p, p < alpha)


def chance_test(outcome: ArrayLike, subject: ArrayLike, chance: float = 0.5) -> float:
    """Return the two-sided p of a rate against chance, t with one less than the subjects.

    Parameters
    ----------
    outcome : (n,) array
    subject : (n,) array
    chance : float

    Returns
    -------
    float
        NaN with fewer than two subjects, or where no subject differs from another.

    Examples
    --------
    >>> chance_test([1, 1, 1, 0, 1, 1], ["a", "a", "b", "b", "c", "c"]) < 0.2
    True
    """
    values = np.asarray(outcome, dtype=float)
    groups = len(np.unique(np.asarray(subject)))
    error = float(np.sqrt(cluster_variance(values, subject))) if groups > 1 else np.nan
    if not error > 1e-9:
        return np.nan
    return float(2 * student.sf(abs(values.mean() - chance) / error, groups - 1))


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p-values corrected for their family by Holm's steps; NaN stays and does not count.

    statsmodels has the same, but collects all garbage of the process at each call.

    Parameters
    ----------
    p_values : sequence of float

    Returns
    -------
    list of float

    Examples
    --------
    >>> [round(p, 6) for p in holm([0.01, 0.04, 0.03, float("nan")])]
    [0.03, 0.06, 0.06, nan]
    """
    values = np.array(p_values, dtype=float)
    known = np.flatnonzero(np.isfinite(values))
    order = known[np.argsort(values[known], kind="stable")]
    steps = np.arange(len(order), 0, -1) * values[order]
    values[order] = np.minimum(1.0, np.maximum.accumulate(steps)) if len(order) else steps
    corrected: list[float] = values.tolist()
    return corrected
