"""A study in one TOML file, read into the records of `studies.study_records`."""

from __future__ import annotations

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
]
