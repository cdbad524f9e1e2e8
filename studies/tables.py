"""The four tidy tables of a study, and what each of their columns means.

Everything that collects, makes up, reads or analyses answers speaks in these tables: subjects,
trials, questionnaires and events, held together by `StudyData`. The columns are written down once,
in `TABLES`; the data dictionary of an export is made from it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
import pandas as pd

from shading_model.errors import RelightlabError
from studies.table_columns import Column, checked_table

MODES = ("live", "pilot", "simulated", "imported")
STATUSES = ("started", "complete", "returned")
KINDS = ("qualification", "main", "closing")
SIDES = ("left", "right")
CLOSING_TESTS = ("spheres", "perspective")
"""The closing pairs, each with a column ``passed_...`` of the subjects."""
RESPONSES = (*SIDES, "tie")
MARKS = ("simulated", "pilot")
"""Modes that every table, figure and file of such answers must show."""

SUBJECTS = (
    Column("subject", "text", "opaque name of a subject; never an id of a panel"),
    Column("study_hash", "text", "SHA-256 of the study file and its stimuli"),
    Column("task", "text", "the task the subject did; for a foreign set, its name"),
    Column("order", "whole", "number of the schedule; 0 where there is only one"),
    Column("mode", "text", "how the answers came about", choices=MODES),
    Column("status", "text", "how far the session went", choices=STATUSES),
    Column("started", "time", "when the session was opened", missing=True),
    Column("finished", "time", "when it was completed", missing=True),
    Column("gender", "text", "male, female or other words of the subject's own", missing=True),
    Column("age", "number", "age in years; a band is given by its middle", missing=True),
    Column("expertise", "flag", "declared expertise in art or graphics", missing=True),
    Column("passed_spheres", "flag", "chose the plausible pair of spheres", missing=True),
    Column("passed_perspective", "flag", "chose the drawing in true perspective", missing=True),
    Column("display_width", "number", "width of the window in CSS pixels", missing=True),
    Column("display_height", "number", "height of the window in CSS pixels", missing=True),
    Column("pixel_ratio", "number", "device pixels to a CSS pixel", missing=True),
)
TRIALS = (
    Column("subject", "text", "subject, as in the table of subjects"),
    Column("task", "text", "task the trial belongs to"),
    Column("kind", "text", "what the trial is for", choices=KINDS),
    Column("trial", "whole", "place in the subject's schedule, from 0"),
    Column("position", "whole", "place among the subject's trials of that kind, from 1", True),
    Column("pair", "text", "the item: a pair of pictures, the same for all subjects"),
    Column("condition", "text", "whose picture is judged, or against whose"),
    Column("left", "text", "stimulus on the left", missing=True),
    Column("right", "text", "stimulus on the right", missing=True),
    Column(
        "target_side",
        "text",
        "side of the own method; of the real picture in a qualification pair, of the plausible one"
        " in a closing pair",
        missing=True,
        choices=SIDES,
    ),
    Column("response", "text", "what was chosen", missing=True, choices=RESPONSES),
    Column("chose_target", "number", "1 if the target was chosen, 0 if not, 0.5 for a tie"),
    Column("shown_ms", "number", "milliseconds the pair was on view", missing=True),
    Column("reaction_ms", "number", "milliseconds from view to answer", missing=True),
    Column("blur_events", "whole", "times the page lost the focus during the trial", missing=True),
    Column("display_width", "number", "width of the window in CSS pixels", missing=True),
    Column("display_height", "number", "height of the window in CSS pixels", missing=True),
    Column("answered", "time", "when the answer was given", missing=True),
)
QUESTIONNAIRES = (
    Column("subject", "text", "subject, as in the table of subjects"),
    Column("question", "text", "name of the question"),
    Column("answer", "text", "the answer, as it was given", missing=True),
)
EVENTS = (
    Column("subject", "text", "subject, as in the table of subjects"),
    Column("event", "text", "what happened: blur, reload, resize, ..."),
    Column("detail", "text", "more about it", missing=True),
    Column("at", "time", "when", missing=True),
)
TABLES: Mapping[str, tuple[Column, ...]] = MappingProxyType(
    {
        "subjects": SUBJECTS,
        "trials": TRIALS,
        "questionnaires": QUESTIONNAIRES,
        "events": EVENTS,
    }
)
"""The columns of each table, in order."""

KEYS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "subjects": ("subject",),
        "trials": ("subject", "trial"),
        "questionnaires": ("subject", "question"),
    }
)
"""What no two rows of a table have in common; two events may be alike."""


@dataclass(frozen=True, eq=False)
class StudyData:
    """The answers to one study or several, checked when they are made.

    Columns that may hold missing values may be left out; they come back filled with them. Text and
    times are ``str`` columns whose missing value is NaN, numbers are ``float64``, whole numbers
    ``int64`` (``float64`` where one may be missing), flags pandas' ``boolean`` with NA.

    Parameters
    ----------
    subjects, trials : DataFrame
        The columns of `SUBJECTS` and `TRIALS`.
    questionnaires, events : DataFrame, optional
        The columns of `QUESTIONNAIRES` and `EVENTS`; by default no rows.

    Raises
    ------
    RelightlabError
        If a column is unknown, lacking or holds what it must not, a key comes twice, a subject is
        not in the table of subjects, or `chose_target` contradicts the sides.

    Examples
    --------
    >>> subject = {"subject": "s1", "study_hash": "-", "task": "real", "order": 0,
    ...            "mode": "simulated", "status": "complete", "age": 31}
    >>> trial = {"subject": "s1", "task": "real", "kind": "main", "trial": 0, "position": 1,
    ...          "pair": "chair", "condition": "ours", "target_side": "left", "response": "left",
    ...          "chose_target": 1}
    >>> data = StudyData(pd.DataFrame([subject]), pd.DataFrame([trial]))
    >>> data.simulated, data.marks, len(data.questionnaires)
    (True, ('simulated',), 0)
    """

    subjects: pd.DataFrame
    trials: pd.DataFrame
    questionnaires: pd.DataFrame = field(default_factory=pd.DataFrame)
    events: pd.DataFrame = field(default_factory=pd.DataFrame)

    def __post_init__(self) -> None:
        for name, columns in TABLES.items():
            table = checked_table(name, getattr(self, name), columns)
            object.__setattr__(self, name, table)
            _check_keys(name, table)
        known = set(self.subjects["subject"])
        for name in list(TABLES)[1:]:
            strangers = set(self.table(name)["subject"]) - known
            if strangers:
                raise RelightlabError(
                    f"the {name} name the subject {min(strangers)!r}, who is not among the"
                    " subjects: give a row for each subject"
                )
        _check_scores(self.trials)

    @property
    def simulated(self) -> bool:
        """Whether any subject was made up."""
        return "simulated" in self.marks

    @property
    def marks(self) -> tuple[str, ...]:
        """The marks that must be shown with these answers: of `MARKS`, in that order."""
        return tuple(mark for mark in MARKS if (self.subjects["mode"] == mark).any())

    def table(self, name: str) -> pd.DataFrame:
        """Return one of the four tables by its name."""
        table: pd.DataFrame = getattr(self, name)
        return table

    def of_subjects(self, subjects: Iterable[str]) -> StudyData:
        """Return the rows of these subjects alone, in the order they are in."""
        wanted = set(subjects)
        return StudyData(
            *(self.table(name)[self.table(name)["subject"].isin(wanted)] for name in TABLES)
        )


def combined(parts: Iterable[StudyData]) -> StudyData:
    """Return the rows of all parts in one; no two may share a subject.

    Parameters
    ----------
    parts : iterable of StudyData

    Raises
    ------
    RelightlabError
        If a subject is in two parts.

    Examples
    --------
    >>> len(combined([]).trials)
    0
    """
    several = list(parts)
    if not several:
        return StudyData(pd.DataFrame(), pd.DataFrame())
    return StudyData(
        *(pd.concat([part.table(name) for part in several], ignore_index=True) for name in TABLES)
    )


def score(response: pd.Series, target_side: pd.Series) -> pd.Series:
    """Return what `chose_target` must be: 1 for the target's side, 0 for the other, 0.5 for a tie.

    Parameters
    ----------
    response, target_side : Series of str
        NaN where not known.

    Returns
    -------
    Series of float
        NaN where either is not known, unless it was a tie.

    Examples
    --------
    >>> score(pd.Series(["left", "tie", None]), pd.Series(["right", "left", "left"])).tolist()
    [0.0, 0.5, nan]
    """
    values = np.where(response == target_side, 1.0, 0.0)
    values[(response.isna() | target_side.isna()).to_numpy()] = np.nan
    values[(response == "tie").to_numpy(dtype=bool, na_value=False)] = 0.5
    return pd.Series(values, index=response.index)


def closing_results(trials: pd.DataFrame) -> pd.DataFrame:
    """Return which closing tests each subject passed, NA where not taken.

    Parameters
    ----------
    trials : DataFrame
        With ``subject``, ``kind``, ``pair`` and ``chose_target``.

    Returns
    -------
    DataFrame
        ``subject``, ``passed_spheres`` and ``passed_perspective``: those who took any.

    Examples
    --------
    >>> trials = pd.DataFrame({"subject": ["a", "b"], "kind": ["closing", "main"],
    ...                        "pair": "spheres", "chose_target": 1.0})
    >>> closing_results(trials)
      subject  passed_spheres passed_perspective
    0       a            True               <NA>
    """
    closing = trials[(trials["kind"] == "closing") & trials["pair"].isin(CLOSING_TESTS)]
    result = pd.DataFrame({"subject": closing["subject"].unique()})
    for test in CLOSING_TESTS:
        own = closing[closing["pair"] == test].drop_duplicates("subject").set_index("subject")
        passed = (own["chose_target"] == 1).astype("boolean")
        result[f"passed_{test}"] = result["subject"].map(passed).astype("boolean")
    return result


def _check_keys(name: str, table: pd.DataFrame) -> None:
    keys = list(KEYS.get(name, ()))
    twice = table.duplicated(keys).to_numpy() if keys else np.zeros(0, dtype=bool)
    if twice.any():
        row = table.loc[int(np.flatnonzero(twice)[0]), keys]
        which = ", ".join(f"{key} {value!r}" for key, value in row.to_dict().items())
        raise RelightlabError(f"the {name} hold {which} twice: keep one row of it")


def _check_scores(trials: pd.DataFrame) -> None:
    expected = score(trials["response"], trials["target_side"])
    chosen = trials["chose_target"]
    wrong = ((expected != chosen) & expected.notna()) | ~chosen.isin([0.0, 0.5, 1.0])
    if wrong.any():
        row = int(np.flatnonzero(wrong.to_numpy())[0])
        one = trials.loc[row]
        raise RelightlabError(
            f"the trials hold chose_target {one['chose_target']:g} in row {row}, where the response"
            f" is {one['response']} and the target {one['target_side']}: expected 1 for the target,"
            " 0 for the other, 0.5 for a tie"
        )
