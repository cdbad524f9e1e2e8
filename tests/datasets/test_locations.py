"""The search for a data root, in the order the user is told."""

from __future__ import annotations

from pathlib import Path

import pytest

from datasets import locations
from datasets.locations import (
    download_root,
    find_data_root,
    find_root_of,
    missing_data_sentence,
    usual_places,
)
from shading_model.errors import RelightlabError


def _root(path: Path, known: str = "mit-berkeley") -> Path:
    (path / known).mkdir(parents=True)
    (path / known / "file").touch()
    return path


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Run in an empty project beside nothing, with no root named and an empty user cache."""
    project = tmp_path / "places" / "project"
    project.mkdir(parents=True)
    monkeypatch.chdir(project)
    monkeypatch.delenv("RELIGHTLAB_DATA", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(locations, "__file__", str(project / "datasets" / "locations.py"))
    return project


def test_nothing_anywhere() -> None:
    """Without data in any place there is no root, and no error."""
    assert find_data_root() is None


def test_order_of_the_search(
    tmp_path: Path, elsewhere: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each place is taken before those after it: --data, variable, cache, beside the project."""
    beside = _root(elsewhere.parent / "shared" / "data")
    assert find_data_root() == beside
    cache = _root(tmp_path / "cache" / "relightlab", "hdri")
    assert find_data_root() == cache
    named = _root(tmp_path / "named", "boundary-cues")
    monkeypatch.setenv("RELIGHTLAB_DATA", str(named))
    assert find_data_root() == named
    explicit = _root(tmp_path / "explicit")
    assert find_data_root(explicit) == explicit


def test_each_set_is_found_in_its_own_root(
    tmp_path: Path, elsewhere: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A place that holds other sets only does not hide one; a root given by --data is the only."""
    beside = _root(elsewhere.parent / "shared" / "data", "boundary-cues")
    cache = _root(tmp_path / "cache" / "relightlab")
    assert find_root_of("mit-berkeley") == cache
    assert find_root_of("boundary-cues") == beside
    named = _root(tmp_path / "named", "hdri")
    monkeypatch.setenv("RELIGHTLAB_DATA", str(named))
    assert find_root_of("mit-berkeley") == cache
    assert find_root_of("hdri") == named
    assert find_root_of("boundary-cues", cache) is None
    assert str(named) in missing_data_sentence("psm-uw")
    assert str(named) not in missing_data_sentence("psm-uw", cache)


def test_given_cache(tmp_path: Path) -> None:
    """Another cache than the user's can be given."""
    cache = _root(tmp_path / "other")
    assert find_data_root(cache=cache) == cache


def test_beside_the_current_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Data beside the current folder is found when the project lies somewhere else."""
    beside = _root(tmp_path / "work" / "shared" / "data")
    (tmp_path / "work" / "analysis").mkdir()
    monkeypatch.chdir(tmp_path / "work" / "analysis")
    assert find_data_root() == beside


@pytest.mark.parametrize("leftover", ["synthetic-1-300-0/file", "mit-berkeley/.unfinished/part"])
def test_cache_without_a_known_set(tmp_path: Path, elsewhere: Path, leftover: str) -> None:
    """A cache that holds only generated sets or unfinished files does not hide the real data."""
    beside = _root(elsewhere.parent / "shared" / "data")
    path = tmp_path / "cache" / "relightlab" / leftover
    path.parent.mkdir(parents=True)
    path.touch()
    assert find_data_root() == beside


def test_explicit_root_that_does_not_exist(tmp_path: Path) -> None:
    """A root named by --data that is not there is an error, even where another root is."""
    with pytest.raises(RelightlabError, match=r"nowhere given by --data does not exist"):
        find_data_root(tmp_path / "nowhere", cache=_root(tmp_path / "cache-with-data"))


def test_explicit_root_without_sets(tmp_path: Path) -> None:
    """A root that holds none of the sets is an error that lists what was looked for."""
    with pytest.raises(RelightlabError, match=r"holds none of the known sets \(mit-berkeley, .*\)"):
        find_data_root(tmp_path)


def test_set_given_in_place_of_its_root(tmp_path: Path) -> None:
    """Whoever names the set's own folder is told to name the folder above it."""
    root = _root(tmp_path / "data")
    with pytest.raises(RelightlabError, match=rf"give the folder above it, {root}$"):
        find_data_root(root / "mit-berkeley")


def test_variable_with_a_wrong_root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A wrong root in the environment variable is an error that names the variable."""
    monkeypatch.setenv("RELIGHTLAB_DATA", str(tmp_path / "nowhere"))
    with pytest.raises(RelightlabError, match=r"given by RELIGHTLAB_DATA does not exist"):
        find_data_root()


def test_empty_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    """An empty environment variable counts as not set."""
    monkeypatch.setenv("RELIGHTLAB_DATA", "")
    assert find_data_root() is None


def test_download_root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Downloads go to --data, else the variable, else the user cache, existing or not."""
    assert download_root() == tmp_path / "cache" / "relightlab"
    monkeypatch.setenv("RELIGHTLAB_DATA", str(tmp_path / "named"))
    assert download_root() == tmp_path / "named"
    assert download_root(tmp_path / "explicit") == tmp_path / "explicit"


def test_missing_data_sentence() -> None:
    """The sentence for absent data names the set, every place and the command that fetches it."""
    sentence = missing_data_sentence("mit-berkeley")
    assert all(str(place) in sentence for place in usual_places())
    assert "relightlab data fetch mit-berkeley" in sentence
