"""Answers of made-up subjects in the tidy tables, with known effects."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from scipy.special import expit

from studies.tables import StudyData

FIVE_TASKS = {
    "ours-real": "ours",
    "barron-malik-real": "barron-malik",
    "ours-barron-malik": "ours",
    "ours-karsch": "ours",
    "one-layer-none": "one-layer",
}
"""The paper's tasks and the condition whose choice is counted."""
FAMILIES = {
    "ours-real": "against-real",
    "barron-malik-real": "against-real",
    "ours-barron-malik": "against-others",
    "ours-karsch": "against-others",
}
OTHERS = {
    "ours-real": "real",
    "barron-malik-real": "real",
    "ours-barron-malik": "barron-malik",
    "ours-karsch": "karsch",
    "one-layer-none": "no-detail",
}


def made_answers(
    subjects: int,
    generator: np.random.Generator,
    *,
    tasks: Mapping[str, str] | None = None,
    pairs: int = 10,
    log_odds: float = 0.3,
    left: float = 0.0,
    subject_deviation: float = 0.5,
    item_deviation: float = 0.4,
) -> StudyData:
    """Return the answers of subjects, each of whom sees all pairs of one task once."""
    conditions = dict(tasks or FIVE_TASKS)
    people = _people(subjects, list(conditions), generator)
    rows = np.repeat(np.arange(subjects), pairs)
    trials = people.loc[rows, ["subject", "task"]].reset_index(drop=True)
    items = np.concatenate([generator.permutation(pairs) for _ in range(subjects)])
    on_left = generator.random(len(rows)) < 0.5
    chance = expit(
        log_odds
        + left * (on_left - 0.5)
        + subject_deviation * generator.normal(size=subjects)[rows]
        + item_deviation * generator.normal(size=pairs)[items]
    )
    chose = generator.random(len(rows)) < chance
    trials = trials.assign(
        kind="main",
        trial=np.tile(np.arange(pairs), subjects),
        position=np.tile(np.arange(pairs) + 1, subjects),
        pair=[f"pair-{item}" for item in items],
        condition=trials["task"].map(conditions),
        target_side=np.where(on_left, "left", "right"),
        response=np.where(chose == on_left, "left", "right"),
        chose_target=chose.astype(float),
        reaction_ms=generator.uniform(500, 4000, len(rows)).round(),
        blur_events=0,
    )
    return StudyData(people, trials)


def _people(count: int, tasks: list[str], generator: np.random.Generator) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "subject": [f"s{number:04d}" for number in range(count)],
            "study_hash": "-",
            "task": [tasks[number % len(tasks)] for number in range(count)],
            "order": 0,
            "mode": "simulated",
            "status": "complete",
            "gender": generator.choice(["male", "female"], count),
            "age": generator.integers(18, 60, count),
            "expertise": generator.random(count) < 0.4,
            "passed_spheres": generator.random(count) < 0.8,
            "passed_perspective": generator.random(count) < 0.8,
        }
    )


def answer_grid(
    subjects: int = 12, trials: int = 8, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Return outcomes and subjects, as many trials of each."""
    rng = np.random.default_rng(seed)
    chance = rng.uniform(0.2, 0.9, subjects)
    subject = np.repeat(np.arange(subjects), trials)
    return (rng.random(subjects * trials) < chance[subject]).astype(float), subject
