"""The results of a foreign file of choices, as the report of a study takes them."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Any

from reports.paper_study import forest_layout
from reports.study_results import (
    chosen_keys,
    mark_of_modes,
    plain_value,
)
from studies.analysis.rates import DEVIATION_COLUMNS, RATE_COLUMNS
from studies.mapped_models import model_rows
from studies.mapped_trials import MappedTrials, rate_rows, read_mapped
from studies.trial_mapping import TrialMapping, read_mapping

MODE = "mode"
"""The column by which an export says of every answer whether it is a pilot's or made up."""


def analyze_foreign(path: Path, mapping_file: Path) -> dict[str, Any]:
    """Return the results document of a CSV file whose columns a mapping explains.

    Parameters
    ----------
    path, mapping_file : Path

    Returns
    -------
    dict
        See `reports.study_results`; rates and models alone.

    Raises
    ------
    RelightlabError
        If a file cannot be read or does not fit the other, or a model cannot be fitted.
    """
    mapping = read_mapping(mapping_file)
    return foreign_document(read_mapped(path, mapping), mapping, path.name)


def foreign_document(trials: MappedTrials, mapping: TrialMapping, source: str) -> dict[str, Any]:
    """Return the results document of choices that were read.

    Parameters
    ----------
    trials : MappedTrials
    mapping : TrialMapping
    source : str
        Name of the file.

    Returns
    -------
    dict

    Raises
    ------
    RelightlabError
        If a model cannot be fitted.
    """
    modes = set(trials.frame[MODE].dropna()) if MODE in trials.frame else set()
    mark = mark_of_modes(modes)
    rates = [plain_value(row) for row in rate_rows(trials, mapping.name or Path(source).stem)]
    return {
        "title": mapping.title,
        "source": source,
        "mark": mark,
        "simulated": "simulated" in modes,
        "started": dict(trials.started),
        "rates": chosen_keys(rates, RATE_COLUMNS),
        "deviations": chosen_keys(rates, DEVIATION_COLUMNS),
        "published": [],
        "table3": [],
        "figures": forest_layout(rates),
        "models": [plain_value(row) for row in model_rows(trials, mapping)],
        "notes": [],
        "tests": [],
        "rates_with_everyone": [],
        "exclusions": [plain_value(step) for step in trials.exclusions],
        "excluded": [],
        "consistency": [],
        "disagreements": [],
        "provenance": {
            "relightlab": version("relightlab"),
            "file": source,
            "subject": mapping.subject,
            "item": mapping.item,
            "outcome": mapping.outcome,
        }
        | {f"model {model.name}": model.formula for model in mapping.models},
    }
