"""How the paper arranges its user study: which tasks are in Table 3, and which in each figure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

TABLE3 = (
    ("ours-real", "ours", "ours"),
    ("barron-malik-real", "barron-malik", "B & M"),
)
"""Task, condition and head of each group of columns of ``tab:study_vs_real``."""
FIGURES: tuple[dict[str, Any], ...] = (
    {
        "identifier": "study_vs_real",
        "title": "Inserted objects against real pictures",
        "caption": "How often an insertion was taken for the real picture, by subpopulation; 50 %"
        " would be an insertion that cannot be told from real.",
        "conditions": (
            ("ours-real", "ours", "ours taken for real"),
            ("barron-malik-real", "barron-malik", "B & M taken for real"),
        ),
    },
    {
        "identifier": "study_vs_barron_karsch",
        "title": "Ours against Barron and Malik, and against Karsch et al.",
        "caption": "How often our insertion was chosen over that of the other method, by"
        " subpopulation, as in the paper's `fig:study_vs_barron_karsch`.",
        "conditions": (
            ("ours-barron-malik", "ours", "ours over Barron and Malik"),
            ("ours-karsch", "ours", "ours over Karsch et al."),
        ),
    },
    {
        "identifier": "controlled_details",
        "title": "Controlled number of detail layers",
        "caption": "How often the insertion with more detail layers was chosen, by subpopulation,"
        " as in the paper's `fig:controlled_details`.",
        "conditions": (
            ("one-layer-none", "one-layer", "one layer over none"),
            ("two-layers-one", "two-layers", "two layers over one"),
        ),
    },
)
"""The forest plots of the paper's tasks; the first, of Table 3's rates, the paper does not have."""


def paper_table3(rates: Iterable[Mapping[str, Any]]) -> list[dict[str, str]]:
    """Return the conditions of Table 3, none if a study has no task of it.

    Parameters
    ----------
    rates : iterable of rows

    Returns
    -------
    list of dict
        ``task, condition, title``.

    Examples
    --------
    >>> paper_table3([{"task": "edits", "condition": "ours"}])
    []
    """
    known = _pairs(rates)
    found = [_condition(*one) for one in TABLE3]
    return found if any((one["task"], one["condition"]) in known for one in found) else []


def forest_layout(rates: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the forest plots of a study: the paper's, and others for tasks it does not have.

    Parameters
    ----------
    rates : iterable of rows

    Returns
    -------
    list of dict
        ``identifier, title, caption, conditions``, with at least one condition each.

    Examples
    --------
    >>> rates = [{"task": task, "condition": "ours"} for task in ("ours-karsch", "edits")]
    >>> [(plot["identifier"], len(plot["conditions"])) for plot in forest_layout(rates)]
    [('study_vs_barron_karsch', 1), ('rates-plot-1', 1)]
    """
    left = _pairs(rates)
    plots = []
    for figure in FIGURES:
        shown = [_condition(*one) for one in figure["conditions"] if one[:2] in left]
        left = {
            pair: None for pair in left if pair not in {one[:2] for one in figure["conditions"]}
        }
        if shown:
            plots.append({**figure, "conditions": shown})
    others = [_condition(*pair, ": ".join(dict.fromkeys(pair))) for pair in left]
    for number, start in enumerate(range(0, len(others), 2), start=1):
        beside = others[start : start + 2]
        title = " and ".join(one["title"] for one in beside)
        plot = {"identifier": f"rates-plot-{number}", "title": title, "caption": ""}
        plots.append({**plot, "conditions": beside})
    return plots


def _pairs(rates: Iterable[Mapping[str, Any]]) -> dict[tuple[str, str], None]:
    return dict.fromkeys((row["task"], row["condition"]) for row in rates)


def _condition(task: str, condition: str, title: str) -> dict[str, str]:
    return {"task": task, "condition": condition, "title": title}
