"""Answers of many simulated studies at once, and the planned tests of them.

In one study a subject takes the target of a pair with the log odds

    intercept + subject + item,

both effects normal, the intercept such that the expected rate is the given one. Studies of
different sizes share their first subjects, so that the power over sizes is one smooth curve.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq
from scipy.special import expit, roots_hermitenorm
from scipy.stats import t as student

Scope = Literal["these scenes", "scenes like these"]
SCOPES: tuple[Scope, ...] = ("these scenes", "scenes like these")
"""What a test is to tell of: its very pictures, tested over subjects, their mean effect being
fixed; or pictures as they might have been, tested over subjects and pictures, both drawn."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Sums:
    """What the tests need of one arm: for each study (rows) and size (columns).

    Parameters
    ----------
    subjects : (k,) int
        Subjects of each size.
    shown : int
        Trials of a subject.
    target : (d, k)
        Choices of the target.
    squares : (d, k)
        Sum over subjects of their squared number of such choices.
    items : (d, k, i)
        Choices of the target by pair.
    item_trials : (k, i)
        Trials of each pair.
    """

    subjects: npt.NDArray[np.int64]
    shown: int
    target: Floats
    squares: Floats
    items: Floats
    item_trials: Floats

    @property
    def trials(self) -> npt.NDArray[np.int64]:
        """Return the trials of each size."""
        return self.subjects * self.shown

    @property
    def rate(self) -> Floats:
        """Return the share of choices of the target."""
        return self.target / self.trials


def intercept(rate: float, deviation: float) -> float:
    """Return the log odds about which normal effects give an expected rate.

    Parameters
    ----------
    rate : float
        Between 0 and 1.
    deviation : float
        Standard deviation of the sum of the effects.

    Returns
    -------
    float

    Examples
    --------
    >>> intercept(0.5, 1.0)
    0.0
    >>> round(intercept(0.6, 0.0), 4), round(intercept(0.6, 1.0), 4)
    (0.4055, 0.4898)
    """
    nodes, weights = roots_hermitenorm(40)
    weights = weights / weights.sum()
    if rate == 0.5:
        return 0.0
    return float(brentq(lambda m: weights @ expit(m + deviation * nodes) - rate, -50, 50))


def shown_pairs(subjects: int, items: int, shown: int) -> npt.NDArray[np.bool_]:
    """Return which pairs each subject sees, every pair as often as every other.

    Parameters
    ----------
    subjects, items : int
    shown : int
        Pairs of a subject.

    Returns
    -------
    ndarray of bool, shape (subjects, items)

    Examples
    --------
    >>> shown_pairs(3, 3, 2).astype(int).tolist()
    [[1, 1, 0], [0, 1, 1], [1, 0, 1]]
    """
    behind = (np.arange(items)[None, :] - np.arange(subjects)[:, None]) % items
    return behind < shown


def draw_sums(
    log_odds: float,
    subject_sd: float,
    item_effects: npt.NDArray[np.float32],
    sizes: Sequence[int],
    shown: int,
    generator: np.random.Generator,
) -> Sums:
    """Return the sums of simulated studies of one arm.

    Parameters
    ----------
    log_odds : float
        The intercept.
    subject_sd : float
    item_effects : (d, i) array
        A row for each study.
    sizes : sequence of int, ascending
        Subjects; a study of one size is the beginning of the next.
    shown : int
        Pairs of a subject, at most i.
    generator : numpy.random.Generator

    Returns
    -------
    Sums

    Examples
    --------
    >>> effects = np.zeros((3, 10), np.float32)
    >>> sums = draw_sums(0.0, 0.5, effects, [20, 40], 10, np.random.default_rng(0))
    >>> sums.rate.shape, sums.item_trials[1, :2].tolist()
    ((3, 2), [40.0, 40.0])
    """
    draws, items = item_effects.shape
    subjects = sizes[-1]
    own = log_odds + subject_sd * generator.standard_normal((draws, subjects, 1), np.float32)
    odds = expit(own + item_effects[:, None, :], dtype=np.float32)
    seen = shown_pairs(subjects, items, shown)
    chosen = (generator.random((draws, subjects, items), np.float32) < odds) & seen
    by_subject = chosen.sum(axis=2, dtype=np.int32)
    starts = [0, *sizes[:-1]]
    by_item = np.add.reduceat(chosen, starts, axis=1, dtype=np.int32).cumsum(axis=1)
    last = np.array(sizes) - 1
    return Sums(
        np.array(sizes),
        shown,
        by_subject.cumsum(axis=1)[:, last].astype(float),
        (by_subject**2).cumsum(axis=1)[:, last].astype(float),
        by_item.astype(float),
        seen.cumsum(axis=0)[last].astype(float),
    )


