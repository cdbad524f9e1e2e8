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
from scipy.stats import f as fisher
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


class WaldTest(NamedTuple):
    """An F test of several contrasts of rates against zero."""

    statistic: float
    numerator: int
    denominator: int
    p: float


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


def wald_test(means: CellMeans, contrasts: ArrayLike) -> WaldTest:
    """Test whether several contrasts of cell means are all zero.

    Hotelling's F: as degrees of freedom the number of contrasts, and that of the subjects in the
    smallest cell less the number of contrasts. With one contrast it is the square of the t test.

    Parameters
    ----------
    means : CellMeans
    contrasts : (q, c) array

    Returns
    -------
    WaldTest
        `p` is NaN where the contrasts have no variance, or subjects are too few.
    """
    matrix = np.atleast_2d(np.asarray(contrasts, dtype=float))
    subjects, rank = int(means.subjects.min()), len(matrix)
    freedom = subjects - rank
    if subjects < FEWEST_CLUSTERS or freedom < 1:
        return WaldTest(np.nan, rank, max(freedom, 0), np.nan)
    value, covariance = matrix @ means.mean, matrix @ means.covariance @ matrix.T
    if np.linalg.matrix_rank(covariance, tol=1e-12) < rank:
        return WaldTest(np.nan, rank, freedom, np.nan)
    hotelling = float(value @ np.linalg.solve(covariance, value))
    statistic = hotelling * freedom / (rank * (subjects - 1))
    return WaldTest(statistic, rank, freedom, float(fisher.sf(statistic, rank, freedom)))


def group_test(outcome: ArrayLike, group: ArrayLike, subject: ArrayLike) -> WaldTest:
    """Test whether a rate differs between any levels of a group.

    Parameters
    ----------
    outcome, group, subject : (n,) arrays

    Returns
    -------
    WaldTest

    Raises
    ------
    RelightlabError
        If the group has one level only.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> test = group_test(rng.random(400) < 0.6, np.repeat(["f", "m"], 200),
    ...                   np.repeat(np.arange(40), 10))
    >>> test.numerator, test.denominator, 0 < test.p <= 1
    (1, 19, True)
    """
    means = cell_means(outcome, group, subject)
    if len(means.cells) < 2:
        raise RelightlabError(f"expected two levels to compare, got only {means.cells}")
    return wald_test(means, _differences(len(means.cells)))


def interaction_test(
    outcome: ArrayLike, method: ArrayLike, group: ArrayLike, subject: ArrayLike
) -> WaldTest:
    """Test whether differences between methods differ between levels of a group.

    Only if they do may it be said that a group sees the methods differently: that a difference is
    significant in one group and not in another is no such test.

    Parameters
    ----------
    outcome, method, group, subject : (n,) arrays

    Returns
    -------
    WaldTest

    Raises
    ------
    RelightlabError
        If there are not two methods and two levels, or a combination has no answers.
    """
    methods, names = pd.factorize(np.asarray(method), sort=True)
    groups, levels = pd.factorize(np.asarray(group), sort=True)
    means = cell_means(outcome, methods * len(levels) + groups, subject)
    if min(len(names), len(levels)) < 2 or len(means.cells) < len(names) * len(levels):
        raise RelightlabError(
            f"expected answers on each of two methods or more in each of two groups or more, got"
            f" {len(means.cells)} combinations of {len(names)} methods and {len(levels)} groups"
        )
    return wald_test(means, np.kron(_differences(len(names)), _differences(len(levels))))


def _differences(count: int) -> Float:
    """Contrasts of each level after the first with the first."""
    return np.hstack([-np.ones((count - 1, 1)), np.eye(count - 1)])


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
