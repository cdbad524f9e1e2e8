"""The measured sets the project knows: what each is, its licence, and whether it is here.

No set is part of the project. Each lies in its own folder of a data root, see
`datasets.locations`.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from types import MappingProxyType

from datasets.file_tree import relative_files, size_on_disk

MIT_BERKELEY_LICENCE = (
    "The MIT-Berkeley intrinsic images are copyright of the Regents of the University of"
    " California (2013; by Jonathan Barron and Jitendra Malik, after Grosse et al., 2009). They"
    " may be used, copied, changed and passed on free of charge for education, research and"
    " not-for-profit purposes, as long as the copyright notice, the permission and the disclaimers"
    " stay with every copy. They come as they are, without warranty or liability. Commercial use"
    " needs a licence from the university."
)
"""The terms of the MIT-Berkeley set in plain words; the notice itself is in its repository."""

_RESEARCH_ONLY = "none stated: for evaluation on your own machine, not to be passed on"


@dataclass(frozen=True)
class KnownDataset:
    """A set the project can read.

    Parameters
    ----------
    name : str
        Its folder in a data root.
    licence : str
        In a few words.
    description : str
        What it holds.
    """

    name: str
    licence: str
    description: str


@dataclass(frozen=True)
class DatasetRow:
    """A row of ``relightlab data list``: a known set, and what a data root holds of it.

    Parameters
    ----------
    name, licence, description : str
        As in `KnownDataset`.
    present : bool
        Whether the root holds at least one of its files.
    files : int
        Files in its folder.
    bytes : int
        Their size.
    """

    name: str
    present: bool
    files: int
    bytes: int
    licence: str
    description: str


@dataclass(frozen=True)
class RecordedFiles:
    """The files of a set as published: where, in which revision, and their content.

    Parameters
    ----------
    repository : str
        ``owner/name`` of a public GitHub repository.
    commit : str
        The revision.
    sha256 : mapping of str to str
        SHA-256 in hexadecimal of each file, by its name relative to the set's folder.
    """

    repository: str
    commit: str
    sha256: MappingProxyType[str, str]


KNOWN_DATASETS = (
    KnownDataset(
        "mit-berkeley",
        "education, research and not-for-profit use; copyright of the Regents",
        "20 objects: photographs, depth, albedo, shading, lights (Grosse 2009; Barron, Malik 2015)",
    ),
    KnownDataset(
        "boundary-cues",
        "MIT; lights from the non-commercial sIBL archive",
        "contours of the 20 MIT objects marked by hand, natural lights (Karsch et al. 2013)",
    ),
    KnownDataset("hdri", "CC0-1.0", "18 environment maps (Poly Haven, reduced)"),
    KnownDataset(
        "sirfs-octave",
        "as mit-berkeley, from which it was computed",
        "shape, albedo, shading and light that SIRFS 1.5 found on the 20 MIT objects",
    ),
    KnownDataset("psm-uw", _RESEARCH_ONLY, "photometric stereo: objects under 12 distant lights"),
    KnownDataset(
        "rgbd-mitten", _RESEARCH_ONLY, "an oven mitt under 20 lights, with a depth sensor"
    ),
    KnownDataset(
        "rsolp-composite",
        "not for commercial use",
        "an example of differential rendering into a photograph (Karsch et al. 2011)",
    ),
    KnownDataset("rooms", "CC0-1.0", "three pictures of rooms to insert objects into"),
    KnownDataset("dynavect-2afc", "CC-BY-4.0", "3147 two-alternative choices of 58 workers"),
    KnownDataset(
        "gengap-realfake", "CC-BY-4.0", "7200 real-or-artificial judgements of 120 people"
    ),
    KnownDataset(
        "reference-fits",
        "as the sets it was computed from",
        "coefficients of mixed and marginal models fitted in R to published answers",
    ),
)
"""Every set that may lie in a data root, in the order they are listed."""


def known_datasets(root: Path | None) -> tuple[DatasetRow, ...]:
    """Return one row for each known set, present in `root` or not.

    Parameters
    ----------
    root : Path or None
        A data root; with None every set is absent.

    Examples
    --------
    >>> rows = known_datasets(None)
    >>> rows[0].name, rows[0].present, rows[0].files
    ('mit-berkeley', False, 0)
    """
    return tuple(_row(known, root) for known in KNOWN_DATASETS)


def present_sets(root: Path) -> tuple[str, ...]:
    """Return the names of the known sets of which `root` holds at least one file.

    Examples
    --------
    >>> present_sets(Path("no such folder"))
    ()
    """
    return tuple(known.name for known in KNOWN_DATASETS if relative_files(root / known.name))


@cache
def mit_berkeley_files() -> RecordedFiles:
    """Return the published files of the MIT-Berkeley set that the project uses.

    Examples
    --------
    >>> recorded = mit_berkeley_files()
    >>> len(recorded.sha256)
    521
    >>> recorded.sha256["natural_lights.mat"][:8]
    'e26020a7'
    """
    text = resources.files("datasets").joinpath("mit_berkeley_files.json").read_text("utf-8")
    record = json.loads(text)
    return RecordedFiles(record["repository"], record["commit"], MappingProxyType(record["sha256"]))


def _row(known: KnownDataset, root: Path | None) -> DatasetRow:
    files, size = (0, 0) if root is None else size_on_disk(root / known.name)
    return DatasetRow(known.name, files > 0, files, size, known.licence, known.description)
