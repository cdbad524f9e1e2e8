"""The subpopulations of the paper's Table 3, trial by trial.

**Gender** and **age** are what the subject declared; the paper's text parts ages below 25 from 25
and older, its Table 3 up to 25 from older, and the table's is taken here. **Passed** the
perspective-shading (p-s) tests has who chose both the plausible spheres and the drawing in true
perspective. An **expert** passed them and declared expertise in art or graphics; everybody else of
whom both are known is none. The **first half** are the trials of the first half of positions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pandas as pd

from shading_model.errors import unknown_name
from studies.tables import StudyData

EVERYBODY = "all"
HALVES = ("1st half", "2nd half")
GROUPS = ("expertise", "tests", "gender", "age", "half")
"""The paper's groups in the order of Table 3."""
BETWEEN_SUBJECTS = ("expertise", "tests", "gender", "age")


def subpopulations(
    data: StudyData, groups: Sequence[str] = GROUPS, age_threshold: float = 25.0
) -> dict[str, pd.Series]:
    """Return the level of every main trial in every group.

    Parameters
    ----------
    data : StudyData
    groups : sequence of str
        Of `GROUPS`, and ``side``: on which side the target was.
    age_threshold : float
        Years; the lower level includes it.

    Returns
    -------
    dict of categorical Series
        With the index of `main_trials`; NaN where the level is not known. Groups none of whose
        levels is known are left out.

    Raises
    ------
    RelightlabError
        If a group is unknown.

    Examples
    --------
    >>> subject = {"subject": "s1", "study_hash": "-", "task": "real", "order": 0,
    ...            "mode": "simulated", "status": "complete", "age": 25, "expertise": True,
    ...            "passed_spheres": True, "passed_perspective": False}
    >>> trial = {"subject": "s1", "task": "real", "kind": "main", "trial": 0, "position": 1,
    ...          "pair": "chair", "condition": "ours", "target_side": "left", "response": "left",
    ...          "chose_target": 1}
    >>> data = StudyData(pd.DataFrame([subject]), pd.DataFrame([trial]))
    >>> {group: levels.iloc[0] for group, levels in subpopulations(data).items()}
    {'expertise': 'non-expert', 'tests': 'failed p-s test', 'age': 'age ≤ 25', 'half': '1st half'}
    """
    trials = main_trials(data)
    subjects = data.subjects.set_index("subject")
    found: dict[str, pd.Series] = {}
    for group in groups:
        if group in BETWEEN_SUBJECTS:
            levels = _of_subjects(group, subjects, age_threshold)
            column = trials["subject"].map(levels.astype(object))
            categories = list(levels.cat.categories)
        elif group in _OF_TRIALS:
            column, categories = _OF_TRIALS[group](trials)
        else:
            raise unknown_name("group", group, (*GROUPS, *set(_OF_TRIALS) - set(GROUPS)))
        if column.notna().any():
            found[group] = pd.Series(
                pd.Categorical(column, categories=categories), index=trials.index, name=group
            )
    return found


def main_trials(data: StudyData) -> pd.DataFrame:
    """Return the trials that count: no qualification and no closing pairs.

    Parameters
    ----------
    data : StudyData

    Returns
    -------
    DataFrame
        The rows of `data.trials`, with their index.
    """
    return data.trials[data.trials["kind"] == "main"]


def half_of_session(trials: pd.DataFrame) -> pd.Series:
    """Return in which half of the session a trial was: of the places there are in its task.

    Parameters
    ----------
    trials : DataFrame
        Columns ``task`` and ``position`` (from 1). With an odd number of places the middle one is
        in the first half.

    Returns
    -------
    Series of str
        NaN where the position is not known.

    Examples
    --------
    >>> trials = pd.DataFrame({"task": "real", "position": [1, 2, 3, 4]})
    >>> half_of_session(trials).tolist()
    ['1st half', '1st half', '2nd half', '2nd half']
    """
    position = trials["position"].astype(float)
    places = position.groupby(trials["task"]).transform("max")
    late = position > np.ceil(places / 2)
    words: pd.Series = late.map({False: HALVES[0], True: HALVES[1]})
    return words.where(position.notna())


def _half(trials: pd.DataFrame) -> tuple[pd.Series, list[str]]:
    return half_of_session(trials), list(HALVES)


def _side(trials: pd.DataFrame) -> tuple[pd.Series, list[str]]:
    return trials["target_side"], ["left", "right"]


_OF_TRIALS: Mapping[str, Callable[[pd.DataFrame], tuple[pd.Series, list[str]]]] = {
    "half": _half,
    "side": _side,
}


def _of_subjects(group: str, subjects: pd.DataFrame, age_threshold: float) -> pd.Series:
    if group == "gender":
        return _gender(subjects)
    if group == "age":
        years = f"{age_threshold:g}"
        older = subjects["age"] > age_threshold
        return _two_levels(
            older.where(subjects["age"].notna()), f"age > {years}", f"age ≤ {years}", swapped=True
        )
    passed = subjects["passed_spheres"] & subjects["passed_perspective"]
    if group == "tests":
        return _two_levels(passed, "passed p-s test", "failed p-s test")
    return _two_levels(passed & subjects["expertise"], "expert", "non-expert")


def _gender(subjects: pd.DataFrame) -> pd.Series:
    """Male, female, then other words as they were given."""
    words = subjects["gender"].astype(object)
    others = sorted(set(words.dropna()) - {"male", "female"})
    return pd.Series(
        pd.Categorical(words, categories=["male", "female", *others]), index=subjects.index
    )


def _two_levels(flag: pd.Series, true: str, false: str, *, swapped: bool = False) -> pd.Series:
    """NA is three-valued: not passed is known of who failed one test, whatever the other."""
    words = flag.astype("boolean").astype(object).map({True: true, False: false})
    categories = [false, true] if swapped else [true, false]
    return pd.Series(pd.Categorical(words, categories=categories), index=flag.index)
