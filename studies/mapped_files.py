"""Any tidy CSV file of choices in the tables of a study, by the mapping of its columns."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from shading_model.errors import RelightlabError
from studies.foreign_rows import (
    ForeignFile,
    imported_subjects,
    long_answers,
    open_foreign,
    subject_namer,
)
from studies.questionnaire_answers import subject_columns
from studies.secret_key import SecretKey
from studies.tables import StudyData
from studies.trial_mapping import TrialMapping

OUTCOMES = {"0": 0.0, "1": 1.0, "0.0": 0.0, "1.0": 1.0, "0.5": 0.5}
OUTCOMES |= {"false": 0.0, "true": 1.0, "False": 0.0, "True": 1.0, "FALSE": 0.0, "TRUE": 1.0}
OPPOSITE = {"left": "right", "right": "left"}


def read_mapped(path: Path, mapping: TrialMapping, name: str, key: SecretKey) -> StudyData:
    """Return the choices of a foreign file; subjects get names by keyed hashes.

    The groups that the mapping names and that are the same in all rows of a subject become answers
    of the questionnaire; ``gender``, ``age`` and ``expertise`` also the subject's own. Where the
    side of the target is known, the response is told by it and the outcome.

    Parameters
    ----------
    path : Path
        CSV.
    mapping : TrialMapping
    name : str
        Of the set; the task's too.
    key : SecretKey

    Returns
    -------
    StudyData
        Subjects of mode ``imported``.

    Raises
    ------
    RelightlabError
        If the file cannot be read, lacks a column, no row is kept, or an outcome is none.
    """
    file = _kept(path, mapping)
    subject = file.texts(mapping.subject).map(subject_namer(name, key))
    outcome = file.words(mapping.outcome, OUTCOMES)
    side, response = _sides(file, mapping, outcome)
    trials = pd.DataFrame(
        {
            "subject": subject,
            "task": name,
            "kind": "main",
            "trial": subject.groupby(subject).cumcount(),
            "position": file.numbers(mapping.position) if mapping.position else np.nan,
            "pair": file.texts(mapping.item),
            "condition": file.texts(mapping.condition) if mapping.condition else "target",
            "target_side": side,
            "response": response,
            "chose_target": outcome,
        }
    )
    groups = _constant_groups(file, mapping, subject)
    each = file.rows[groups].assign(subject=subject).drop_duplicates().reset_index(drop=True)
    told = pd.DataFrame([subject_columns(row) for row in _answers(each, groups)])
    subjects = imported_subjects(each[["subject"]].join(told), name)
    return StudyData(subjects, trials, long_answers(each, groups))


def _kept(path: Path, mapping: TrialMapping) -> ForeignFile:
    file = open_foreign(path, mapping.columns())
    keep = pd.Series(True, index=file.rows.index)
    for column, values in mapping.keep.items():
        keep &= file.rows[column].isin(values)
    if not keep.any():
        raise RelightlabError(
            f"no row of {path} is kept: look at [keep] of the mapping, which asks for"
            f" {', '.join(mapping.keep)}"
        )
    return ForeignFile(path, file.rows[keep].reset_index(drop=True))


def _sides(file: ForeignFile, mapping: TrialMapping, outcome: pd.Series[float]) -> tuple[Any, Any]:
    if not mapping.side:
        return None, None
    left = file.texts(mapping.side) == mapping.left
    side = left.map({True: "left", False: "right"})
    response = side.where(outcome == 1, side.map(OPPOSITE)).where(outcome != 0.5, "tie")
    return side, response


def _constant_groups(
    file: ForeignFile, mapping: TrialMapping, subject: pd.Series[str]
) -> list[str]:
    most = file.rows.groupby(subject).nunique(dropna=False).max()
    return [group for group in mapping.groups if group in most and most[group] == 1]


def _answers(each: pd.DataFrame, groups: list[str]) -> list[dict[str, str]]:
    rows = each[groups].to_dict("records")
    return [{str(k): str(v) for k, v in row.items() if not pd.isna(v)} for row in rows]
