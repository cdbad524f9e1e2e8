"""Generalised estimating equations: the population-averaged companion of the mixed model.

statsmodels fits them; here its answers are cut to what R's geepack gives (scale with no correction
for the number of terms) and put in the form that the tables show.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from statsmodels.genmod.cov_struct import Exchangeable, Independence
from statsmodels.genmod.families import Binomial
from statsmodels.genmod.generalized_estimating_equations import GEE

from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from studies.analysis.model_inputs import LARGEST_LOG_ODDS, check_answers, check_columns

Working = Literal["exchangeable", "independence"]
_STRUCTURES = {"exchangeable": Exchangeable, "independence": Independence}


@dataclass(frozen=True, eq=False)
class EstimatingFit:
    """A fitted logistic model of the population's average.

    Parameters
    ----------
    terms : tuple of str
    estimate, standard_error : (p,) arrays
        In log-odds; errors are robust to likeness within subjects.
    correlation : float or None
        Within subjects, where the working structure has one.
    trials, subjects : int
    """

    terms: tuple[str, ...]
    estimate: Float
    standard_error: Float
    correlation: float | None
    trials: int
    subjects: int


def fit_estimating_equations(
    outcome: ArrayLike,
    columns: ArrayLike,
    terms: Sequence[str],
    subject: ArrayLike,
    working: Working = "exchangeable",
) -> EstimatingFit:
    """Fit a logistic model by estimating equations with clusters of one subject's answers.

    Parameters
    ----------
    outcome : (n,) array
        From 0 to 1.
    columns : (n, p) array
    terms : sequence of str
    subject : (n,) array
        Labels.
    working : {'exchangeable', 'independence'}

    Returns
    -------
    EstimatingFit

    Raises
    ------
    RelightlabError
        If outcomes or columns are not fit for it, or the equations have no finite solution.

    Examples
    --------
    >>> rng = np.random.default_rng(2)
    >>> fit = fit_estimating_equations(rng.random(200) < 0.6, np.ones((200, 1)), ["(Intercept)"],
    ...                                np.repeat(np.arange(20), 10))
    >>> fit.trials, fit.subjects
    (200, 20)
    """
    answers = np.asarray(outcome, dtype=float)
    matrix = np.asarray(columns, dtype=float)
    check_answers(answers)
    check_columns(matrix, terms)
    codes, levels = pd.factorize(np.asarray(subject))
    order = np.argsort(codes, kind="stable")
    structure = _STRUCTURES[working]()
    model = GEE(
        answers[order], matrix[order], codes[order], family=Binomial(), cov_struct=structure
    )
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            fit = model.fit(ddof_scale=0, ctol=1e-9, maxiter=200)
            estimate, errors = np.asarray(fit.params), np.asarray(fit.bse)
    except (ValueError, np.linalg.LinAlgError, AttributeError) as error:
        raise RelightlabError(_UNSOLVED) from error
    finite = np.isfinite(estimate).all() and np.isfinite(errors).all() and fit.converged
    if not finite or np.abs(matrix @ estimate).max() > LARGEST_LOG_ODDS:
        raise RelightlabError(_UNSOLVED)
    alpha = float(structure.dep_params) if working == "exchangeable" else None
    return EstimatingFit(tuple(terms), estimate, errors, alpha, len(answers), len(levels))


_UNSOLVED = (
    "the estimating equations have no finite solution: for some values of the terms all answers are"
    " alike; leave a term out, or join levels"
)
