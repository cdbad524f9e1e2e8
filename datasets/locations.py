"""Where measured data lies: the search for a data root.

A data root is a folder that holds ``mit-berkeley/``, ``boundary-cues/`` or another set of
`datasets.catalogue`.
"""

from __future__ import annotations

import os
from pathlib import Path

import platformdirs

from datasets.catalogue import KNOWN_DATASETS, present_sets
from shading_model.errors import RelightlabError

ENVIRONMENT_VARIABLE = "RELIGHTLAB_DATA"
"""Names the data root where ``--data`` is not given."""


def user_cache() -> Path:
    """Return the folder for downloads and generated sets that belongs to the user.

    Examples
    --------
    >>> user_cache().name
    'relightlab'
    """
    return Path(platformdirs.user_cache_dir("relightlab", appauthor=False))


def find_data_root(explicit: Path | None = None, *, cache: Path | None = None) -> Path | None:
    """Return the data root, or None where there is none.

    A root the user names (`explicit`, else the environment variable ``RELIGHTLAB_DATA``) must
    hold a known set. Otherwise the first place of `usual_places` that holds one is taken.

    Parameters
    ----------
    explicit : Path, optional
        What ``--data`` gives.
    cache : Path, optional
        The user cache; `user_cache()` by default.

    Raises
    ------
    RelightlabError
        If the root the user names does not exist or holds no known set.

    Examples
    --------
    >>> find_data_root(Path("no such folder"))
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: the data root no such folder given by --data does ...
    """
    if explicit is not None:
        return _checked(Path(explicit), "--data")
    if named := os.environ.get(ENVIRONMENT_VARIABLE):
        return _checked(Path(named), ENVIRONMENT_VARIABLE)
    return next((place for place in usual_places(cache=cache) if present_sets(place)), None)


def find_root_of(
    name: str, explicit: Path | None = None, *, cache: Path | None = None
) -> Path | None:
    """Return the first data root that holds one set, None if there is none.

    A root given by ``--data`` is the only one looked into; otherwise the places are those of
    `find_data_root`, and one that holds other sets only is passed over.

    Parameters
    ----------
    name : str
        A set: the name of its folder.
    explicit : Path, optional
        What ``--data`` gives.
    cache : Path, optional
        The user cache; `user_cache()` by default.

    Examples
    --------
    >>> find_root_of("mit-berkeley", Path("no such folder")) is None
    True
    """
    places = _places(explicit, cache)
    return next((place for place in places if name in present_sets(place)), None)


def usual_places(*, cache: Path | None = None) -> tuple[Path, ...]:
    """Return where data is looked for when nobody says where, in order.

    The user cache, then ``shared/data`` beside the checkout of the project, then ``shared/data``
    beside the current folder.

    Examples
    --------
    >>> str(usual_places(cache=Path("cache"))[0])
    'cache'
    """
    checkout = Path(__file__).resolve().parents[1]
    beside = [folder.parent / "shared" / "data" for folder in (checkout, Path.cwd())]
    return tuple(dict.fromkeys([cache or user_cache(), *beside]))


def download_root(explicit: Path | None = None, *, cache: Path | None = None) -> Path:
    """Return the data root that downloads go to; it need not exist yet.

    `explicit`, else the environment variable ``RELIGHTLAB_DATA``, else the user cache.

    Examples
    --------
    >>> str(download_root(Path("here")))
    'here'
    """
    named = os.environ.get(ENVIRONMENT_VARIABLE)
    return explicit or (Path(named) if named else None) or cache or user_cache()


def missing_data_sentence(
    name: str, explicit: Path | None = None, *, cache: Path | None = None
) -> str:
    """Return one sentence that says a set was not found, where it was looked for and what to do.

    Parameters
    ----------
    name : str
    explicit : Path, optional
        What ``--data`` gives.
    cache : Path, optional

    Examples
    --------
    >>> print(missing_data_sentence("mit-berkeley", cache=Path("cache")))
    mit-berkeley was not found in cache, ...: give its data root with --data or RELIGHTLAB_DATA...
    """
    places = ", ".join(str(place) for place in _places(explicit, cache))
    return (
        f"{name} was not found in {places}: give its data root with --data or"
        f" {ENVIRONMENT_VARIABLE}, or run 'relightlab data fetch {name}'"
    )


def _places(explicit: Path | None, cache: Path | None) -> list[Path]:
    if explicit is not None:
        return [explicit]
    named = os.environ.get(ENVIRONMENT_VARIABLE)
    return [*([Path(named)] if named else []), *usual_places(cache=cache)]


def _checked(root: Path, given_by: str) -> Path:
    if not root.is_dir():
        raise RelightlabError(
            f"the data root {root} given by {given_by} does not exist or is not a folder:"
            " give a folder that holds mit-berkeley/ or another known set"
        )
    if not present_sets(root):
        raise RelightlabError(
            f"the data root {root} given by {given_by} holds none of the known sets"
            f" ({', '.join(known.name for known in KNOWN_DATASETS)}): {_advice(root)}"
        )
    return root


def _advice(root: Path) -> str:
    parent = root.resolve().parent
    if present_sets(parent):
        return f"give the folder above it, {parent}"
    return "give the folder that holds them, or run 'relightlab data fetch mit-berkeley'"
