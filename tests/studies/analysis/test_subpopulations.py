"""The paper's subpopulations: who belongs to which, and who to none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

from shading_model.errors import RelightlabError
from studies.analysis.subpopulations import half_of_session, main_trials, subpopulations
from studies.tables import StudyData
from tests.studies.analysis.made_answers import made_answers


def one_subject(**declared: Any) -> StudyData:
    """Return the answers of one subject to two pairs, with a closing pair between them."""
    subject = {"subject": "s", "study_hash": "-", "task": "t", "order": 0, "mode": "imported"}
    trial = {"subject": "s", "task": "t", "condition": "ours", "chose_target": 1.0}
    trials = [
        trial | {"trial": 0, "kind": "main", "pair": "a", "position": 1},
        trial | {"trial": 1, "kind": "closing", "pair": "spheres", "position": 1},
        trial | {"trial": 2, "kind": "main", "pair": "b", "position": 2},
    ]
    subjects = pd.DataFrame([subject | {"status": "complete"} | declared])
    return StudyData(subjects, pd.DataFrame(trials))


def level(group: str, **declared: Any) -> str | None:
    """Return the level of the subject in a group, None if it has none."""
    found = subpopulations(one_subject(**declared), [group])
    return str(found[group].iloc[0]) if group in found else None


@pytest.mark.parametrize(
    ("spheres", "perspective", "expertise", "tests", "expert"),
    [
        (True, True, True, "passed p-s test", "expert"),
        (True, True, False, "passed p-s test", "non-expert"),
        (True, True, None, "passed p-s test", None),
        (True, False, True, "failed p-s test", "non-expert"),
        (None, False, True, "failed p-s test", "non-expert"),
        (None, True, True, None, None),
        (None, True, False, None, "non-expert"),
    ],
)
def test_experts_passed_and_declared(
    spheres: bool | None,
    perspective: bool | None,
    expertise: bool | None,
    tests: str | None,
    expert: str | None,
) -> None:
    """Both closing pairs make a pass; a pass and declared expertise an expert; unknown stays so."""
    declared = {
        "passed_spheres": spheres,
        "passed_perspective": perspective,
        "expertise": expertise,
    }
    assert level("tests", **declared) == tests
    assert level("expertise", **declared) == expert


@pytest.mark.parametrize(
    ("age", "expected"), [(25, "age ≤ 25"), (25.5, "age > 25"), (24, "age ≤ 25"), (None, None)]
)
def test_age_parts_at_25_as_in_table_3(age: float | None, expected: str | None) -> None:
    """Who is 25 is among the younger; an unknown age is in neither."""
    assert level("age", age=age) == expected


def test_another_age_can_part() -> None:
    """The study file's threshold is the level's name as well."""
    found = subpopulations(one_subject(age=40), ["age"], age_threshold=40)
    assert found["age"].iloc[0] == "age ≤ 40"


def test_gender_is_as_declared() -> None:
    """Other words than male and female are levels of their own, after the two."""
    assert level("gender", gender="non-binary") == "non-binary"
    found = subpopulations(one_subject(gender="non-binary"), ["gender"])["gender"]
    assert list(found.cat.categories) == ["male", "female", "non-binary"]


def test_halves_are_of_the_places_of_a_task() -> None:
    """Five of ten are in each half; of five places the middle one is in the first."""
    even = pd.DataFrame({"task": "t", "position": np.arange(1, 11)})
    assert half_of_session(even).value_counts().to_dict() == {"1st half": 5, "2nd half": 5}
    odd = pd.DataFrame({"task": "t", "position": [1, 2, 3, 4, 5]})
    assert (half_of_session(odd) == "1st half").sum() == 3
    unknown = pd.DataFrame({"task": "t", "position": [1.0, np.nan]})
    assert half_of_session(unknown).isna().tolist() == [False, True]


def test_only_main_trials_count() -> None:
    """Closing and qualification pairs are in no rate."""
    data = one_subject()
    assert main_trials(data)["pair"].tolist() == ["a", "b"]
    assert len(subpopulations(data, ["half"])["half"]) == 2


def test_levels_part_all_trials() -> None:
    """Where everything is known, the levels of a group make up all trials."""
    data = made_answers(60, np.random.default_rng(0))
    for levels in subpopulations(data).values():
        assert levels.notna().all()
        assert levels.value_counts().sum() == len(main_trials(data))


def test_unknown_group_is_refused() -> None:
    """A group that is none is named, with those that are."""
    with pytest.raises(RelightlabError, match="Unknown group 'ages'"):
        subpopulations(one_subject(), ["ages"])
