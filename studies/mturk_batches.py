"""Results of a batch in the style of Amazon Mechanical Turk, in the tidy tables.

A row is an assignment. Its trials are told by columns that end in the same number, or in none
where an assignment holds one pair::

    Input.pair_1, Input.left_1, Input.right_1, Input.target_side_1, Input.condition_1,
    Input.kind_1, Answer.choice_1, Answer.reaction_ms_1

``pair``, ``target_side`` and ``choice`` are needed. Sides are ``left`` and ``right``, or ``A`` and
``B``. Other ``Answer`` columns are the questionnaire. Answers in one JSON column, as the platform's
own form elements send them, are read likewise.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from shading_model.errors import RelightlabError
from studies.csv_files import read_csv
from studies.foreign_rows import (
    ForeignFile,
    imported_subjects,
    long_answers,
    one_row_each,
    subject_namer,
)
from studies.questionnaire_answers import subject_columns
from studies.secret_key import SecretKey
from studies.tables import StudyData, closing_results, score

JSON_ANSWERS = "Answer.taskAnswers"
_TRIAL_COLUMN = re.compile(
    r"(Input\.(pair|left|right|target_side|condition|kind)|"
    r"Answer\.(choice|reaction_ms))(?:_?\d+)?"
)
_CHOICE = re.compile(r"Answer\.choice(_?\d+)?")
_SIDES = {"left": "left", "right": "right", "A": "left", "B": "right"}
_SIDES |= {"a": "left", "b": "right"}
_KINDS = {kind: kind for kind in ("main", "qualification", "closing")}
_STATUS = {"Submitted": "complete", "Approved": "complete", "Rejected": "returned"}
_ZONES = {"PST": "-0800", "PDT": "-0700", "GMT": "+0000", "UTC": "+0000"}
_FORM = "%a %b %d %H:%M:%S %z %Y"


def read_mturk(path: Path, name: str, key: SecretKey) -> StudyData:
    """Return the answers of a batch; worker ids become keyed hashes and are not kept.

    A worker's trials are numbered by the time of submission. Rejected assignments make the worker
    ``returned``.

    Parameters
    ----------
    path : Path
        The CSV of results.
    name : str
        Of the study; the task's too.
    key : SecretKey
        What worker ids are hashed with.

    Returns
    -------
    StudyData
        Subjects of mode ``imported``.

    Raises
    ------
    RelightlabError
        If the file cannot be read, lacks a column or holds what it should not.
    """
    file = ForeignFile(path, _with_json_answers(path, read_csv(path)))
    file.need(["WorkerId", "AssignmentId", "AssignmentStatus"])
    file = ForeignFile(path, file.rows.drop_duplicates("AssignmentId").reset_index(drop=True))
    subject = file.texts("WorkerId").map(subject_namer(name, key))
    submitted = _instants(file, "SubmitTime")
    each = pd.DataFrame(
        {
            "subject": subject,
            "status": file.words("AssignmentStatus", _STATUS),
            "started": _instants(file, "AcceptTime"),
            "finished": submitted,
        }
    )
    # The words sort so that one rejected assignment makes the worker returned.
    subjects = each.groupby("subject", sort=False, as_index=False).agg(
        {"status": "max", "started": "min", "finished": "max"}
    )
    answers = _questionnaire(file, subject)
    told = [
        subject_columns(dict(zip(own["question"], own["answer"], strict=True)))
        for own in (answers[answers["subject"] == one] for one in subjects["subject"])
    ]
    trials = _trials(file, subject, submitted, name)
    whole = subjects.join(pd.DataFrame(told)).merge(closing_results(trials), "left", "subject")
    return StudyData(imported_subjects(whole, name), trials, answers)


def _trials(
    file: ForeignFile, subject: pd.Series[str], submitted: pd.Series[str], task: str
) -> pd.DataFrame:
    numbers = [found[1] or "" for c in file.rows if (found := _CHOICE.fullmatch(str(c)))]
    if not numbers:
        raise RelightlabError(
            f"{file.path} has no column of choices: expected Answer.choice, or Answer.choice_1,"
            " Answer.choice_2, ..."
        )
    parts = [
        _one_trial(file, number).assign(subject=subject, answered=submitted, place=place)
        for place, number in enumerate(numbers)
    ]
    table = pd.concat(parts)
    table["assignment"] = table.index
    table = table.sort_values(["answered", "assignment", "place"], kind="stable")
    table["trial"] = table.groupby("subject").cumcount()
    table["position"] = table.groupby(["subject", "kind"]).cumcount() + 1
    table["task"] = task
    return table.drop(columns=["assignment", "place"])


def _one_trial(file: ForeignFile, number: str) -> pd.DataFrame:
    side = file.words(f"Input.target_side{number}", _SIDES)
    response = file.words(f"Answer.choice{number}", {**_SIDES, "tie": "tie"})
    condition, kind = f"Input.condition{number}", f"Input.kind{number}"
    return pd.DataFrame(
        {
            "kind": file.words(kind, _KINDS) if kind in file.rows else "main",
            "pair": file.texts(f"Input.pair{number}"),
            "condition": file.texts(condition) if condition in file.rows else "target",
            "left": file.optional(f"Input.left{number}"),
            "right": file.optional(f"Input.right{number}"),
            "target_side": side,
            "response": response,
            "chose_target": score(response, side),
            "reaction_ms": file.numbers(f"Answer.reaction_ms{number}"),
        }
    )


def _questionnaire(file: ForeignFile, subject: pd.Series[str]) -> pd.DataFrame:
    names = [
        str(c)
        for c in file.rows
        if str(c).startswith("Answer.")
        and c != JSON_ANSWERS
        and not _TRIAL_COLUMN.fullmatch(str(c))
    ]
    if not names:
        return pd.DataFrame(columns=["subject", "question", "answer"])
    table = file.rows[names].rename(columns=lambda column: column.removeprefix("Answer."))
    # Of several assignments of a worker only one need repeat the questionnaire.
    filled = table.assign(subject=subject).groupby("subject").transform(lambda v: v.ffill().bfill())
    each = one_row_each(filled.assign(subject=subject), file.path)
    return long_answers(each, [name.removeprefix("Answer.") for name in names])


def _instants(file: ForeignFile, column: str) -> pd.Series[str]:
    """Return a column of instants in ISO 8601, missing where there is none."""
    texts = file.optional(column)
    for zone, offset in _ZONES.items():
        texts = texts.str.replace(zone, offset, regex=False)
    moments = pd.to_datetime(texts, format=_FORM, errors="coerce", utc=True)
    iso = pd.to_datetime(texts, format="ISO8601", errors="coerce", utc=True)
    known = moments.fillna(iso)
    wrong = texts.notna() & known.isna()
    if wrong.any():
        raise file.fault(column, wrong, "a time such as 'Tue Nov 24 10:12:33 PST 2026'")
    return known.dt.strftime("%Y-%m-%dT%H:%M:%SZ").astype("str")


def _with_json_answers(path: Path, rows: pd.DataFrame) -> pd.DataFrame:
    if JSON_ANSWERS not in rows:
        return rows
    found = [_flat(path, number, text) for number, text in enumerate(rows[JSON_ANSWERS], start=1)]
    answers = pd.DataFrame(found, index=rows.index, dtype="str").add_prefix("Answer.")
    return pd.concat([rows.drop(columns=JSON_ANSWERS), answers], axis=1)


def _flat(path: Path, number: int, text: object) -> dict[str, str]:
    """Return the answers of one assignment; of a group of radio buttons the one that is on."""
    try:
        (form,) = json.loads(str(text))
        return {name: _word(value) for name, value in form.items()}
    except (ValueError, TypeError, AttributeError) as error:
        raise RelightlabError(
            f"{path} holds in the column {JSON_ANSWERS!r} of row {number} what is not a list of one"
            " JSON object: download the batch's results again"
        ) from error


def _word(value: Any) -> str:
    if isinstance(value, Mapping):
        return next((str(name) for name, on in value.items() if on is True), "")
    return str(value)
