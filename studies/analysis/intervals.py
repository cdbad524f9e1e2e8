"""Intervals for a rate: of single trials, of subjects, and of subjects and scenes together.

Answers of one subject are alike, and so are answers to one scene. Wilson's interval takes every
trial for itself and belongs beside a count; the interval by subjects says what other subjects
would choose between these very scenes; the two-way interval what they would choose between scenes
like these.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.stats import t as student
from statsmodels.stats.proportion import proportion_confint

from shading_model.arrays import Float
from shading_model.errors import RelightlabError

FEWEST_CLUSTERS = 2


class Interval(NamedTuple):
    """Bounds of an interval; NaN where it cannot be had."""

    low: float
    high: float


class MeanDeviation(NamedTuple):
    """What the paper prints: a mean, and the standard deviation of that mean."""

    mean: float
    deviation: float


def wilson_interval(successes: float, trials: float, alpha: float = 0.05) -> Interval:
    """Return Wilson's score interval for a share of trials taken to be independent.

    Parameters
    ----------
    successes : float
        A tie counts half.
    trials : float
    alpha : float
        One minus the coverage.

    Returns
    -------
    Interval
        NaN where there are no trials.

    Examples
    --------
    >>> low, high = wilson_interval(458, 1040)
    >>> round(low, 4), round(high, 4)
    (0.4105, 0.4707)
    """
    if trials == 0:
        return Interval(np.nan, np.nan)
    low, high = proportion_confint(successes, trials, alpha, method="wilson")
    return Interval(max(0.0, float(low)), min(1.0, float(high)))


def cluster_interval(outcome: ArrayLike, subject: ArrayLike, alpha: float = 0.05) -> Interval:
    """Return the interval of a rate that is robust to likeness within subjects.

    Student's t with G - 1 degrees of freedom for G subjects, about the mean over trials, cut to
    0..1. Where no subject differs from another, nothing can be learned about their spread, and the
    interval is Wilson's with each subject counted as one trial.

    Parameters
    ----------
    outcome : (n,) array
        From 0 to 1.
    subject : (n,) array
        Labels.
    alpha : float

    Returns
    -------
    Interval
        NaN with fewer than two subjects.

    Examples
    --------
    >>> low, high = cluster_interval([1, 1, 0, 0, 1, 0], ["a", "a", "b", "b", "c", "c"])
    >>> round(low, 3), round(high, 3)
    (0.0, 1.0)
    """
    values, codes, _ = _checked(outcome, subject)
    return _interval(values, cluster_variance(values, codes), _count(codes), alpha)


def two_way_interval(
    outcome: ArrayLike, subject: ArrayLike, item: ArrayLike, alpha: float = 0.05
) -> Interval:
    """Return the interval of a rate that is robust to likeness within subjects and within items.

    Student's t with one degree of freedom less than the smaller number of subjects or items, cut to
    0..1; Wilson's with as many trials where no variance is left.

    Parameters
    ----------
    outcome : (n,) array
        From 0 to 1.
    subject, item : (n,) arrays
        Labels.
    alpha : float

    Returns
    -------
    Interval
        NaN with fewer than two subjects or items.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> chosen = rng.random(200) < 0.7
    >>> low, high = two_way_interval(chosen, np.repeat(range(20), 10), np.tile(range(10), 20))
    >>> bool(low < chosen.mean() < high)
    True
    """
    values, codes, items = _checked(outcome, subject, item)
    fewest = min(_count(codes), _count(items))
    return _interval(values, two_way_variance(values, codes, items), fewest, alpha)


def paper_mean(outcome: ArrayLike, subject: ArrayLike) -> MeanDeviation:
    """Return the mean of the subjects' own rates and its standard deviation, as the paper has them.

    The deviation is that of the subjects' rates over the root of their number. It may be printed
    beside the paper's; it takes the scenes as given, and subjects as equals.

    Parameters
    ----------
    outcome : (n,) array
    subject : (n,) array

    Returns
    -------
    MeanDeviation
        NaN as the deviation of one subject.

    Examples
    --------
    >>> paper_mean([1, 1, 0, 0, 1, 0], ["a", "a", "b", "b", "c", "c"])
    MeanDeviation(mean=0.5, deviation=0.288...)
    """
    values, codes, _ = _checked(outcome, subject)
    if not values.size:
        return MeanDeviation(np.nan, np.nan)
    rates = np.bincount(codes, values) / np.bincount(codes)
    spread = rates.std(ddof=1) / np.sqrt(len(rates)) if len(rates) > 1 else np.nan
    return MeanDeviation(float(rates.mean()), float(spread))


def cluster_variance(outcome: ArrayLike, cluster: ArrayLike) -> float:
    """Return the sandwich variance of a mean over trials, clusters being independent.

    Parameters
    ----------
    outcome : (n,) array
    cluster : (n,) array

    Returns
    -------
    float
        With the factor G / (G - 1); NaN with fewer than two clusters.

    Examples
    --------
    >>> round(cluster_variance([1, 1, 0, 0], [0, 0, 1, 1]), 12)
    0.25
    """
    values, codes, _ = _checked(outcome, cluster)
    return _sandwich(values - values.mean(), codes) if values.size else np.nan


def two_way_variance(outcome: ArrayLike, subject: ArrayLike, item: ArrayLike) -> float:
    """Return the variance of a mean with subjects and items both drawn.

    That by subjects, plus that by items, less that by their combinations, each with its own factor
    G / (G - 1) (Cameron, Gelbach and Miller). It is not taken below the larger of the first two: in
    small samples the difference may be, even less than zero.

    Parameters
    ----------
    outcome : (n,) array
    subject, item : (n,) arrays

    Returns
    -------
    float
        NaN with fewer than two subjects or items.
    """
    values, codes, items = _checked(outcome, subject, item)
    if not values.size:
        return np.nan
    residual = values - values.mean()
    both = pd.factorize(codes * np.intp(items.max() + 1) + items)[0]
    by_subject, by_item = _sandwich(residual, codes), _sandwich(residual, items)
    total = by_subject + by_item - _sandwich(residual, both)
    return float(np.maximum(total, np.maximum(by_subject, by_item)))


def _checked(
    outcome: ArrayLike, subject: ArrayLike, item: ArrayLike | None = None
) -> tuple[Float, NDArray[np.intp], NDArray[np.intp]]:
    values = np.asarray(outcome, dtype=float)
    labels = [np.asarray(subject), np.asarray(subject if item is None else item)]
    if any(each.shape != values.shape for each in labels) or values.ndim != 1:
        raise RelightlabError(
            f"expected a label for each of {values.size} outcomes, got {labels[0].size}"
        )
    if not ((values >= 0) & (values <= 1)).all():
        raise RelightlabError("expected outcomes from 0 to 1 without NaN")
    codes = [pd.factorize(each)[0].astype(np.intp) for each in labels]
    if any((code < 0).any() for code in codes):
        raise RelightlabError("expected a subject and an item for every outcome, got a missing one")
    return values, codes[0], codes[1]


def _count(codes: NDArray[np.intp]) -> int:
    return int(codes.max()) + 1 if codes.size else 0


def _sandwich(residual: Float, codes: NDArray[np.intp]) -> float:
    groups = _count(codes)
    if groups < FEWEST_CLUSTERS:
        return np.nan
    sums = np.bincount(codes, residual)
    return float(groups / (groups - 1) * (sums @ sums) / len(residual) ** 2)


def _interval(values: Float, variance: float, groups: int, alpha: float) -> Interval:
    if groups < FEWEST_CLUSTERS or not np.isfinite(variance):
        return Interval(np.nan, np.nan)
    mean = float(values.mean())
    if variance < 1e-15:
        return wilson_interval(mean * groups, groups, alpha)
    reach = float(student.isf(alpha / 2, groups - 1)) * np.sqrt(variance)
    return Interval(max(0.0, float(mean - reach)), min(1.0, float(mean + reach)))
