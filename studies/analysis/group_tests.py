"""Whether rates differ between groups, and whether differences of methods do.

That a preference is significant in one group and not in another does not show that the groups
differ: that takes a test of its own, and for two methods it is that of the interaction.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.stats import f as fisher

from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from studies.analysis.cell_means import CellMeans, cell_means
from studies.analysis.intervals import FEWEST_CLUSTERS


class WaldTest(NamedTuple):
    """An F test of several contrasts of rates against zero."""

    statistic: float
    numerator: int
    denominator: int
    p: float


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
