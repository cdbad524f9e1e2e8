"""Codes that a subject gives the panel as proof, made from what is stored and checked offline."""

from __future__ import annotations

import base64
import hmac
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from shading_model.errors import RelightlabError
from studies.csv_files import read_csv
from studies.secret_key import SecretKey
from studies.tables import StudyData

LENGTH = 12
WORKER_COLUMNS = ("participant id", "participant_id", "prolific_pid", "workerid", "worker", "id")
CODE_COLUMNS = ("completion code", "completion_code", "entered code", "code")
Verdict = Literal["valid", "unknown", "of another worker", "used twice", "no such worker"]


@dataclass(frozen=True)
class CheckedCode:
    """What became of one code that was handed in.

    Parameters
    ----------
    worker, code : str
        As handed in; `worker` is empty where the file names none.
    subject : str
        Whose code it is; empty if nobody's.
    verdict : str
    """

    worker: str
    code: str
    subject: str
    verdict: Verdict


def completion_code(
    key: SecretKey,
    subject: str,
    study_hash: str,
    trials: Iterable[tuple[int, str]],
    answers: Iterable[tuple[str, str]],
) -> str:
    """Return the code of a complete session.

    Parameters
    ----------
    key : SecretKey
    subject, study_hash : str
    trials : iterable of (int, str)
        Each trial with its response, in any order.
    answers : iterable of (str, str)
        Each question with its answer, in any order.

    Returns
    -------
    str
        12 characters of A-Z and 2-7: the beginning of an HMAC-SHA-256 over all that.

    Examples
    --------
    >>> key = SecretKey(bytes(32))
    >>> code = completion_code(key, "s1", "-", [(0, "left"), (1, "tie")], [])
    >>> code == completion_code(key, "s1", "-", [(1, "tie"), (0, "left")], [])
    True
    >>> code == completion_code(key, "s1", "-", [(0, "left"), (1, "left")], [])
    False
    """
    content = json.dumps([subject, study_hash, sorted(trials), sorted(answers)])
    digest = bytes.fromhex(key.digest("completion", content))
    return base64.b32encode(digest).decode()[:LENGTH]


def completion_codes(key: SecretKey, data: StudyData) -> dict[str, str]:
    """Return the code of every complete subject, by subject.

    Parameters
    ----------
    key : SecretKey
    data : StudyData
        As stored.

    Examples
    --------
    >>> completion_codes(SecretKey(bytes(32)), StudyData(pd.DataFrame(), pd.DataFrame()))
    {}
    """
    complete = data.subjects[data.subjects["status"] == "complete"]
    trials = _by_subject(data.trials, "trial", "response")
    answers = _by_subject(data.questionnaires, "question", "answer")
    return {
        subject: completion_code(
            key, subject, study_hash, trials.get(subject, []), answers.get(subject, [])
        )
        for subject, study_hash in zip(complete["subject"], complete["study_hash"], strict=True)
    }


def _by_subject(table: pd.DataFrame, name: str, value: str) -> dict[str, list[tuple[Any, str]]]:
    rows: dict[str, list[tuple[Any, str]]] = {}
    for subject, one, what in zip(table["subject"], table[name], table[value], strict=True):
        rows.setdefault(subject, []).append((one, what))
    return rows


def check_codes(
    handed_in: Iterable[tuple[str, str]],
    codes: Mapping[str, str],
    subjects_of_worker: Mapping[str, frozenset[str]] | None = None,
) -> list[CheckedCode]:
    """Return a verdict on every code that was handed in.

    Parameters
    ----------
    handed_in : iterable of (str, str)
        Worker, empty if not known, and code; spaces, hyphens and case do not count.
    codes : mapping of str to str
        From `completion_codes`.
    subjects_of_worker : mapping of str to frozenset of str, optional
        The subjects each worker was; without it, workers are not looked at.

    Examples
    --------
    >>> [one.verdict for one in check_codes([("", "ab c"), ("", "XYZ")], {"s1": "ABC"})]
    ['valid', 'unknown']
    >>> [one.verdict for one in check_codes([("", "ABC"), ("", "ABC")], {"s1": "ABC"})]
    ['valid', 'used twice']
    """
    checked: list[CheckedCode] = []
    used: set[str] = set()
    for worker, code in handed_in:
        subject = _owner(code, codes)
        verdict = _verdict(worker, subject, used, subjects_of_worker)
        if verdict == "valid":  # who hands in another's code does not use it up
            used.add(subject)
        checked.append(CheckedCode(worker, code, subject, verdict))
    return checked


def _owner(code: str, codes: Mapping[str, str]) -> str:
    plain = "".join(code.split()).replace("-", "").upper().encode()
    owner = ""
    for subject, own in codes.items():
        if hmac.compare_digest(own.encode(), plain):
            owner = subject
    return owner


def _verdict(
    worker: str,
    subject: str,
    used: set[str],
    subjects_of_worker: Mapping[str, frozenset[str]] | None,
) -> Verdict:
    if not subject:
        return "unknown"
    if subject in used:
        return "used twice"
    if worker and subjects_of_worker is not None:
        own = subjects_of_worker.get(worker, frozenset())
        if subject not in own:
            return "of another worker" if own else "no such worker"
    return "valid"


def read_codes(path: Path) -> list[tuple[str, str]]:
    r"""Return worker and code of every row of a panel's export that has a code.

    Parameters
    ----------
    path : Path
        A CSV with a column for the code and, if it can be, one for the worker, named as Prolific
        or MTurk name them.

    Raises
    ------
    RelightlabError
        If the file cannot be read as CSV, or has no column for the code.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "export.csv"
    >>> _ = path.write_text("Participant id,Completion code\n5f3a,ABCD\n5f3b,\n")
    >>> read_codes(path)
    [('5f3a', 'ABCD')]
    """
    table = read_csv(path, may_be_empty=True)
    names = {str(name).strip().lower(): str(name) for name in table.columns}
    code = next((names[name] for name in CODE_COLUMNS if name in names), None)
    if code is None:
        raise RelightlabError(
            f"{path} has no column for the code: expected one named {' or '.join(CODE_COLUMNS)}"
        )
    worker = next((names[name] for name in WORKER_COLUMNS if name in names), None)
    codes = table[code].fillna("").str.strip()
    workers = table[worker].fillna("").str.strip() if worker else [""] * len(codes)
    return [(who, one) for who, one in zip(workers, codes, strict=True) if one]
