"""Statistics of methods measured on the same objects: intervals, wins and rank tests."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import friedmanchisquare, wilcoxon
from statsmodels.stats.multitest import multipletests

from shading_model.arrays import Float

DRAWS = 10_000
LEVEL = 0.95
FEWEST_DRAWN = 2
"""Fewer objects, drawn with replacement, do not differ."""
FEWEST_OBJECTS, FEWEST_METHODS = 3, 3
"""Friedman's test says nothing about less."""


@dataclass(frozen=True, eq=False)
class PairedMeans:
    """Means of methods over objects, with bootstrap intervals that share the drawn objects.

    Parameters
    ----------
    mean, low, high : (m,) arrays
        Of each method.
    difference, difference_low, difference_high : (m,) arrays
        Of each method minus the reference.
    """

    mean: Float
    low: Float
    high: Float
    difference: Float
    difference_low: Float
    difference_high: Float


def paired_means(
    values: Float, reference: int | None, generator: np.random.Generator, draws: int = DRAWS
) -> PairedMeans:
    """Return means over objects and percentile intervals at 95 %, objects drawn with replacement.

    The same objects are drawn for every method, so an interval of a difference is that of the
    paired differences. Time and memory grow with draws times methods and objects.

    Parameters
    ----------
    values : (objects, m) array
        Objects with a NaN are left out, but for methods that are NaN on all of them.
    reference : int or None
        Index of the method that differences are taken to; None for NaN in their place.
    generator : numpy.random.Generator
    draws : int

    Returns
    -------
    PairedMeans
        NaN where no object is whole, and for methods without a value; intervals of fewer than two
        objects are NaN.

    Examples
    --------
    >>> found = paired_means(np.array([[1.0, 2.0], [3.0, 4.0]]), 0, np.random.default_rng(0))
    >>> found.mean, found.difference_low
    (array([2., 3.]), array([0., 1.]))
    """
    whole = _whole(values)
    count = len(whole)
    unknown = np.full(values.shape[1], np.nan)
    mean = whole.mean(axis=0) if count else unknown
    difference = mean - (np.nan if reference is None else mean[reference])
    if count < FEWEST_DRAWN:
        return PairedMeans(mean, unknown, unknown, difference, unknown, unknown)
    shares = generator.multinomial(count, np.full(count, 1 / count), size=draws) / count
    means = shares @ whole
    low, high = _interval(means)
    apart = means - (np.nan if reference is None else means[:, [reference]])
    return PairedMeans(mean, low, high, difference, *_interval(apart))


def friedman_test(values: Float) -> dict[str, float] | None:
    """Return Friedman's statistic and p-value for methods that all do alike.

    Parameters
    ----------
    values : (objects, m) array
        Methods that are NaN on all objects are left out, then objects with a NaN.

    Returns
    -------
    dict of float or None
        ``statistic, p, objects, methods``; None for fewer than three objects or methods.

    Examples
    --------
    >>> ranked = np.arange(12.0).reshape(4, 3)
    >>> round(friedman_test(ranked)["statistic"], 6)
    8.0
    """
    whole = _whole(values[:, np.isfinite(values).any(axis=0)])
    if len(whole) < FEWEST_OBJECTS or whole.shape[1] < FEWEST_METHODS:
        return None
    found = friedmanchisquare(*whole.T)
    return {
        "statistic": float(found.statistic),
        "p": float(found.pvalue),
        "objects": len(whole),
        "methods": whole.shape[1],
    }


def pairwise_tests(values: Float, names: Sequence[str]) -> list[dict[str, Any]]:
    """Return, for each pair of methods, who wins how often and Wilcoxon's signed-rank test.

    Parameters
    ----------
    values : (objects, m) array
        Errors, comparable between objects; objects with a NaN are left out, but for methods
        that are NaN on all of them.
    names : sequence of str
        Of the m methods.

    Returns
    -------
    list of dict
        ``first, second``; ``wins`` and ``losses``, on how many objects the first has the smaller
        and the larger error; ``median_difference`` of first minus second; ``p`` and ``p_holm``,
        the latter corrected for all pairs by Holm's method (1 where all differences are zero, or
        none is known).

    Examples
    --------
    >>> better = np.array([[1.0, 2.0], [2.0, 4.0], [3.0, 3.5]])
    >>> found = pairwise_tests(better, ["ours", "theirs"])[0]
    >>> found["wins"], found["p"]
    (3, 0.25)
    """
    whole = _whole(values)
    rows: list[dict[str, Any]] = []
    for first, second in itertools.combinations(range(len(names)), 2):
        difference = whole[:, first] - whole[:, second]
        difference = difference[np.isfinite(difference)]
        rows.append(
            {
                "first": names[first],
                "second": names[second],
                "wins": int((difference < 0).sum()),
                "losses": int((difference > 0).sum()),
                "median_difference": float(np.median(difference)) if len(difference) else np.nan,
                "p": float(wilcoxon(difference).pvalue) if difference.any() else 1.0,
            }
        )
    if rows:
        corrected = multipletests([row["p"] for row in rows], method="holm")[1]
        for row, p in zip(rows, corrected.tolist(), strict=True):
            row["p_holm"] = p
    return rows


def _whole(values: Float) -> Float:
    """Return the objects that are known on every method that is known at all."""
    known = np.isfinite(values)
    whole: Float = values[known[:, known.any(axis=0)].all(axis=1) & known.any(axis=1)]
    return whole


def _interval(samples: Float) -> tuple[Float, Float]:
    tail = (1 - LEVEL) / 2
    low, high = np.quantile(samples, [tail, 1 - tail], axis=0)
    return low, high
