"""Some of a dataset's objects: named sets that errors are averaged over, and a chosen few."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from datasets.mit_berkeley import TEST_OBJECTS, TRAINING_OBJECTS
from datasets.records import Capture, Dataset, LitPhotograph

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


@dataclass(frozen=True, eq=False)
class ChosenObjects:
    """A dataset of which only some objects are measured.

    Parameters
    ----------
    whole : Dataset
    objects : tuple of str
    """

    whole: Dataset
    objects: tuple[str, ...]

    @property
    def name(self) -> str:
        """Name of the whole set, by which thresholds are found."""
        return self.whole.name

    @property
    def settings(self) -> tuple[str, ...]:
        """Settings of the whole set."""
        return self.whole.settings

    def load(self, name: str, setting: str) -> Capture:
        """Return one object in one setting."""
        return self.whole.load(name, setting)

    def lit_photographs(self, name: str) -> tuple[LitPhotograph, ...]:
        """Return the object's photographs under other lights."""
        return self.whole.lit_photographs(name)

    def fingerprint(self) -> str:
        """Return the SHA-256 of the whole set."""
        return self.whole.fingerprint()
