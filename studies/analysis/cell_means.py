"""Rates of several cells at once, with the covariance that shared subjects give them.

A cell is a method, a group, or a method within a group. The same subject may have answers in
several cells (two methods, both halves) or in one only (men and women); the covariance knows, so
one test serves paired and unpaired comparisons.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.stats import t as student

from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from studies.analysis.intervals import FEWEST_CLUSTERS
from studies.analysis.laplace import Codes


@dataclass(frozen=True, eq=False)
class CellMeans:
    """Means of cells and their joint covariance, clustered by subject.

    Parameters
    ----------
    cells : tuple
        Labels, sorted.
    mean : (c,) array
    covariance : (c, c) array
    subjects : (c,) array of int
        With answers in each cell.
    trials : (c,) array of int
    """

    cells: tuple[Hashable, ...]
    mean: Float
    covariance: Float
    subjects: Codes
    trials: Codes


class Difference(NamedTuple):
    """A difference of rates, its interval, and the two-sided test that there is none.

    `subjects` are those of the smallest cell.
    """

    difference: float
    low: float
    high: float
    standard_error: float
    p: float
    subjects: int


def cell_means(outcome: ArrayLike, cell: ArrayLike, subject: ArrayLike) -> CellMeans:
    """Return the mean of every cell and their covariance over subjects.

    Parameters
    ----------
    outcome : (n,) array
        No NaN.
    cell : (n,) array
        Labels.
    subject : (n,) array
        Labels.

    Returns
    -------
    CellMeans
        The covariance is the sandwich of the regression on the cells; each cell's part has the
        factor G / (G - 1) for the G subjects in it, infinite for one subject.

    Raises
    ------
    RelightlabError
        If there are fewer than two subjects.

    Examples
    --------
    >>> means = cell_means([1, 0, 1, 1], ["a", "b", "a", "b"], [1, 1, 2, 2])
    >>> [str(cell) for cell in means.cells], means.mean.tolist(), means.subjects.tolist()
    (['a', 'b'], [1.0, 0.5], [2, 2])
    """
    values = np.asarray(outcome, dtype=float)
    places, labels = pd.factorize(np.asarray(cell), sort=True)
    people, names = pd.factorize(np.asarray(subject))
    if len(names) < FEWEST_CLUSTERS:
        raise RelightlabError(f"expected answers of two subjects or more, got {len(names)}")
    trials = np.bincount(places)
    mean = np.bincount(places, values) / trials
    score, present = np.zeros((2, len(names), len(labels)))
    np.add.at(score, (people, places), values - mean[places])
    present[people, places] = 1
    subjects = present.sum(axis=0).astype(np.intp)
    with np.errstate(divide="ignore"):
        factor = np.sqrt(subjects / (subjects - 1.0))
    score *= np.where(np.isfinite(factor), factor, 0.0) / trials
    covariance = score.T @ score
    covariance[np.diag_indices_from(covariance)] += np.where(subjects < FEWEST_CLUSTERS, np.inf, 0)
    return CellMeans(tuple(labels), mean, covariance, subjects, trials)


def contrast(means: CellMeans, weights: ArrayLike, alpha: float = 0.05) -> Difference:
    """Return a weighted sum of cell means with its interval.

    Student's t with one degree of freedom less than the subjects of the smallest cell that counts:
    G - 1 where the same G subjects are in all of them, and on the safe side where they are not.

    Parameters
    ----------
    means : CellMeans
    weights : (c,) array
    alpha : float

    Returns
    -------
    Difference
        `p` is NaN where the contrast has no variance, or a cell one subject.

    Examples
    --------
    >>> means = cell_means([1, 0, 1, 1, 0, 0], ["a", "b"] * 3, [1, 1, 2, 2, 3, 3])
    >>> round(contrast(means, [1, -1]).difference, 3)
    0.333
    """
    vector = np.asarray(weights, dtype=float)
    value = float(vector @ means.mean)
    used = np.flatnonzero(vector)
    subjects = int(means.subjects[used].min())
    if subjects < FEWEST_CLUSTERS:
        return Difference(value, np.nan, np.nan, np.nan, np.nan, subjects)
    spread = vector[used] @ means.covariance[np.ix_(used, used)] @ vector[used]
    error, freedom = float(np.sqrt(max(0.0, spread))), subjects - 1
    reach = float(student.isf(alpha / 2, freedom)) * error
    p = float(2 * student.sf(abs(value) / error, freedom)) if error > 1e-12 else np.nan
    return Difference(value, value - reach, value + reach, error, p, subjects)


def paired_difference(
    outcome: ArrayLike,
    method: ArrayLike,
    subject: ArrayLike,
    methods: tuple[Hashable, Hashable],
    alpha: float = 0.05,
) -> Difference:
    """Return the rate of one method less that of another, subjects paired where they judged both.

    Parameters
    ----------
    outcome : (n,) array
    method : (n,) array
    subject : (n,) array
    methods : pair
        The difference is that of the first less the second.
    alpha : float

    Returns
    -------
    Difference

    Raises
    ------
    RelightlabError
        If a method has no answers.

    Examples
    --------
    >>> result = paired_difference([1, 0, 1, 1], ["a", "b"] * 2, [1, 1, 2, 2], ("a", "b"))
    >>> result.difference, result.subjects
    (0.5, 2)
    """
    labels = np.asarray(method)
    for name in methods:
        if not (labels == name).any():
            raise RelightlabError(f"there are no answers on {name!r}: nothing to compare")
    chosen = (labels == methods[0]) | (labels == methods[1])
    means = cell_means(
        np.asarray(outcome)[chosen], labels[chosen] == methods[0], np.asarray(subject)[chosen]
    )
    return contrast(means, [-1, 1], alpha)


def labelled(means: CellMeans) -> Sequence[tuple[Hashable, float, float]]:
    """Return label, mean and standard error of every cell.

    Parameters
    ----------
    means : CellMeans

    Returns
    -------
    list of tuple
    """
    errors = np.sqrt(np.diag(means.covariance))
    return list(zip(means.cells, means.mean.tolist(), errors.tolist(), strict=True))
