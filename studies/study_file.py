"""A study in one TOML file: read, checked with its stimuli, and known by its hash."""

from __future__ import annotations

import hashlib
import json
import os
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Protocol, TypeVar

from shading_model.errors import RelightlabError
from studies.stimulus_files import stimulus_digests
from studies.study_pairs import (
    CLOSING_KEYS,
    QUALIFICATION_KEYS,
    TASK_KEYS,
    read_closing,
    read_qualification,
    read_task,
    refuse_duplicates,
)
from studies.study_plan import checked_plan
from studies.study_records import (
    AnalysisPlan,
    ClosingPair,
    Exclusions,
    Pair,
    Question,
    Recruitment,
    Study,
    Task,
    TrialSettings,
)
from studies.study_sections import (
    ANALYSIS_KEYS,
    EXCLUSION_KEYS,
    QUESTION_KEYS,
    RECRUITMENT_KEYS,
    TRIAL_KEYS,
    read_analysis,
    read_exclusions,
    read_question,
    read_recruitment,
    read_trials,
)
from studies.toml_table import TomlTable, checked_table

__all__ = [
    "AnalysisPlan",
    "ClosingPair",
    "Exclusions",
    "Pair",
    "Question",
    "Recruitment",
    "Study",
    "Task",
    "TrialSettings",
    "load_study",
    "study_hash",
]

STUDY_KEYS = (
    "name",
    "title",
    "seed",
    "consent",
    "instructions",
    "trials",
    "tasks",
    "qualification",
    "closing",
    "questionnaire",
    "recruitment",
    "exclusions",
    "analysis",
)
LARGEST_SEED = 2**53
"""Beyond it, some readers of JSON round."""


class _Named(Protocol):
    @property
    def name(self) -> str: ...


Record = TypeVar("Record", bound=_Named)


def load_study(path: str | os.PathLike[str]) -> Study:
    """Return the study of a file, after a look at everything it says and every picture it names.

    Parameters
    ----------
    path : path-like
        A TOML file as docs/study-file.md describes it; stimuli are relative to its folder.

    Returns
    -------
    Study

    Raises
    ------
    RelightlabError
        If the file cannot be read, a key is unknown, a value is missing or wrong, two names are
        the same, or a stimulus is missing or no picture.

    Examples
    --------
    >>> import tempfile
    >>> from studies.example_study import write_example
    >>> study = load_study(write_example(Path(tempfile.mkdtemp())))
    >>> study.name, [task.name for task in study.tasks][:2], len(study.hash)
    ('example', ['ours-real', 'barron-malik-real'], 64)
    """
    file = Path(path)
    values = _read_toml(file)
    try:
        study = _read_study(checked_table(values, "the study", STUDY_KEYS), file.parent)
        digests = stimulus_digests(study)
    except RelightlabError as error:
        raise RelightlabError(f"{file}: {error}") from error
    return replace(study, hash=study_hash(study, digests))


def study_hash(study: Study, digests: Mapping[str, str]) -> str:
    """Return the SHA-256 of what a study says and shows.

    Where the file lies, its comments and its layout do not count; every value does, defaults
    included, and every byte of every picture.

    Parameters
    ----------
    study : Study
    digests : mapping of str to str
        SHA-256 of each of `study.stimuli()`.

    Returns
    -------
    str
        64 hexadecimal digits.

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> study = bare_study()
    >>> study_hash(study, {}) == study_hash(replace(study, seed=1), {})
    False
    """
    content = asdict(study) | {"folder": None, "hash": None, "stimuli": dict(digests)}
    text = json.dumps(content, sort_keys=True, ensure_ascii=True, separators=(",", ":"))
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def _read_toml(file: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise RelightlabError(
            f"{file}: expected a study file, but there is none; 'relightlab study example DIR'"
            " writes one to start from"
        ) from None
    except IsADirectoryError:
        raise RelightlabError(
            f"{file}: expected a study file, got a folder; name the .toml file in it"
        ) from None
    except UnicodeDecodeError:
        raise RelightlabError(f"{file}: expected TOML in UTF-8, got other bytes") from None
    except tomllib.TOMLDecodeError as error:
        raise RelightlabError(f"{file}: expected TOML, got a fault: {error}") from error


def _read_study(table: TomlTable, folder: Path) -> Study:
    """Return the study without its hash."""
    tasks = _records(table, "tasks", TASK_KEYS, read_task)
    if not tasks:
        raise table.fault("tasks", "at least one table, [[tasks]]")
    study = Study(
        name=table.name("name"),
        title=table.text("title"),
        seed=table.whole("seed", 0, LARGEST_SEED),
        consent=table.text("consent"),
        instructions=table.text("instructions"),
        tasks=tasks,
        qualification=_records(table, "qualification", QUALIFICATION_KEYS, read_qualification),
        closing=_records(table, "closing", CLOSING_KEYS, read_closing),
        questionnaire=_records(table, "questionnaire", QUESTION_KEYS, read_question),
        recruitment=read_recruitment(table.table("recruitment", RECRUITMENT_KEYS)),
        exclusions=read_exclusions(table.table("exclusions", EXCLUSION_KEYS)),
        analysis=read_analysis(table.table("analysis", ANALYSIS_KEYS)),
        settings=read_trials(table.table("trials", TRIAL_KEYS)),
        folder=folder,
        hash="",
    )
    return checked_plan(study, groups_are_chosen="groups" in table.values.get("analysis", {}))


def _records(
    study: TomlTable, key: str, known: tuple[str, ...], read: Callable[[TomlTable], Record]
) -> tuple[Record, ...]:
    """Return the records of a list of tables, whose names all differ."""
    records = tuple(read(table) for table in study.tables(key, known))
    refuse_duplicates([record.name for record in records], f"[[{key}]]")
    return records
