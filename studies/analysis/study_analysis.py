"""The whole analysis of a study: exclusions, rates, models and planned tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from studies.analysis.arms import with_arms
from studies.analysis.exclusion_flow import exclusion_flow
from studies.analysis.planned_tests import planned_tests
from studies.analysis.rates import DEVIATION_COLUMNS, RATE_COLUMNS, Row, rate_rows
from studies.analysis.study_models import fit_study_models, strengths_of
from studies.analysis.subpopulations import main_trials, subpopulations
from studies.study_records import AnalysisPlan, Exclusions, Study
from studies.tables import StudyData


@dataclass(frozen=True, eq=False)
class StudyResult:
    """What a study found, as plain rows; None stands for a value that cannot be had.

    Parameters
    ----------
    rates : list of dict
        ``task, condition, group, level, trials, subjects, rate``, and low and high of the
        ``wilson``, ``cluster`` and ``twoway`` intervals, after exclusions.
    deviations : list of dict
        ``task, condition, group, level, mean, deviation``: the paper's own; and
        ``bootstrap_low, bootstrap_high``.
    rates_with_everyone : list of dict
        As `rates` for group ``all``, before exclusions.
    models : list of dict
        ``model, term, estimate, se``.
    tests : list of dict
        ``family, kind, task, condition, group, test, estimate, low, high, p, p_holm, result``.
    exclusions : list of dict
        ``reason, subjects, trials, remaining_subjects, remaining_trials``, in the order applied.
    excluded : list of dict
        ``subject, reason``.
    started : dict
        ``subjects`` and ``trials`` before exclusions.
    notes : list of str
    simulated : bool
        Whether any subject was made up. It must show wherever the numbers do.
    marks : list of str
        ``simulated``, ``pilot``.
    """

    rates: list[Row]
    deviations: list[Row]
    rates_with_everyone: list[Row]
    models: list[Row]
    tests: list[Row]
    exclusions: list[Row]
    excluded: list[Row]
    started: dict[str, int]
    notes: list[str]
    simulated: bool
    marks: list[str]

    def as_dict(self) -> dict[str, Any]:
        """Return all of it as values that JSON knows."""
        return asdict(self)


def analyze(
    data: StudyData,
    plan: AnalysisPlan | None = None,
    exclusions: Exclusions | None = None,
    *,
    families: Mapping[str, str] | None = None,
    others: Mapping[str, str] | None = None,
) -> StudyResult:
    """Analyse the answers to a study as it was planned.

    Parameters
    ----------
    data : StudyData
    plan : AnalysisPlan, optional
        Margin, level, groups and age threshold.
    exclusions : Exclusions, optional
        The preregistered rules.
    families : mapping of str to str, optional
        The family of each task: its tests are corrected together. By default each task is one.
    others : mapping of str to str, optional
        What each task holds its target against: only tasks of one family that hold theirs against
        the same are compared. Also for Bradley and Terry's model.

    Returns
    -------
    StudyResult

    Raises
    ------
    RelightlabError
        If no answers are left, or a group is unknown.

    Examples
    --------
    >>> import pandas as pd
    >>> subject = {"study_hash": "-", "task": "real", "order": 0, "mode": "simulated",
    ...            "status": "complete"}
    >>> trial = {"task": "real", "kind": "main", "condition": "ours"}
    >>> names = ["a", "b", "c"]
    >>> subjects = pd.DataFrame([subject | {"subject": name} for name in names])
    >>> trials = pd.DataFrame([trial | {"subject": name, "trial": place, "pair": str(place),
    ...                                 "chose_target": float((place + index) % 3 == 0)}
    ...                        for index, name in enumerate(names) for place in range(4)])
    >>> result = analyze(StudyData(subjects, trials))
    >>> result.simulated, result.rates[0]["trials"], round(result.rates[0]["rate"], 3)
    (True, 12, 0.333)
    """
    planned = plan or AnalysisPlan()
    flow = exclusion_flow(data, exclusions)
    trials = with_arms(main_trials(flow.kept), families or {}, others or {})
    groups = subpopulations(flow.kept, (*planned.groups, "side"), planned.age_threshold)
    rows = list(rate_rows(trials, groups, planned.alpha))
    models = fit_study_models(trials)
    strengths = strengths_of(trials, others or {}, planned.alpha)
    tested = {name: levels for name, levels in groups.items() if name not in {"side", "half"}}
    return StudyResult(
        rates=_columns(rows, RATE_COLUMNS),
        deviations=_columns(rows, DEVIATION_COLUMNS),
        rates_with_everyone=_everyone(data, planned.alpha),
        models=[*models.rows, *strengths.rows],
        tests=planned_tests(trials, tested, planned),
        exclusions=list(flow.steps),
        excluded=list(flow.excluded),
        started=flow.started,
        notes=[*models.notes, *strengths.notes],
        simulated=data.simulated,
        marks=list(data.marks),
    )


def analyze_study(data: StudyData, study: Study) -> StudyResult:
    """Analyse the answers to a study by its own file.

    Parameters
    ----------
    data : StudyData
    study : Study

    Returns
    -------
    StudyResult

    Raises
    ------
    RelightlabError
        If no answers are left.
    """
    return analyze(
        data,
        study.analysis,
        study.exclusions,
        families={task.name: task.family for task in study.tasks},
        others={task.name: task.other for task in study.tasks},
    )


def _everyone(data: StudyData, alpha: float) -> list[Row]:
    return _columns(list(rate_rows(main_trials(data), {}, alpha)), RATE_COLUMNS)


def _columns(rows: list[Row], names: tuple[str, ...]) -> list[Row]:
    return [{name: row[name] for name in names} for row in rows]
