"""Two published sets of answers in the tidy tables: dynavect-2afc and gengap-realfake."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from studies.foreign_rows import (
    imported_subjects,
    long_answers,
    one_row_each,
    open_foreign,
    subject_namer,
)
from studies.tables import StudyData

DYNAVECT = "dynavect-2afc"
GENGAP = "gengap-realfake"
DYNAVECT_FILE = "dynavect_trials.csv"
GENGAP_FILE = "gengap_trials.csv"

_SIDES = {"A": "left", "B": "right"}
_YES_NO = {"0": 0.0, "1": 1.0}
_CHECK = {"künstlich generiert": 1.0, "echt": 0.0}
_BAND_MIDDLE = {"20-29": 25.0, "30-39": 35.0, "40-49": 45.0, "50-59": 55.0, "60-69": 65.0}
_DYNAVECT_COLUMNS = (
    "worker", "question", "position", "image_A", "image_B", "baseline", "ours_side", "answer",
    "chose_ours", "work_time_s",
)  # fmt: skip
_GENGAP_COLUMNS = (
    "subject", "age_band", "gender", "validation_item", "complete", "conf_real", "conf_fake",
    "image", "image_type", "correct", "rt_s",
)  # fmt: skip


def read_dynavect(path: Path) -> StudyData:
    """Return the 3147 choices of 58 workers between one method and two baselines.

    The condition of a trial is its baseline; image A was on the left. The order was the same for
    everybody, so that position and item cannot be told apart. The time of the whole assignment is
    in the questionnaires.

    Parameters
    ----------
    path : Path
        ``dynavect_trials.csv``.

    Returns
    -------
    StudyData
        Subjects of mode ``imported`` whose names depend on the file's own names alone.

    Raises
    ------
    RelightlabError
        If the file cannot be read or holds what it should not.
    """
    file = open_foreign(path, _DYNAVECT_COLUMNS)
    subject = file.texts("worker").map(subject_namer(DYNAVECT, None))
    position = file.numbers("position")
    trials = pd.DataFrame(
        {
            "subject": subject,
            "task": DYNAVECT,
            "kind": "main",
            "trial": position - 1,
            "position": position,
            "pair": file.texts("question"),
            "condition": file.texts("baseline"),
            "left": file.texts("image_A"),
            "right": file.texts("image_B"),
            "target_side": file.words("ours_side", _SIDES),
            "response": file.words("answer", _SIDES),
            "chose_target": file.words("chose_ours", _YES_NO),
        }
    )
    told = pd.DataFrame({"subject": subject, "work_time_s": file.optional("work_time_s")})
    each = one_row_each(told, path)
    return StudyData(
        imported_subjects(each[["subject"]], DYNAVECT), trials, long_answers(each, ["work_time_s"])
    )


def read_gengap(path: Path) -> StudyData:
    """Return the 7200 judgements of 120 people whether a photograph is real.

    One picture was shown at a time, so there are no sides; `chose_target` says whether the
    judgement was right, the condition whether the picture was ``real`` or ``artificial``. The
    order of presentation is not known: `trial` counts the file's rows. The attention check comes
    last, as a qualification trial. Ages are the middles of bands; the band itself is in the
    questionnaires, with the confidences in German.

    Parameters
    ----------
    path : Path
        ``gengap_trials.csv``.

    Returns
    -------
    StudyData
        Subjects of mode ``imported``.

    Raises
    ------
    RelightlabError
        If the file cannot be read or holds what it should not.
    """
    file = open_foreign(path, _GENGAP_COLUMNS)
    subject = file.texts("subject").map(subject_namer(GENGAP, None))
    told = pd.DataFrame(
        {
            "subject": subject,
            "gender": file.optional("gender"),
            "age": file.words("age_band", _BAND_MIDDLE),
            "status": file.words("complete", {"1": "complete", "0": "started"}),
            "check": file.words("validation_item", _CHECK),
            **{name: file.optional(name) for name in ("age_band", "conf_real", "conf_fake")},
        }
    )
    each = one_row_each(told, path)
    trials = pd.DataFrame(
        {
            "subject": subject,
            "task": GENGAP,
            "kind": "main",
            "trial": subject.groupby(subject).cumcount(),
            "pair": file.texts("image"),
            "condition": file.words("image_type", {"real": "real", "artificial": "artificial"}),
            "chose_target": file.words("correct", _YES_NO),
            "reaction_ms": file.numbers("rt_s", scale=1000),
        }
    )
    checks = pd.DataFrame(
        {
            "subject": each["subject"],
            "task": GENGAP,
            "kind": "qualification",
            "trial": each["subject"].map(subject.value_counts()),
            "position": 1,
            "pair": "validation_item",
            "condition": "qualification",
            "chose_target": each["check"],
        }
    )
    subjects = imported_subjects(each[["subject", "gender", "age", "status"]], GENGAP)
    questions = ["age_band", "conf_real", "conf_fake"]
    return StudyData(subjects, pd.concat([trials, checks]), long_answers(each, questions))
