"""Sentences for the user's errors."""

from __future__ import annotations

import pytest

from shading_model.errors import RelightlabError, unknown_name


def test_a_near_miss_is_suggested() -> None:
    """A misspelt name gets the nearest one and the whole list."""
    error = unknown_name("object", "racoon", ["raccoon", "sun"])
    assert isinstance(error, RelightlabError)
    assert str(error) == (
        "Unknown object 'racoon'. Did you mean 'raccoon'? Available: raccoon, sun."
    )


def test_nothing_is_suggested_for_a_name_far_from_all() -> None:
    """A name like no other gets the list alone."""
    assert str(unknown_name("rule", "zzz", ["oracle"])) == "Unknown rule 'zzz'. Available: oracle."


def test_the_names_may_come_from_an_iterator() -> None:
    """Names that can be read only once are both compared and listed."""
    sentence = str(unknown_name("rule", "oracel", iter(["oracle", "manual"])))
    assert "Did you mean 'oracle'" in sentence
    assert sentence.endswith("Available: oracle, manual.")


def test_it_is_raised_as_the_users_fault() -> None:
    """The error can be raised as it is returned."""
    with pytest.raises(RelightlabError, match="Unknown setting"):
        raise unknown_name("setting", "studio", ["natural"])


def test_a_beginning_is_completed() -> None:
    """A short name that others begin with is no near match, but meant."""
    words = str(unknown_name("detail source", "gt", ["default", "gt-shading"]))
    assert "Did you mean 'gt-shading'?" in words
