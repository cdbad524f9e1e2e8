"""Simulated answers to a whole study, marked as such in every table they get into."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import pandas as pd

from shading_model.errors import RelightlabError
from studies.observers import Observer, ObserverAnswers, ObserverModel, ShownTrial, identity_of
from studies.questionnaire_answers import subject_columns
from studies.response_store import ResponseStore
from studies.schedules import Schedule, ScheduledTrial, least_filled, make_schedules
from studies.study_records import Study
from studies.tables import MODES, StudyData, closing_results, score

DISPLAY = {"display_width": 1440.0, "display_height": 900.0}
MOST_SUBJECTS = 100_000


def simulate(
    study: Study, subjects: int, model: ObserverModel | None = None, *, seed: int = 0
) -> StudyData:
    """Return the answers of simulated observers, each on the least filled schedule.

    Parameters
    ----------
    study : Study
        Its pictures are not needed.
    subjects : int
    model : ObserverModel, optional
    seed : int
        With the same seed the first subjects are the same, however many come after them.

    Returns
    -------
    StudyData
        Of mode ``simulated``; no clock is read, so times are missing.

    Raises
    ------
    RelightlabError
        If the number of subjects is not from 1 to 100000.

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> data = simulate(bare_study(pairs=10, tasks=2), 4)
    >>> data.simulated, len(data.subjects), len(data.trials)
    (True, 4, 64)
    """
    if not 1 <= subjects <= MOST_SUBJECTS:
        raise RelightlabError(f"expected from 1 to {MOST_SUBJECTS} subjects, got {subjects}")
    assigned = _assigned(study, subjects)
    rows = [
        _subject_rows(Observer(study, model or ObserverModel(), seed, number), schedule)
        for number, schedule in enumerate(assigned)
    ]
    trials = pd.DataFrame([row for _, answered, _ in rows for row in answered])
    trials["chose_target"] = score(trials["response"], trials["target_side"])
    people = pd.DataFrame([subject for subject, _, _ in rows])
    answers = [row for _, _, told in rows for row in told]
    tests = closing_results(trials)
    return StudyData(people.merge(tests, how="left", on="subject"), trials, pd.DataFrame(answers))


def write_apart(store: ResponseStore, data: StudyData) -> dict[str, int]:
    """Add answers to a store, simulated ones never among those of people, and return rows added.

    Parameters
    ----------
    store : ResponseStore
    data : StudyData

    Returns
    -------
    dict of str to int
        By table; what was there already is not counted.

    Raises
    ------
    RelightlabError
        If the store and the data together would hold answers of both kinds.
    """
    modes = {*store.read(MODES).subjects["mode"], *data.subjects["mode"]}
    if "simulated" in modes and len(modes) > 1:
        raise RelightlabError(
            f"the database {store.database.url} would hold simulated answers beside others, which"
            " nobody could tell apart in a rate: name another database"
        )
    return store.write(data)


def shown_trials(entries: Sequence[ScheduledTrial]) -> list[ShownTrial]:
    """Return a schedule's trials with their positions.

    Parameters
    ----------
    entries : sequence of ScheduledTrial

    Examples
    --------
    >>> entry = ScheduledTrial("main", "chair", "a.png", "b.png", "left", "ours")
    >>> shown_trials([entry, entry])[1].position
    2
    """
    seen: Counter[str] = Counter()
    trials = []
    for entry in entries:
        seen[entry.kind] += 1
        trials.append(ShownTrial(entry.kind, entry.pair, entry.target_side, seen[entry.kind]))
    return trials


def _assigned(study: Study, subjects: int) -> Iterator[Schedule]:
    book = {(schedule.task, schedule.order): schedule for schedule in make_schedules(study)}
    done: Counter[tuple[str, int]] = Counter()
    for _ in range(subjects):
        cell = least_filled(study, done)
        done[cell] += 1
        yield book[cell]


def _subject_rows(
    observer: Observer, schedule: Schedule
) -> tuple[dict[str, Any], list[dict[str, Any]], list[dict[str, str]]]:
    shown = shown_trials(schedule.entries)
    answers = observer.answers(schedule.task, shown)
    complete = answers.stops_after == len(shown)
    told = observer.questionnaire() if complete else {}
    subject = {
        "subject": observer.name,
        "study_hash": identity_of(observer.study),
        "task": schedule.task,
        "order": schedule.order,
        "mode": "simulated",
        "status": "complete" if complete else "started",
        **subject_columns(told),
        **DISPLAY,
        "pixel_ratio": 1.0,
    }
    trials = list(_trial_rows(observer.name, schedule, shown, answers))
    return (
        subject,
        trials,
        [
            {"subject": observer.name, "question": name, "answer": text}
            for name, text in told.items()
        ],
    )


def _trial_rows(
    subject: str, schedule: Schedule, shown: Sequence[ShownTrial], answers: ObserverAnswers
) -> Iterator[dict[str, Any]]:
    for index in range(answers.stops_after):
        yield {
            "subject": subject,
            "task": schedule.task,
            "trial": index,
            "position": shown[index].position,
            **vars(schedule.entries[index]),
            "response": answers.response[index],
            "shown_ms": answers.reaction_ms[index],
            "reaction_ms": answers.reaction_ms[index],
            "blur_events": 0,
            **DISPLAY,
        }
