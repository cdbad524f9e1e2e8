"""The orderings of the published Table 1: for each, the pairs of errors that it is about."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from reports.table1_entries import NO_RULE, PUBLISHED_RULES, RIVAL, Key

Errors = dict[Key, float]
"""IMSE by (setting, detail source, weight rule)."""
Comparison = tuple[str, float, float]
"""Where, the value that should be lower, the value that should be higher."""

SETTINGS = ("natural", "laboratory")
SOURCES = {"default": "default", "sirfs-shading": "B+M S", "gt-shading": "GT S"}
"""Detail sources of our models in words, from the poorest shading to the best."""


def _oracle_below_regression(errors: Errors) -> list[Comparison]:
    pairs = [
        (f"{setting}, {words}", (setting, source, "oracle"), (setting, source, "regression"))
        for setting in SETTINGS
        for source, words in SOURCES.items()
    ]
    return _measured(errors, pairs)


def _true_shading_below_default(errors: Errors) -> list[Comparison]:
    pairs = [
        (f"{setting}, {rule}", (setting, "gt-shading", rule), (setting, "default", rule))
        for setting in SETTINGS
        for rule in PUBLISHED_RULES
    ]
    return _measured(errors, pairs)


def _natural_below_laboratory(errors: Errors) -> list[Comparison]:
    pairs = [
        (rule, ("natural", "default", rule), ("laboratory", "default", rule))
        for rule in PUBLISHED_RULES
    ]
    return _measured(errors, pairs)


def _true_shading_narrows_the_gap(errors: Errors) -> list[Comparison]:
    comparisons = []
    for rule in PUBLISHED_RULES:
        keys = [
            (setting, source, rule) for source in ("default", "gt-shading") for setting in SETTINGS
        ]
        if all(key in errors and errors[key] > 0 for key in keys):
            natural, laboratory, true_natural, true_laboratory = (errors[key] for key in keys)
            gap = (true_laboratory / true_natural, laboratory / natural)
            comparisons.append((f"laboratory over natural, {rule}", *gap))
    return comparisons


def _rival_below_ours_on_natural(errors: Errors) -> list[Comparison]:
    pairs = [
        (f"{words}, {rule}", ("natural", RIVAL, NO_RULE), ("natural", source, rule))
        for source, words in SOURCES.items()
        for rule in PUBLISHED_RULES
    ]
    return _measured(errors, pairs)


def _true_shading_below_rival(errors: Errors) -> list[Comparison]:
    return _below_rival_in_laboratory(errors, "gt-shading")


def _rival_shading_below_rival(errors: Errors) -> list[Comparison]:
    return _below_rival_in_laboratory(errors, "sirfs-shading")


def _rival_shading_in_between(errors: Errors) -> list[Comparison]:
    poor, middle, best = SOURCES
    pairs = [
        (
            f"{setting}, {rule}, {SOURCES[lower]} below {SOURCES[higher]}",
            (setting, lower, rule),
            (setting, higher, rule),
        )
        for setting in SETTINGS
        for rule in PUBLISHED_RULES
        for lower, higher in ((best, middle), (middle, poor))
    ]
    return _measured(errors, pairs)


FINDINGS: dict[str, Callable[[Errors], list[Comparison]]] = {
    "Oracle weights give a lower error than regressed ones": _oracle_below_regression,
    "The true shading (GT S) gives a lower error than the default": _true_shading_below_default,
    "With the default, natural models err less than laboratory ones": _natural_below_laboratory,
    "The true shading narrows the gap between the settings": _true_shading_narrows_the_gap,
    "On natural photographs B+M errs less than every model of ours": _rival_below_ours_on_natural,
    "In the laboratory our models with the true shading err less than B+M": (
        _true_shading_below_rival
    ),
    "In the laboratory our models with B+M's shading err less than B+M": _rival_shading_below_rival,
    "The shading of B+M puts our models between the default and the true shading": (
        _rival_shading_in_between
    ),
}
"""The orderings of the published Table 1; a new one is a line here."""


def _below_rival_in_laboratory(errors: Errors, source: str) -> list[Comparison]:
    rival = ("laboratory", RIVAL, NO_RULE)
    return _measured(errors, [(r, ("laboratory", source, r), rival) for r in PUBLISHED_RULES])


def _measured(errors: Errors, pairs: Iterable[tuple[str, Key, Key]]) -> list[Comparison]:
    """Return the comparisons of which both sides were measured."""
    return [
        (where, errors[lower], errors[higher])
        for where, lower, higher in pairs
        if lower in errors and higher in errors
    ]
