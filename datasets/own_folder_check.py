"""Whether a dataset of one's own can be used, in one line for each object."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from datasets.own_folder import ObjectFiles, OwnFolder
from shading_model.errors import RelightlabError

NEEDED = {"depth": "depth.npy or depth.png", "albedo": "albedo.png, .exr or .npy"}
"""What re-rendering is measured against."""


@dataclass(frozen=True)
class OwnFolderReport:
    """What a folder holds, and what is wrong with it.

    Parameters
    ----------
    folder : Path
    found : dict of tuple of str
        What each object has that can be used.
    faults : tuple of (str, str)
        Object and sentence.
    """

    folder: Path
    found: dict[str, tuple[str, ...]]
    faults: tuple[tuple[str, str], ...]

    @property
    def usable(self) -> bool:
        """Whether nothing is wrong."""
        return not self.faults

    def lacking(self) -> dict[str, list[str]]:
        """Return what each object lacks for re-rendering; empty if it can be measured."""
        lacks = {
            name: [part for part in NEEDED if part not in found]
            for name, found in self.found.items()
        }
        return {name: parts for name, parts in lacks.items() if parts}


def check_own_folder(dataset: OwnFolder) -> OwnFolderReport:
    """Read every file of a dataset of one's own.

    Parameters
    ----------
    dataset : OwnFolder

    Returns
    -------
    OwnFolderReport
    """
    found, faults = {}, []
    for name in dataset.objects:
        words, wrong = _checked(dataset.files(name))
        found[name] = words
        faults += [(name, sentence) for sentence in wrong]
    return OwnFolderReport(dataset.root, found, tuple(faults))


def require_measurable(dataset: OwnFolder) -> None:
    """Refuse a dataset on which re-rendering cannot be measured.

    Parameters
    ----------
    dataset : OwnFolder

    Raises
    ------
    RelightlabError
        If a file is at fault, an object lacks depth or albedo, or a lit photograph has
        neither coefficients nor a probe.
    """
    report = check_own_folder(dataset)
    if report.faults:
        name, sentence = report.faults[0]
        raise RelightlabError(
            f"{name}: {sentence}; 'relightlab data verify {dataset.root}' lists all that is wrong"
        )
    lacking = report.lacking()
    if lacking:
        name, parts = next(iter(lacking.items()))
        files = " and ".join(f"{part} ({NEEDED[part]})" for part in parts)
        more = f", as do {len(lacking) - 1} more objects" if len(lacking) > 1 else ""
        raise RelightlabError(
            f"re-rendering is compared with the true shape and albedo: {name} lacks {files}{more}"
        )


def _checked(files: ObjectFiles) -> tuple[tuple[str, ...], list[str]]:
    faults: list[str] = []

    def tried(read: Callable[[], Any]) -> Any:
        try:
            return read()
        except RelightlabError as error:
            faults.append(str(error))
            return None

    if tried(lambda: files.mask) is None:
        return (), faults
    words = []
    photograph = tried(lambda: files.photograph)
    if photograph is not None:
        height, width = photograph.mask.shape
        words.append(f"photograph {width}x{height}")
    depth = tried(files.height)
    if depth is not None and np.isfinite(depth).any():
        words.append("depth")
    elif depth is not None:
        faults.append("the depth is known nowhere on the mask")
    words += [part for part in ("albedo", "shading") if tried(_reader(files, part)) is not None]
    lit = tried(files.lit_photographs)
    words += [f"{len(lit)} lit photographs"] if lit else []
    probes = files.pictures("probe")
    words += [f"{len(probes)} probes"] if probes else []
    return tuple(words), faults


def _reader(files: ObjectFiles, part: str) -> Callable[[], Any]:
    return lambda: files.image(part)
