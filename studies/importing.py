"""Importing answers that were collected elsewhere: a registry of formats, each a module's reader.

Subjects get names that are hashes of what the file calls them, so that reading a file again gives
the same rows, and a response store that has them already does not change.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from shading_model.errors import RelightlabError, unknown_name
from studies.exporting import read_export
from studies.mapped_files import read_mapped
from studies.mturk_batches import read_mturk
from studies.published_sets import (
    DYNAVECT,
    DYNAVECT_FILE,
    GENGAP,
    GENGAP_FILE,
    read_dynavect,
    read_gengap,
)
from studies.secret_key import SecretKey
from studies.tables import StudyData
from studies.trial_mapping import TrialMapping


@dataclass(frozen=True)
class ImportOptions:
    """What some formats need besides the file.

    Parameters
    ----------
    name : str
        Of the study the answers belong to: the same worker has another name in another.
    key : SecretKey, optional
        What ids are hashed with: the database's.
    mapping : TrialMapping, optional
        What the columns of a CSV file mean.
    """

    name: str = ""
    key: SecretKey | None = None
    mapping: TrialMapping | None = None


Reader = Callable[[Path, ImportOptions], StudyData]


def import_answers(path: Path, file_format: str, options: ImportOptions | None = None) -> StudyData:
    """Return the answers of a file in one of the known formats.

    Parameters
    ----------
    path : Path
        A file; the folder of an export or of a published set.
    file_format : str
        A key of `FORMATS`.
    options : ImportOptions, optional

    Returns
    -------
    StudyData

    Raises
    ------
    RelightlabError
        If the format is unknown, an option is lacking, or the file is not as the format says.

    Examples
    --------
    >>> import_answers(Path("answers.csv"), "mturk2")
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: Unknown format 'mturk2'. Did you mean 'mturk'?
    Available: export, csv, mturk, dynavect-2afc, gengap-realfake.
    """
    if file_format not in FORMATS:
        raise unknown_name("format", file_format, FORMATS)
    return FORMATS[file_format](path, options or ImportOptions())


def _export(path: Path, _options: ImportOptions) -> StudyData:
    return read_export(path)


def _csv(path: Path, options: ImportOptions) -> StudyData:
    if options.mapping is None:
        raise RelightlabError("a CSV file needs a mapping that says what its columns mean")
    return read_mapped(path, options.mapping, options.name or path.stem, _key(options))


def _mturk(path: Path, options: ImportOptions) -> StudyData:
    return read_mturk(path, options.name or path.stem, _key(options))


def _dynavect(path: Path, _options: ImportOptions) -> StudyData:
    return read_dynavect(path / DYNAVECT_FILE if path.is_dir() else path)


def _gengap(path: Path, _options: ImportOptions) -> StudyData:
    return read_gengap(path / GENGAP_FILE if path.is_dir() else path)


def _key(options: ImportOptions) -> SecretKey:
    if options.key is None:
        raise RelightlabError("ids of workers are hashed with the key of a database: name one")
    return options.key


FORMATS: Mapping[str, Reader] = MappingProxyType(
    {"export": _export, "csv": _csv, "mturk": _mturk, DYNAVECT: _dynavect, GENGAP: _gengap}
)
"""How each format is read."""
