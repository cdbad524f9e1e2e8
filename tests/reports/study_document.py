"""A document of a made-up study in the form that the report takes."""

from __future__ import annotations

from typing import Any

import numpy as np

LEVELS = (
    ("all", "all"),
    ("expertise", "expert"),
    ("expertise", "non-expert"),
    ("tests", "passed p-s test"),
    ("tests", "failed p-s test"),
    ("gender", "male"),
    ("gender", "female"),
    ("age", "age ≤ 25"),
    ("age", "age > 25"),
    ("half", "1st half"),
    ("half", "2nd half"),
)
CONDITIONS = (
    ("real", "ours", 0.44),
    ("real", "barron-malik", 0.42),
    ("rivals", "barron-malik", 0.6),
    ("rivals", "karsch", 0.6),
)


def study_document(mark: str = "SIMULATED", **changes: Any) -> dict[str, Any]:
    """Return a document with four conditions, two in Table 3, and some of everything else."""
    rates = [
        rate_row(task, condition, group, level, rate)
        for task, condition, rate in CONDITIONS
        for group, level in (*LEVELS, ("side", "left"), ("side", "right"))
    ]
    keys = ("task", "condition", "group", "level")
    deviations = [
        {key: row[key] for key in keys} | {"mean": row["rate"], "deviation": 0.016} for row in rates
    ]
    published = [
        {key: row[key] for key in keys} | {"trials": 1040, "rate": 0.44, "deviation": 0.015}
        for row in rates
        if row["task"] == "real" and row["group"] != "side"
    ]
    conditions = [
        {"task": task, "condition": condition, "title": f"{task}, {condition}"}
        for task, condition, _ in CONDITIONS
    ]
    document = {
        "title": "A made-up study",
        "source": "answers.csv",
        "mark": mark,
        "simulated": "SIMULATED" in mark,
        "started": {"subjects": 300, "trials": 3000},
        "rates": rates,
        "deviations": deviations,
        "published": published,
        "table3": conditions[:2],
        "figures": [
            {
                "identifier": "study_vs_barron_karsch",
                "title": "Ours against rivals",
                "caption": "As the paper's figure.",
                "conditions": conditions[2:],
            }
        ],
        "models": [
            {"model": "mixed model", "term": "(Intercept)", "estimate": 0.455, "se": 0.137},
            {"model": "mixed model", "term": "sd: subject", "estimate": 0.754, "se": None},
        ],
        "tests": [
            {
                "family": "real",
                "kind": "equivalence",
                "task": "real",
                "condition": "ours",
                "group": "",
                "test": "ours is within 5 points of 50 %",
                "estimate": 0.44,
                "low": 0.41,
                "high": 0.47,
                "p": 0.2,
                "p_holm": 0.4,
                "result": "equivalence not shown",
            }
        ],
        "notes": ["gee was not fitted"],
        "rates_with_everyone": [row for row in rates if row["group"] == "all"],
        "exclusions": [
            {
                "reason": "chose a cartoon",
                "subjects": 6,
                "trials": 60,
                "remaining_subjects": 294,
                "remaining_trials": 2940,
            }
        ],
        "consistency": [
            {
                "task": "real",
                "condition": "ours",
                "group": "all",
                "level": "all",
                "trials": 1040,
                "rate": 0.44,
                "deviation": 0.015,
                "binomial": 0.0154,
                "below": False,
                "finding": "as binomial",
            }
        ],
        "excluded": [],
        "disagreements": ["Two numbers disagree."],
        "provenance": {"relightlab": "0.1.0", "study": "ab" * 32},
    }
    return document | changes


def rate_row(task: str, condition: str, group: str, level: str, rate: float) -> dict[str, Any]:
    """Return a row of rates with intervals around its rate."""
    shift = 0.01 * (len(level) % 5 - 2)
    row: dict[str, Any] = {
        "task": task,
        "condition": condition,
        "group": group,
        "level": level,
        "trials": 1040,
        "subjects": 104,
        "rate": rate + shift,
    }
    for name, half in (("wilson", 0.03), ("cluster", 0.04), ("twoway", 0.06)):
        ends = np.round([rate + shift - half, rate + shift + half], 12).tolist()
        row |= {f"{name}_low": ends[0], f"{name}_high": ends[1]}
    return row
