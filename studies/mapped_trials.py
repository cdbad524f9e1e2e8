"""The choices of a foreign file in the terms of this project, and the models its mapping plans."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from shading_model.errors import RelightlabError, unknown_name
from studies.analysis.rates import Row
from studies.analysis.rates import rate_rows as trial_rates
from studies.trial_mapping import TrialMapping

SIDES = ("left", "right")
ALPHA = 0.05
"""Intervals cover 1 - ALPHA."""
HALVES = ("1st half", "2nd half")
TRUE, FALSE = {"1", "1.0", "true", "yes"}, {"0", "0.0", "false", "no"}


@dataclass(frozen=True, eq=False)
class MappedTrials:
    """The choices of a file.

    Parameters
    ----------
    frame : DataFrame
        The file's columns and those made of them, its outcome as numbers from 0 to 1.
    trials : DataFrame
        ``subject, pair, condition, chose_target``, and ``side`` and ``half`` where they are known;
        one row for each of `frame`.
    groups : tuple of str
        Columns of `frame` to give rates by.
    exclusions : tuple of rows
        Who was left out: ``reason, subjects, trials, remaining_subjects, remaining_trials``.
    started : mapping
        ``subjects`` and ``trials`` of the whole file.
    """

    frame: pd.DataFrame
    trials: pd.DataFrame
    groups: tuple[str, ...]
    exclusions: tuple[Row, ...]
    started: Mapping[str, int]


def read_mapped(path: str | os.PathLike[str], mapping: TrialMapping) -> MappedTrials:
    """Return the choices of a CSV file.

    Parameters
    ----------
    path : path
    mapping : TrialMapping

    Returns
    -------
    MappedTrials

    Raises
    ------
    RelightlabError
        If the file cannot be read, lacks a column or holds what it must not.
    """
    try:
        frame = pd.read_csv(Path(path), dtype=str, keep_default_na=False, na_values=[""])
    except OSError as error:
        raise RelightlabError(f"cannot read {path}: {error.strerror}") from error
    except (ValueError, pd.errors.ParserError) as error:
        raise RelightlabError(f"{path} is not a CSV file with a header: {error}") from error
    return mapped(frame, mapping)


def mapped(frame: pd.DataFrame, mapping: TrialMapping) -> MappedTrials:
    """Return the choices of a table of texts.

    Parameters
    ----------
    frame : DataFrame
        Every column of texts, NaN where a cell is empty.
    mapping : TrialMapping

    Returns
    -------
    MappedTrials

    Raises
    ------
    RelightlabError
        If a column lacks, a row has no subject, item or outcome, an outcome is no number from 0 to
        1, or no row is left.

    Examples
    --------
    >>> from studies.trial_mapping import mapping_of
    >>> columns = {"subject": "who", "item": "pair", "outcome": "chose"}
    >>> frame = pd.DataFrame({"who": ["a", "b"], "pair": ["p", "p"], "chose": ["1", "0"]})
    >>> mapped(frame, mapping_of({"columns": columns})).trials["chose_target"].tolist()
    [1.0, 0.0]
    """
    for name in mapping.columns():
        if name not in frame:
            raise unknown_name("column that the mapping names", name, list(frame.columns))
    kept, exclusions = _kept(frame, mapping)
    if kept.empty:
        raise RelightlabError("no row is left to analyse: look at [keep] of the mapping")
    made = {
        column.name: kept[column.column].map(
            lambda word, column=column: column.values.get(word, column.otherwise)
        )
        for column in mapping.made
    }
    whole = kept.assign(**made, **{mapping.outcome: _outcomes(kept, mapping.outcome)})
    return MappedTrials(
        frame=whole,
        trials=_trials(whole, mapping),
        groups=mapping.groups,
        exclusions=exclusions,
        started=_size(frame, mapping),
    )


def rate_rows(mapped_trials: MappedTrials, task: str) -> Iterator[Row]:
    """Yield the rates of every condition, with the paper's deviation.

    Parameters
    ----------
    mapped_trials : MappedTrials
    task : str
        What the rows have as their task.

    Yields
    ------
    dict
        As `studies.analysis.rates.rate_rows` gives them.
    """
    trials, frame = mapped_trials.trials, mapped_trials.frame
    groups = {name: frame[name] for name in mapped_trials.groups}
    groups |= {name: trials[name] for name in ("half", "side") if name in trials}
    levels = {name: column.astype("category") for name, column in groups.items()}
    yield from trial_rates(trials.assign(task=task), levels, ALPHA)


def _kept(frame: pd.DataFrame, mapping: TrialMapping) -> tuple[pd.DataFrame, tuple[Row, ...]]:
    steps: list[Row] = []
    for name, words in mapping.keep.items():
        chosen = frame[frame[name].isin(words)]
        before, after = _size(frame, mapping), _size(chosen, mapping)
        gone = {key: before[key] - after[key] for key in before}
        remaining = {f"remaining_{key}": value for key, value in after.items()}
        steps.append({"reason": f"{name} is not {' or '.join(words)}", **gone, **remaining})
        frame = chosen
    return frame, tuple(steps)


def _size(frame: pd.DataFrame, mapping: TrialMapping) -> dict[str, int]:
    return {"subjects": int(frame[mapping.subject].nunique()), "trials": len(frame)}


def _outcomes(frame: pd.DataFrame, name: str) -> pd.Series:
    words = frame[name].str.strip().str.lower()
    texts = words.map(dict.fromkeys(TRUE, "1") | dict.fromkeys(FALSE, "0")).fillna(words)
    numbers = pd.to_numeric(texts, errors="coerce")
    wrong = ~numbers.between(0, 1)
    if wrong.any():
        row = int(np.flatnonzero(wrong)[0])
        raise RelightlabError(
            f"expected numbers from 0 to 1 in the column {name!r}, got {frame[name].iloc[row]!r}"
            f" in row {int(frame.index[row]) + 2}"
        )
    return numbers.astype(float)


def _trials(frame: pd.DataFrame, mapping: TrialMapping) -> pd.DataFrame:
    trials = pd.DataFrame({"chose_target": frame[mapping.outcome]})
    names = {"subject": mapping.subject, "pair": mapping.item, "condition": mapping.condition}
    for key, name in names.items():
        trials[key] = frame[name] if name else ""
        if trials[key].isna().any():
            raise RelightlabError(f"expected a value in every row of the column {name!r}")
    if mapping.side:
        trials["side"] = _sides(frame[mapping.side], mapping.left)
    if mapping.position:
        trials["half"] = _halves(frame[mapping.position], trials["subject"])
    return trials


def _sides(column: pd.Series, left: str) -> pd.Series:
    if left not in set(column):
        raise unknown_name(f"value of the column {column.name!r}", left, set(column.dropna()))
    return column.map(lambda word: SIDES[word != left], na_action="ignore")


def _halves(column: pd.Series, subject: pd.Series) -> pd.Series:
    """Return the half of its subject's answers that each is in; the middle one is in the first."""
    positions = pd.to_numeric(column, errors="coerce")
    if positions.isna().any():
        raise RelightlabError(f"expected numbers in every row of the column {column.name!r}")
    ranks = positions.groupby(subject).rank(method="first")
    counts = ranks.groupby(subject).transform("max")
    return (ranks > (counts + 1) // 2).map(lambda late: HALVES[int(late)])
