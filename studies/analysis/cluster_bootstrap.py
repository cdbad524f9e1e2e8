"""Bootstrap of rates by subjects: whole subjects are drawn, so their answers stay together."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from shading_model.arrays import Float
from shading_model.errors import RelightlabError

DRAWS = 10_000
CHUNK = 2_000
"""Draws held at once: 2,000 of 1,000 subjects are 16 MB."""


class BootstrapRates(NamedTuple):
    """Rates of several sets of trials, their percentile intervals, and every draw."""

    rate: Float
    low: Float
    high: Float
    drawn: Float


def bootstrap_rates(
    outcome: ArrayLike,
    subject: ArrayLike,
    members: ArrayLike,
    generator: np.random.Generator,
    draws: int = DRAWS,
    alpha: float = 0.05,
) -> BootstrapRates:
    """Draw subjects with replacement and return the rate of every set of trials in each draw.

    The same subjects are drawn for every set, so differences of columns of `drawn` are differences
    of paired rates. A draw in which a set has no trial is left out of that set's interval.

    Parameters
    ----------
    outcome : (n,) array
    subject : (n,) array
        Labels.
    members : (n, s) array of bool
        Which trials each set counts.
    generator : numpy.random.Generator
    draws : int
    alpha : float

    Returns
    -------
    BootstrapRates
        Arrays of s, and of (draws, s) as `drawn`; NaN for an empty set.

    Raises
    ------
    RelightlabError
        If the shapes do not agree, or there is no draw.

    Examples
    --------
    >>> subject = np.repeat(np.arange(30), 10)
    >>> chosen = np.random.default_rng(0).random(300) < 0.6
    >>> sets = np.column_stack([np.ones(300, bool), subject < 10])
    >>> result = bootstrap_rates(chosen, subject, sets, np.random.default_rng(1), draws=500)
    >>> bool((result.low < result.rate).all() and (result.rate < result.high).all())
    True
    """
    values, sets = np.asarray(outcome, dtype=float), np.asarray(members, dtype=bool)
    codes, people = pd.factorize(np.asarray(subject))
    if sets.shape[:1] != values.shape or sets.ndim != 2 or len(codes) != len(values) or draws < 1:
        raise RelightlabError(
            f"expected members of shape ({len(values)}, sets) and a draw or more, got"
            f" {sets.shape} and {draws}"
        )
    trials, chosen = np.zeros((2, len(people), sets.shape[1]))
    np.add.at(trials, codes, sets)
    np.add.at(chosen, codes, sets * values[:, None])
    drawn = np.empty((draws, sets.shape[1]))
    with np.errstate(invalid="ignore"):
        for start in range(0, draws, CHUNK):
            size = min(CHUNK, draws - start)
            weights = _weights(len(people), size, generator)
            drawn[start : start + size] = (weights @ chosen) / (weights @ trials)
        rate = chosen.sum(axis=0) / trials.sum(axis=0)
    low, high = _percentiles(drawn, alpha)
    return BootstrapRates(rate, low, high, drawn)


def _weights(subjects: int, draws: int, generator: np.random.Generator) -> Float:
    """How often each subject comes in each draw."""
    picked = generator.integers(0, subjects, size=(draws, subjects))
    cells = picked + np.arange(draws)[:, None] * subjects
    counts = np.bincount(cells.ravel(), minlength=draws * subjects)
    return counts.reshape(draws, subjects).astype(float)


def _percentiles(drawn: Float, alpha: float) -> tuple[Float, Float]:
    bounds = np.full((2, drawn.shape[1]), np.nan)
    for column in range(drawn.shape[1]):
        values = drawn[:, column]
        known = values[np.isfinite(values)]
        if known.size:
            bounds[:, column] = np.quantile(known, [alpha / 2, 1 - alpha / 2])
    return bounds[0], bounds[1]
