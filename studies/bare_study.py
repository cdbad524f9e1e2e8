"""A study without pictures, to plan with, to try schedules on and to simulate."""

from __future__ import annotations

from pathlib import Path

from studies.study_pairs import CLOSING_TESTS
from studies.study_records import (
    AnalysisPlan,
    ClosingPair,
    Exclusions,
    Pair,
    Recruitment,
    Study,
    Task,
    TrialSettings,
)


def bare_study(
    pairs: int = 10,
    tasks: int = 1,
    qualification: int = 4,
    *,
    closing: bool = True,
    pairs_per_subject: int | None = None,
    folder: Path = Path(),
) -> Study:
    """Return a study whose pictures have names but need not be there.

    Parameters
    ----------
    pairs : int
        Of each task.
    tasks : int
    qualification : int
        Qualification pairs.
    closing : bool
        Whether the two closing pairs are shown.
    pairs_per_subject : int, optional
    folder : Path
        Where its pictures would be.

    Returns
    -------
    Study
        Its hash is empty.

    Examples
    --------
    >>> study = bare_study(pairs=2, tasks=3)
    >>> [task.name for task in study.tasks], study.tasks[0].pairs[1].target
    (['task-1', 'task-2', 'task-3'], 'task-1/pair-2-a.png')
    """
    return Study(
        name="bare",
        title="A study without pictures",
        seed=0,
        consent="Consent.",
        instructions="Instructions.",
        tasks=tuple(_task(f"task-{number}", pairs) for number in range(1, tasks + 1)),
        qualification=_pairs("qualification", qualification),
        closing=tuple(_closing(name) for name in CLOSING_TESTS) if closing else (),
        questionnaire=(),
        recruitment=Recruitment(),
        exclusions=Exclusions(),
        analysis=AnalysisPlan(),
        settings=TrialSettings(pairs_per_subject=pairs_per_subject),
        folder=folder,
        hash="",
    )


def _task(name: str, pairs: int) -> Task:
    return Task(name, name, "ours", "other", _pairs(name, pairs), name)


def _pairs(place: str, count: int) -> tuple[Pair, ...]:
    stems = [f"pair-{number}" for number in range(1, count + 1)]
    return tuple(Pair(stem, f"{place}/{stem}-a.png", f"{place}/{stem}-b.png") for stem in stems)


def _closing(name: str) -> ClosingPair:
    return ClosingPair(name, f"closing/{name}-a.png", f"closing/{name}-b.png")
