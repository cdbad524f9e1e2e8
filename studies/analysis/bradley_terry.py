"""Bradley and Terry's model, where several methods meet: each has a strength, in log-odds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.stats import t as student
from statsmodels.genmod.families import Binomial
from statsmodels.genmod.generalized_linear_model import GLM

from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from studies.analysis.intervals import FEWEST_CLUSTERS
from studies.analysis.laplace import Codes
from studies.analysis.model_inputs import check_answers


@dataclass(frozen=True, eq=False)
class Strengths:
    """Strengths of methods in log-odds, their sum zero, with intervals clustered by subject.

    Parameters
    ----------
    methods : tuple of str
        From the strongest to the weakest.
    strength, standard_error, low, high : (m,) arrays
    covariance : (m, m) array
        Singular, since strengths sum to zero.
    subjects : int
    """

    methods: tuple[str, ...]
    strength: Float
    standard_error: Float
    low: Float
    high: Float
    covariance: Float
    subjects: int

    def chance(self, first: str, second: str) -> float:
        """Return the probability that the first is chosen over the second."""
        one, two = self.methods.index(first), self.methods.index(second)
        return float(1 / (1 + np.exp(self.strength[two] - self.strength[one])))


def bradley_terry(
    outcome: ArrayLike,
    first: Sequence[str],
    second: Sequence[str],
    subject: ArrayLike,
    alpha: float = 0.05,
) -> Strengths:
    """Fit the strengths of methods to choices between pairs of them.

    Parameters
    ----------
    outcome : (n,) array
        1 if the first was chosen, 0 if the second, 0.5 for a tie.
    first, second : (n,) sequences of str
        The methods.
    subject : (n,) array
        Labels.
    alpha : float

    Returns
    -------
    Strengths
        Intervals by Student's t with one degree of freedom less than the subjects.

    Raises
    ------
    RelightlabError
        If there are fewer than two subjects or methods, a method meets itself, or the methods
        cannot all be compared: no path of wins leads from each to each.

    Examples
    --------
    >>> first, second = ["a", "a", "b", "a"] * 10, ["b", "b", "c", "c"] * 10
    >>> subject, rng = np.repeat(np.arange(10), 4), np.random.default_rng(0)
    >>> fit = bradley_terry(rng.random(40) < 0.7, first, second, subject)
    >>> fit.methods[0], bool(abs(fit.strength.sum()) < 1e-9)
    ('a', True)
    """
    answers = np.asarray(outcome, dtype=float)
    check_answers(answers)
    codes, labels = pd.factorize(np.concatenate([np.asarray(first, str), np.asarray(second, str)]))
    names = [str(label) for label in labels]
    one, two = np.split(codes, 2)
    people = pd.factorize(np.asarray(subject))[0]
    count = int(people.max()) + 1
    _check_pairs(answers, one, two, names, count)
    design = np.zeros((len(answers), len(names)))
    np.add.at(design, (np.arange(len(answers)), one), 1.0)
    np.add.at(design, (np.arange(len(answers)), two), -1.0)
    fit = GLM(answers, design[:, 1:], family=Binomial()).fit(tol=1e-12, maxiter=200)
    against_first = np.asarray(fit.params)
    covariance = _clustered(answers, design[:, 1:], against_first, people)
    centred = (np.eye(len(names)) - 1 / len(names))[:, 1:]
    strength = centred @ against_first
    order = np.argsort(-strength, kind="stable")
    spread = (centred @ covariance @ centred.T)[np.ix_(order, order)]
    errors = np.sqrt(np.diag(spread))
    reach = float(student.isf(alpha / 2, count - 1)) * errors
    strength = strength[order]
    methods = tuple(names[place] for place in order)
    return Strengths(methods, strength, errors, strength - reach, strength + reach, spread, count)


def _clustered(answers: Float, design: Float, strength: Float, people: Codes) -> Float:
    """The sandwich over subjects with the factor G / (G - 1), as for rates."""
    chance = 1 / (1 + np.exp(-design @ strength))
    bread = np.linalg.inv(design.T @ (design * (chance * (1 - chance))[:, None]))
    scores = np.zeros((int(people.max()) + 1, design.shape[1]))
    np.add.at(scores, people, design * (answers - chance)[:, None])
    factor = len(scores) / (len(scores) - 1)
    return np.asarray(factor * bread @ scores.T @ scores @ bread)


def _check_pairs(
    answers: Float, one: Codes, two: Codes, names: Sequence[str], subjects: int
) -> None:
    if (one == two).any():
        raise RelightlabError(f"{names[int(one[one == two][0])]!r} is compared with itself")
    if min(len(names), subjects) < FEWEST_CLUSTERS:
        raise RelightlabError(
            f"expected two subjects and two methods or more, got {subjects} and {len(names)}"
        )
    winners = np.concatenate([one[answers > 0], two[answers < 1]])
    losers = np.concatenate([two[answers > 0], one[answers < 1]])
    wins = coo_array((np.ones(len(winners)), (winners, losers)), shape=(len(names),) * 2)
    parts, part = connected_components(wins, directed=True, connection="strong")
    if parts > 1:
        apart = next(name for name, own in zip(names, part, strict=True) if own != part[0])
        raise RelightlabError(
            f"{names[0]!r} and {apart!r} cannot be compared: no path of wins leads both ways; leave"
            " a method out, or collect more answers"
        )
