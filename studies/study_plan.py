"""Whether the parts of a study fit: what is planned must be possible with what is asked."""

from __future__ import annotations

from dataclasses import replace

from shading_model.errors import RelightlabError
from studies.study_pairs import CLOSING_TESTS
from studies.study_records import Question, Study

KINDS = {"gender": "choice", "age": "number", "expertise": "choice"}
"""The kind of each question that is read as the subject's."""
EXPERTISE_OPTIONS = {"yes", "no"}
QUESTIONS_OF_GROUPS = {"expertise": "expertise", "gender": "gender", "age": "age"}
GROUPS_OF_TESTS = ("expertise", "tests")


def checked_plan(study: Study, *, groups_are_chosen: bool) -> Study:
    """Return a study whose parts fit each other.

    Parameters
    ----------
    study : Study
    groups_are_chosen : bool
        Whether the file names the groups; if not, those that can be formed are planned.

    Returns
    -------
    Study

    Raises
    ------
    RelightlabError
        If a task has fewer pairs than a subject is to see, a question that is read as the
        subject's has the wrong kind, or a chosen group cannot be formed.

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> checked_plan(bare_study(closing=False), groups_are_chosen=False).analysis.groups
    ('half',)
    """
    _check_pairs_per_subject(study)
    for question in study.questionnaire:
        _check_question(question)
    lacking = {group: what for group in study.analysis.groups if (what := _lacking(study, group))}
    if groups_are_chosen and lacking:
        group, what = next(iter(lacking.items()))
        raise RelightlabError(
            f"[analysis]: the group {group!r} needs {what}; add it, or leave the group out"
        )
    possible = tuple(group for group in study.analysis.groups if group not in lacking)
    return replace(study, analysis=replace(study.analysis, groups=possible))


def _check_pairs_per_subject(study: Study) -> None:
    wanted = study.settings.pairs_per_subject or 1
    for task in study.tasks:
        if len(task.pairs) < wanted:
            raise RelightlabError(
                f"[trials]: expected pairs_per_subject to be at most the {len(task.pairs)} pairs"
                f" of task {task.name!r}, got {wanted}"
            )


def _check_question(question: Question) -> None:
    wanted = KINDS.get(question.name, question.kind)
    if question.kind != wanted:
        raise RelightlabError(
            f"[[questionnaire]] {question.name}: expected kind to be {wanted!r}, as it is read as"
            f" the subject's {question.name}, got {question.kind!r}"
        )
    options = {option.lower() for option in question.options}
    if question.name == "expertise" and options != EXPERTISE_OPTIONS:
        raise RelightlabError(
            "[[questionnaire]] expertise: expected options to be 'Yes' and 'No', got"
            f" {', '.join(map(repr, question.options))}"
        )


def _lacking(study: Study, group: str) -> str:
    """Return what a study would have to ask before a group could be formed; empty if nothing."""
    wanted = QUESTIONS_OF_GROUPS.get(group)
    if wanted is not None and wanted not in {question.name for question in study.questionnaire}:
        return f"a [[questionnaire]] question named {wanted!r}"
    missing = set(CLOSING_TESTS) - {pair.name for pair in study.closing}
    if group in GROUPS_OF_TESTS and missing:
        return f"a [[closing]] pair named {min(missing)!r}"
    return ""
