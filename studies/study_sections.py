"""The settings in a study file, each section read into its record."""

from __future__ import annotations

from dataclasses import fields
from typing import cast
from urllib.parse import urlsplit

from shading_model.errors import RelightlabError, unknown_name
from studies.study_pairs import MOST_PAIRS
from studies.study_records import (
    AnalysisPlan,
    Exclusions,
    Question,
    QuestionKind,
    Recruitment,
    TrialSettings,
)
from studies.toml_table import TomlTable

QUESTION_KEYS = tuple(field.name for field in fields(Question))
TRIAL_KEYS = tuple(field.name for field in fields(TrialSettings))
RECRUITMENT_KEYS = tuple(field.name for field in fields(Recruitment))
EXCLUSION_KEYS = tuple(field.name for field in fields(Exclusions))
ANALYSIS_KEYS = tuple(field.name for field in fields(AnalysisPlan))

QUESTION_KINDS = ("choice", "number", "text")
OWNERS = {
    "options": "choice",
    "minimum": "number",
    "maximum": "number",
    "maximum_length": "text",
}
"""The kind of question that a key belongs to."""


def read_question(table: TomlTable) -> Question:
    """Return one of ``[[questionnaire]]``.

    Parameters
    ----------
    table : TomlTable

    Returns
    -------
    Question

    Raises
    ------
    RelightlabError
        If a value is wrong or missing, or a key does not belong to the kind.

    Examples
    --------
    >>> from studies.toml_table import checked_table
    >>> values = {"name": "age", "text": "Your age?", "kind": "number", "minimum": 18}
    >>> question = read_question(checked_table(values, "[[questionnaire]] age", QUESTION_KEYS))
    >>> question.minimum, question.required
    (18.0, False)
    """
    kind = cast(QuestionKind, table.choice("kind", QUESTION_KINDS))
    for key, owner in OWNERS.items():
        if key in table.values and kind != owner:
            raise RelightlabError(
                f"{table.place}: {key} belongs to a question of kind {owner!r}, not {kind!r}"
            )
    options = table.texts("options") if kind == "choice" else ()
    if kind == "choice" and len(options) < 2:
        raise table.fault("options", "at least two texts")
    low = table.optional_number("minimum", -1e9, 1e9)
    high = table.optional_number("maximum", -1e9, 1e9)
    if low is not None and high is not None and low >= high:
        raise table.fault("maximum", f"more than minimum, {low:g}")
    return Question(
        table.name("name"),
        table.text("text"),
        kind,
        options,
        table.flag("required", default=False),
        low,
        high,
        table.whole("maximum_length", 1, 20_000, default=2000),
    )


def read_trials(table: TomlTable) -> TrialSettings:
    """Return ``[trials]``.

    Parameters
    ----------
    table : TomlTable

    Returns
    -------
    TrialSettings

    Examples
    --------
    >>> from studies.toml_table import checked_table
    >>> read_trials(checked_table({}, "[trials]", TRIAL_KEYS)) == TrialSettings()
    True
    """
    usual = TrialSettings()
    return TrialSettings(
        table.text("question", default=usual.question),
        table.whole("minimum_view_ms", 0, 60_000, default=usual.minimum_view_ms),
        table.flag("allow_tie", default=usual.allow_tie),
        table.optional_whole("pairs_per_subject", 1, MOST_PAIRS),
        table.whole("minimum_width", 200, 10_000, default=usual.minimum_width),
        table.whole("minimum_height", 200, 10_000, default=usual.minimum_height),
        table.flag("allow_touch", default=usual.allow_touch),
    )


def read_recruitment(table: TomlTable) -> Recruitment:
    """Return ``[recruitment]``.

    Parameters
    ----------
    table : TomlTable

    Returns
    -------
    Recruitment

    Raises
    ------
    RelightlabError
        If the address is not one of the web, or a parameter could not stand in one.

    Examples
    --------
    >>> from studies.toml_table import checked_table
    >>> values = {"id_parameters": ["PROLIFIC_PID", "STUDY_ID", "SESSION_ID"]}
    >>> read_recruitment(checked_table(values, "[recruitment]", RECRUITMENT_KEYS)).id_parameters
    ('PROLIFIC_PID', 'STUDY_ID', 'SESSION_ID')
    """
    address = table.text("completion_url", default="")
    if address and not _is_web_address(address):
        raise table.fault("completion_url", "an address that starts with https:// or http://")
    parameters = table.texts("id_parameters", default=())
    if not all(one.isascii() and one.replace("-", "_").isidentifier() for one in parameters):
        raise table.fault("id_parameters", "names of letters, digits, '_' and '-'")
    return Recruitment(address, parameters)


def _is_web_address(address: str) -> bool:
    try:
        parts = urlsplit(address)
    except ValueError:
        return False
    return parts.scheme in {"http", "https"} and bool(parts.hostname) and " " not in address


def read_exclusions(table: TomlTable) -> Exclusions:
    """Return ``[exclusions]``.

    Parameters
    ----------
    table : TomlTable

    Returns
    -------
    Exclusions

    Examples
    --------
    >>> from studies.toml_table import checked_table
    >>> read_exclusions(checked_table({}, "[exclusions]", EXCLUSION_KEYS)) == Exclusions()
    True
    """
    return Exclusions(
        table.flag("qualification_all_correct", default=True),
        table.flag("complete_only", default=True),
        table.optional_number("minimum_median_ms", 0, 600_000),
        table.optional_number("maximum_same_side", 0.5, 1),
        table.optional_whole("maximum_blur_events", 0, 10_000),
    )


def read_analysis(table: TomlTable) -> AnalysisPlan:
    """Return ``[analysis]``.

    Parameters
    ----------
    table : TomlTable

    Returns
    -------
    AnalysisPlan

    Raises
    ------
    RelightlabError
        If a number is out of its range or a group is not known.

    Examples
    --------
    >>> from studies.toml_table import checked_table
    >>> read_analysis(checked_table({"groups": ["half"]}, "[analysis]", ANALYSIS_KEYS)).groups
    ('half',)
    """
    usual = AnalysisPlan()
    groups = table.texts("groups", default=usual.groups)
    for group in groups:
        if group not in usual.groups:
            raise unknown_name("group in [analysis]", group, usual.groups)
    return AnalysisPlan(
        table.number("equivalence_margin", 0.001, 0.499, default=usual.equivalence_margin),
        table.number("alpha", 0.0001, 0.5, default=usual.alpha),
        groups,
        table.number("age_threshold", 1, 150, default=usual.age_threshold),
    )
