"""Who is left out of the analysis, by which rule fixed beforehand, and what remains."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import pandas as pd

from shading_model.errors import RelightlabError
from studies.analysis.rates import Row
from studies.analysis.subpopulations import main_trials
from studies.study_records import Exclusions
from studies.tables import StudyData


@dataclass(frozen=True, eq=False)
class ExclusionFlow:
    """What the rules leave.

    Parameters
    ----------
    kept : StudyData
    started : dict
        ``subjects`` and main ``trials`` before any rule.
    steps : tuple of dict
        A row for each rule, in the order applied, also where it leaves nobody out: ``reason,
        subjects, trials, remaining_subjects, remaining_trials``.
    excluded : tuple of dict
        ``subject, reason``: the first rule that leaves the subject out.
    """

    kept: StudyData
    started: dict[str, int]
    steps: tuple[Row, ...]
    excluded: tuple[Row, ...]


def exclusion_flow(data: StudyData, rules: Exclusions | None = None) -> ExclusionFlow:
    """Apply the rules one after the other.

    Pilot sessions never count where there are others. Then, as far as the rules ask: who did not
    finish, who chose a cartoon in a qualification pair, who answered too fast, who kept to one
    side, who left the window too often. A subject of whom a rule's value is not known stays.

    Parameters
    ----------
    data : StudyData
    rules : Exclusions, optional

    Returns
    -------
    ExclusionFlow

    Raises
    ------
    RelightlabError
        If nobody is left.

    Examples
    --------
    >>> subject = {"study_hash": "-", "task": "real", "order": 0, "mode": "simulated"}
    >>> subjects = pd.DataFrame([subject | {"subject": "a", "status": "complete"},
    ...                          subject | {"subject": "b", "status": "started"}])
    >>> trial = {"subject": "a", "task": "real", "kind": "main", "trial": 0, "pair": "chair",
    ...          "condition": "ours", "chose_target": 1}
    >>> flow = exclusion_flow(StudyData(subjects, pd.DataFrame([trial])))
    >>> [(step["reason"], step["subjects"]) for step in flow.steps]
    [('did not finish', 1), ('chose a cartoon as real', 0)]
    """
    main = main_trials(data)
    remaining = set(data.subjects["subject"])
    sizes = main.groupby("subject").size()
    started = {"subjects": len(remaining), "trials": len(main)}
    steps: list[Row] = []
    excluded: list[Row] = []
    for reason, failing in _rules(data, main, rules or Exclusions()):
        gone = sorted(remaining & failing)
        remaining -= failing
        steps.append(
            {
                "reason": reason,
                "subjects": len(gone),
                "trials": int(sizes.reindex(gone).sum()),
                "remaining_subjects": len(remaining),
                "remaining_trials": int(sizes.reindex(sorted(remaining)).sum()),
            }
        )
        excluded += [{"subject": subject, "reason": reason} for subject in gone]
    if not remaining or not sizes.reindex(sorted(remaining)).sum():
        raise RelightlabError(
            f"no answers are left of {started['trials']} by {started['subjects']} subjects: look at"
            " the study's exclusions, or wait for complete sessions"
        )
    return ExclusionFlow(data.of_subjects(remaining), started, tuple(steps), tuple(excluded))


def _rules(
    data: StudyData, main: pd.DataFrame, rules: Exclusions
) -> Iterator[tuple[str, set[str]]]:
    subjects = data.subjects
    pilot = subjects["mode"] == "pilot"
    if pilot.any() and not pilot.all():
        yield "pilot session", set(subjects.loc[pilot, "subject"])
    if rules.complete_only:
        yield "did not finish", set(subjects.loc[subjects["status"] != "complete", "subject"])
    if rules.qualification_all_correct:
        checks = data.trials[data.trials["kind"] == "qualification"]
        yield "chose a cartoon as real", set(checks.loc[checks["chose_target"] < 1, "subject"])
    if rules.minimum_median_ms is not None:
        median = main.groupby("subject")["reaction_ms"].median()
        words = f"median reaction time below {rules.minimum_median_ms:g} ms"
        yield words, set(median.index[median < rules.minimum_median_ms])
    if rules.maximum_same_side is not None:
        words = f"more than {100 * rules.maximum_same_side:g} % of answers on one side"
        yield words, _one_sided(main, rules.maximum_same_side)
    if rules.maximum_blur_events is not None:
        blurs = main.groupby("subject")["blur_events"].sum(min_count=1)
        words = f"left the window more than {rules.maximum_blur_events} times"
        yield words, set(blurs.index[blurs > rules.maximum_blur_events])


def _one_sided(main: pd.DataFrame, share: float) -> set[str]:
    answered = main[main["response"].notna()]
    counts = answered.groupby(["subject", "response"]).size().unstack(fill_value=0)
    sides = counts.reindex(columns=["left", "right"], fill_value=0)
    return set(counts.index[sides.max(axis=1) > share * counts.sum(axis=1)])
