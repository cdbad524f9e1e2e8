"""The record that the regression gate compares with: one small JSON file for each dataset.

A line holds the errors of one object, setting, detail source and weight rule under every light, so
that a change shows in a diff. The same measurement, reason and day give the same bytes.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from datasets.atomic import atomic_path
from evaluation.gate_measurement import DIGITS, GateMeasurement
from shading_model.errors import RelightlabError

FORMAT = "relightlab gate record 1"
FOLDER = Path(__file__).with_name("baselines")
_TEXTS = ("dataset", "protocol", "content", "fingerprint", "commit")


@dataclass(frozen=True, eq=False)
class Baseline:
    """A measurement that others are held to.

    Parameters
    ----------
    measured : GateMeasurement
    reason : str
        Why it was recorded.
    date : str
        Year, month and day.
    """

    measured: GateMeasurement
    reason: str
    date: str


def new_baseline(measured: GateMeasurement, reason: str, date: str) -> Baseline:
    """Return the record of a measurement.

    Parameters
    ----------
    measured : GateMeasurement
    reason, date : str

    Returns
    -------
    Baseline

    Raises
    ------
    RelightlabError
        If no reason is given, or cells could not be measured.
    """
    if not reason.strip():
        raise RelightlabError("expected --reason to say why these results are the new standard")
    if any(value is None for row in measured.errors.values() for value in row):
        why = measured.reasons[0] if measured.reasons else "not a finite number"
        raise RelightlabError(
            f"not every cell of {measured.dataset} could be measured ({why}):"
            " mend that, then record"
        )
    return Baseline(measured, " ".join(reason.split()), date)


def baseline_path(dataset: str, folder: Path = FOLDER) -> Path:
    """Return the file of a dataset's record.

    Parameters
    ----------
    dataset : str
    folder : Path

    Examples
    --------
    >>> baseline_path("synthetic").name
    'synthetic.json'
    """
    return folder / f"{dataset}.json"


def write_baseline(baseline: Baseline, folder: Path = FOLDER) -> Path:
    """Write a record, in place of an earlier one.

    Parameters
    ----------
    baseline : Baseline
    folder : Path

    Returns
    -------
    Path
        The file.
    """
    path = baseline_path(baseline.measured.dataset, folder)
    with atomic_path(path) as temporary:
        temporary.write_text(baseline_text(baseline), encoding="utf-8")
    return path


def baseline_text(baseline: Baseline) -> str:
    """Return a record as JSON, one line for each head entry and each row of errors.

    Parameters
    ----------
    baseline : Baseline
    """
    measured = baseline.measured
    head: dict[str, Any] = {
        "format": FORMAT,
        "reason": baseline.reason,
        "date": baseline.date,
        **{name: getattr(measured, name) for name in _TEXTS},
        "platform": measured.platform,
        "digits": DIGITS,
    }
    lines = [f" {json.dumps(key)}: {_json(value)}," for key, value in head.items()]
    rows = [f"  {json.dumps(key)}: {_json(list(row))}" for key, row in measured.errors.items()]
    return "\n".join(["{", *lines, ' "errors": {', ",\n".join(rows), " }", "}", ""])


def read_baseline(dataset: str, folder: Path = FOLDER) -> Baseline:
    """Return the record of a dataset.

    Parameters
    ----------
    dataset : str
    folder : Path

    Returns
    -------
    Baseline

    Raises
    ------
    RelightlabError
        If there is none, or the file is no such record.
    """
    path = baseline_path(dataset, folder)
    again = f"record one with 'relightlab gate record --dataset {dataset} --reason \"...\"'"
    try:
        return _baseline(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError as error:
        raise RelightlabError(f"there is no record of {dataset} in {folder}: {again}") from error
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise RelightlabError(f"{path} is damaged, or no {FORMAT!r}: {again}") from error


def _baseline(document: dict[str, Any]) -> Baseline:
    if document["format"] != FORMAT:
        raise ValueError(document["format"])
    texts: dict[str, Any] = {name: str(document[name]) for name in _TEXTS}
    errors = {key: tuple(map(float, row)) for key, row in document["errors"].items()}
    measured = GateMeasurement(**texts, platform=dict(document["platform"]), errors={**errors})
    return Baseline(measured, str(document["reason"]), str(document["date"]))


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
