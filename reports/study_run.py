"""The results of a study's own answers, as its report takes them."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Any

from reports.paper_study import forest_layout, paper_table3
from reports.study_results import mark_of_modes, plain_value
from reports.study_source import read_answers
from shading_model.errors import RelightlabError
from studies.analysis.study_analysis import StudyResult, analyze
from studies.analysis.study_analysis import analyze_study as analyze_planned
from studies.published_study import PUBLISHED, consistency, disagreements
from studies.study_file import load_study
from studies.study_records import Study
from studies.tables import StudyData


def analyze_study(source: str, study_file: Path | None, *, pilot: bool = False) -> dict[str, Any]:
    """Return the results document of the answers in a database or an export.

    Parameters
    ----------
    source : str
        See `reports.study_source.read_answers`.
    study_file : Path or None
        Plans the analysis; without one, it is the paper's.
    pilot : bool
        Analyse pilot sessions alone.

    Returns
    -------
    dict
        See `reports.study_results`.

    Raises
    ------
    RelightlabError
        If there are no answers, or the study is of other answers.
    """
    data = read_answers(source, pilot=pilot)
    study = None if study_file is None else load_study(study_file)
    if study is not None:
        _check_tasks(data, study)
    result = analyze(data) if study is None else analyze_planned(data, study)
    return study_document(data, result, study, Path(source).name)


def study_document(
    data: StudyData, result: StudyResult, study: Study | None, source: str
) -> dict[str, Any]:
    """Return the results document of an analysed study.

    Parameters
    ----------
    data : StudyData
    result : StudyResult
        Of these answers.
    study : Study or None
    source : str
        What the answers were read from.

    Returns
    -------
    dict
        See `reports.study_results`.
    """
    found = plain_value(result.as_dict())
    parts = ("rates", "deviations", "models", "tests", "exclusions", "started")
    layout = paper_table3(found["rates"])
    of_paper = {(row["task"], row["condition"]) for row in found["rates"]}
    return {
        "title": "User study" if study is None else f"User study {study.name}",
        "source": source,
        "mark": mark_of_modes(data.subjects["mode"]),
        "simulated": result.simulated,
        **{part: found[part] for part in parts},
        "notes": [*_other_hash(data, study), *found["notes"]],
        "rates_with_everyone": found["rates_with_everyone"],
        "excluded": found["excluded"],
        "published": [
            row for row in plain_value(PUBLISHED) if (row["task"], row["condition"]) in of_paper
        ],
        "table3": layout,
        "figures": forest_layout(found["rates"]),
        "consistency": plain_value(consistency()) if layout else [],
        "disagreements": disagreements() if layout else [],
        "provenance": _provenance(data, study, source),
    }


def _check_tasks(data: StudyData, study: Study) -> None:
    planned, answered = {task.name for task in study.tasks}, set(data.subjects["task"])
    if not planned & answered:
        raise RelightlabError(
            f"the study {study.name} has the tasks {', '.join(sorted(planned))}, but the answers"
            f" are to {', '.join(sorted(answered))}: give the study file they were collected with"
        )


def _other_hash(data: StudyData, study: Study | None) -> list[str]:
    """Return a note where answers were collected with another content of the study file."""
    if study is None:
        return []
    count = int((data.subjects["study_hash"] != study.hash).sum())
    words = f"{count} of {len(data.subjects)} subjects answered another version of the study file"
    return [f"{words}, or of its pictures"] if count else []


def _provenance(data: StudyData, study: Study | None, source: str) -> dict[str, str]:
    modes = data.subjects["mode"].value_counts()
    hashes = sorted(data.subjects["study_hash"].unique())
    return {
        "relightlab": version("relightlab"),
        "answers": source,
        "plan": "the paper's" if study is None else f"study {study.name}",
        "how the answers came about": ", ".join(f"{mode} {count}" for mode, count in modes.items()),
        "study hash": ", ".join(hashes[:3]) + (", ..." if len(hashes) > 3 else ""),
    }
