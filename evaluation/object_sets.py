"""Named sets of a dataset's objects that errors are averaged over."""

from __future__ import annotations

from collections.abc import Sequence

from datasets.mit_berkeley import TEST_OBJECTS, TRAINING_OBJECTS

_SETS = {"mit-berkeley": {"MIT_TRAIN": TRAINING_OBJECTS, "MIT_TEST": TEST_OBJECTS}}
HELD_OUT = "MIT_TEST"
"""The set that no prior was trained on."""


def object_sets(dataset: str, objects: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Return the sets of a dataset's objects by name; ``all`` where none have names.

    Parameters
    ----------
    dataset : str
    objects : sequence of str

    Returns
    -------
    dict of tuples of str
        Every object is in one; sets of which there is no object are left out.

    Examples
    --------
    >>> object_sets("mit-berkeley", ["apple", "pear"])
    {'MIT_TRAIN': ('apple',), 'MIT_TEST': ('pear',)}
    >>> object_sets("my set", ["mug"])
    {'all': ('mug',)}
    """
    named = {
        name: tuple(one for one in objects if one in members)
        for name, members in _SETS.get(dataset, {}).items()
    }
    return {name: members for name, members in named.items() if members} or {"all": tuple(objects)}