@dataclass(frozen=True)
class Estimate:
    """A rate or a difference of rates with its standard error, for each study and size.

    Parameters
    ----------
    value, error : (d, k)
    freedom : (k,)
        Degrees of freedom of Student's t.
    """

    value: Floats
    error: Floats
    freedom: npt.NDArray[np.int64]


def estimate(arms: Sequence[Sums], scope: Scope) -> Estimate:
    """Return the rate of one arm, or that of the first less that of the second, with its error.

    The errors are those of `studies.analysis`: clustered by subject, with t of one less than the
    subjects of the smaller arm; or by subject and item, with t of one less than these or the items.

    Parameters
    ----------
    arms : one or two Sums
    scope : {'these scenes', 'scenes like these'}

    Returns
    -------
    Estimate

    Examples
    --------
    >>> effects = np.zeros((1, 10), np.float32)
    >>> sums = draw_sums(0.0, 0.0, effects, [50], 10, np.random.default_rng(0))
    >>> found = estimate([sums], "these scenes")
    >>> found.freedom.tolist(), bool(0.01 < found.error[0, 0] < 0.04)
    ([49], True)
    """
    signs = (1, -1)[: len(arms)]
    value = sum((sign * arm.rate for sign, arm in zip(signs, arms, strict=True)), np.float64(0))
    subjects = np.min([arm.subjects for arm in arms], axis=0)
    variance = np.sum([_variance_by_subject(arm) for arm in arms], axis=0)
    freedom = subjects - 1
    if scope == "scenes like these":
        items = arms[0].items.shape[-1]
        by_item = sum(sign * _item_score(arm) for sign, arm in zip(signs, arms, strict=True))
        between = items / (items - 1) * (np.asarray(by_item) ** 2).sum(axis=-1)
        trials = np.sum([arm.trials for arm in arms], axis=0)
        within = np.sum([arm.rate * (1 - arm.rate) / arm.trials for arm in arms], axis=0)
        both = variance + between - trials / (trials - 1) * within
        variance = np.maximum(both, np.maximum(variance, between))
        freedom = np.minimum(subjects, items) - 1
    return Estimate(np.asarray(value), np.sqrt(np.maximum(variance, 0)), freedom)


def differs(found: Estimate, null: float, alpha: float) -> npt.NDArray[np.bool_]:
    """Return where a two-sided test rejects the null; never where there is no variance.

    Parameters
    ----------
    found : Estimate
    null : float
    alpha : float

    Returns
    -------
    ndarray of bool, shape (d, k)

    Examples
    --------
    >>> found = Estimate(np.array([[0.6]]), np.array([[0.03]]), np.array([30]))
    >>> differs(found, 0.5, 0.05).tolist()
    [[True]]
    """
    reach = student.isf(alpha / 2, found.freedom) * found.error
    return (found.error > 1e-9) & (np.abs(found.value - null) > reach)


def is_equivalent(
    found: Estimate, null: float, margin: float, alpha: float
) -> npt.NDArray[np.bool_]:
    """Return where two one-sided tests place the value within a margin of the null.

    Parameters
    ----------
    found : Estimate
    null, margin : float
    alpha : float
        Level of each of the two tests.

    Returns
    -------
    ndarray of bool, shape (d, k)

    Examples
    --------
    >>> found = Estimate(np.array([[0.51]]), np.array([[0.02]]), np.array([300]))
    >>> is_equivalent(found, 0.5, 0.05, 0.05).tolist()
    [[True]]
    """
    reach = student.isf(alpha, found.freedom) * found.error
    return (found.error > 1e-9) & (np.abs(found.value - null) + reach < margin)


def _variance_by_subject(arm: Sums) -> Floats:
    """Return the sandwich variance of a rate from the subjects' residuals."""
    squares = arm.squares - arm.shown * arm.trials * arm.rate**2
    return arm.subjects / (arm.subjects - 1) * squares / arm.trials**2


def _item_score(arm: Sums) -> Floats:
    """Return the residual of each item over the number of trials, (d, k, i)."""
    expected = arm.item_trials * arm.rate[..., None]
    return (arm.items - expected) / arm.trials[:, None]
