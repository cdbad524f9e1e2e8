"""The models that every study is given: the crossed mixed model and, to confirm it, GEE.

For each task, the choice of the target in log-odds: the condition where the task has several, the
side the target was on (+0.5 left, -0.5 right, so that the intercept is free of it) and learning
(from -0.5 at the first place to +0.5 at the last). Tasks that hold several conditions against the
same are compared in one model more, with the condition as its term.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from studies.analysis.arms import comparisons
from studies.analysis.bradley_terry import bradley_terry
from studies.analysis.estimating_equations import fit_estimating_equations
from studies.analysis.mixed_model import MixedFit, fit_mixed_model
from studies.analysis.model_rows import gee_rows, mixed_rows, strength_rows
from studies.analysis.rates import Row

INTERCEPT, SIDE, LEARNING = "(Intercept)", "side", "learning"


@dataclass(frozen=True, eq=False)
class FittedModels:
    """The models of a study.

    Parameters
    ----------
    rows : list of dict
        ``model, term, estimate, se``.
    mixed : dict of str to MixedFit
        The mixed models by task, or by comparison of tasks.
    notes : list of str
        What could not be fitted, and why.
    """

    rows: list[Row]
    mixed: dict[str, MixedFit]
    notes: list[str]


def fit_study_models(trials: pd.DataFrame) -> FittedModels:
    """Fit the models of every task, and of every comparison of several tasks.

    Parameters
    ----------
    trials : DataFrame
        Main trials of `studies.analysis.arms.with_arms`.

    Returns
    -------
    FittedModels
        Of each set ``mixed``, with side and learning; ``mixed_plain``, without; and ``gee``.
    """
    models = FittedModels([], {}, [])
    for name, own in _sets(trials):
        full, terms = study_columns(own)
        keep = [place for place, term in enumerate(terms) if term not in (SIDE, LEARNING)]
        _fit_mixed(models, f"mixed: {name}", name, own, full, terms)
        if len(keep) < len(terms):
            plain_terms = tuple(terms[place] for place in keep)
            _fit_mixed(models, f"mixed_plain: {name}", "", own, full[:, keep], plain_terms)
        _fit_gee(models, f"gee: {name}", own, full, terms)
    return models


def study_columns(trials: pd.DataFrame) -> tuple[Float, tuple[str, ...]]:
    """Return the fixed effects of the choices: condition, side and learning.

    Parameters
    ----------
    trials : DataFrame
        ``task, position, arm, target_side``.

    Returns
    -------
    columns : (n, p) array
    terms : tuple of str
        ``(Intercept)``, ``condition`` and its level for all but the first, ``side``, ``learning``;
        those that do not vary are left out, and those of which a value is missing.

    Examples
    --------
    >>> trials = pd.DataFrame({"task": "real", "position": [1, 2, 3, 1], "arm": list("aabb"),
    ...                        "target_side": ["left", "right", "left", "left"]})
    >>> study_columns(trials)[1]
    ('(Intercept)', 'conditionb', 'side', 'learning')
    """
    columns, terms = [np.ones(len(trials))], [INTERCEPT]
    for level in sorted(trials["arm"].unique())[1:]:
        columns.append((trials["arm"] == level).to_numpy(dtype=float))
        terms.append(f"condition{level}")
    for term, values in ((SIDE, _side(trials)), (LEARNING, _learning(trials))):
        if np.isfinite(values).all() and np.ptp(values) > 0:
            columns.append(values)
            terms.append(term)
    return np.column_stack(columns), tuple(terms)


def strengths_of(trials: pd.DataFrame, others: Mapping[str, str], alpha: float) -> FittedModels:
    """Fit Bradley and Terry's strengths wherever three methods or more meet.

    Parameters
    ----------
    trials : DataFrame
        Main trials.
    others : mapping of str to str
        For each task, the method that the target is held against; tasks not in it are left out.
    alpha : float

    Returns
    -------
    FittedModels
        For each set of methods that meet, directly or through others, a model
        ``bradley_terry: ...`` or a note.
    """
    models = FittedModels([], {}, [])
    known = trials[trials["task"].isin(list(others))]
    first = known["condition"].astype(str)
    second = known["task"].map(dict(others)).astype(str)
    for methods in _meeting(set(zip(first, second, strict=True))):
        own = first.isin(methods).to_numpy()
        model = f"bradley_terry: {', '.join(sorted(methods))}"
        try:
            fit = bradley_terry(
                known["chose_target"][own],
                first[own].tolist(),
                second[own].tolist(),
                known["subject"].to_numpy()[own],
                alpha,
            )
        except RelightlabError as error:
            models.notes.append(f"{model} was not fitted: {error}")
            continue
        models.rows.extend(strength_rows(model, fit))
    return models


def _meeting(pairs: set[tuple[str, str]]) -> list[set[str]]:
    """Sets of three methods or more that are linked by pairs."""
    sets: list[set[str]] = []
    for pair in sorted(pairs):
        linked = [one for one in sets if one & set(pair)]
        sets = [one for one in sets if one not in linked] + [set(pair).union(*linked)]
    return [one for one in sets if len(one) > 2]


def _sets(trials: pd.DataFrame) -> Iterator[tuple[str, pd.DataFrame]]:
    for task, own in trials.groupby("task", sort=True):
        yield str(task), own
    for name, own in comparisons(trials):
        if own["task"].nunique() > 1:
            yield name, own


def _fit_mixed(
    models: FittedModels,
    model: str,
    key: str,
    trials: pd.DataFrame,
    columns: Float,
    terms: tuple[str, ...],
) -> None:
    factors = {"subject": trials["subject"].to_numpy(), "item": trials["pair"].to_numpy()}
    factors = {name: labels for name, labels in factors.items() if len(set(labels)) > 1}
    try:
        fit = fit_mixed_model(trials["chose_target"], columns, terms, factors)
    except RelightlabError as error:
        models.notes.append(f"{model} was not fitted: {error}")
        return
    models.rows.extend(mixed_rows(model, fit))
    models.notes.extend([] if fit.converged else [f"{model} did not converge: take it with care"])
    models.notes.extend(
        f"{model} finds no variance between {name}s beyond chance"
        for name, deviation in fit.deviations.items()
        if deviation == 0
    )
    if key:
        models.mixed[key] = fit


def _fit_gee(
    models: FittedModels, model: str, trials: pd.DataFrame, columns: Float, terms: tuple[str, ...]
) -> None:
    try:
        fit = fit_estimating_equations(
            trials["chose_target"], columns, terms, trials["subject"].to_numpy()
        )
    except RelightlabError as error:
        models.notes.append(f"{model} was not fitted: {error}")
        return
    models.rows.extend(gee_rows(model, fit))


def _side(trials: pd.DataFrame) -> Float:
    side = trials["target_side"]
    places = np.where(side == "left", 0.5, -0.5).astype(float)
    return np.where(side.notna(), places, np.nan)


def _learning(trials: pd.DataFrame) -> Float:
    """Places from -0.5 at the first to +0.5 at the last of the task."""
    position = trials["position"].astype(float)
    last = position.groupby(trials["task"]).transform("max")
    from_middle = (position - (last + 1) / 2).to_numpy(dtype=float)
    places: Float = (last - 1).to_numpy(dtype=float)
    shares = np.full(len(places), np.nan)
    np.divide(from_middle, places, out=shares, where=places > 0)
    return shares
