"""The models of a study as tables: a line for each model, its terms side by side."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from reports.content import Cell, Group, Table
from reports.rows_behind import rows_behind
from reports.study_tables import by_key, marked
from reports.study_words import NOTHING, Row, decimal, number_or_nan, probability

DIGITS = {"logLik": 2, "nobs": 0}
"""Digits of what is no coefficient; coefficients have three."""
MOST_TERMS = 9
"""More terms than this do not fit beside each other: then models are put in several tables."""
CAPTION = (
    "Models of the choice, in log-odds: below each coefficient its standard error and p. Mixed"
    " models are crossed, with subjects and items, fitted by Laplace's approximation; `sd` is the"
    " standard deviation of a random intercept. GEE confirms them, averaged over subjects; its"
    " `alpha` is the correlation of a subject's answers. In the models that studies are given,"
    " `side` is left less right, and `learning` the last place less the first."
)


def model_tables(document: Mapping[str, Any]) -> tuple[Table, ...]:
    """Return the terms of all models, models of like terms in one table.

    Parameters
    ----------
    document : mapping
        See `reports.study_results`.

    Returns
    -------
    tuple of Table
        The first has the caption in full.
    """
    models = by_key(document["models"], "model")
    return tuple(
        _table(document, number, {name: models[name] for name in names})
        for number, names in enumerate(_alike(models), start=1)
    )


def two_sided(z: float) -> float:
    """Return the two-sided p-value of a standard normal value.

    Parameters
    ----------
    z : float

    Returns
    -------
    float

    Examples
    --------
    >>> round(two_sided(1.959964), 6)
    0.05
    """
    return math.erfc(abs(z) / math.sqrt(2))


def _alike(models: Mapping[str, Sequence[Row]]) -> list[list[str]]:
    """Return the names of models that go into one table: as many as their terms have room."""
    found: list[tuple[set[str], list[str]]] = []
    for name, rows in models.items():
        terms = {row["term"] for row in rows}
        for known, names in found:
            if len(known | terms) <= MOST_TERMS:
                known.update(terms)
                names.append(name)
                break
        else:
            found.append((terms, [name]))
    return [names for _, names in found]


def _table(document: Mapping[str, Any], number: int, models: Mapping[str, Sequence[Row]]) -> Table:
    terms = _ordered(row["term"] for rows in models.values() for row in rows)
    head = tuple(Cell(word, role="head") for word in ("Model", *terms))
    rows = []
    for name, own in models.items():
        values = {row["term"]: row for row in own}
        rows.append((Cell(name, role="head"), *(_cell(values.get(term)) for term in terms)))
    caption = CAPTION if number == 1 else "More models, as above."
    identifier = "models" if number == 1 else f"models-{number}"
    behind = rows_behind(document, "models")
    return Table(identifier, marked(document, caption), (head,), (Group("", tuple(rows)),), behind)


def _ordered(terms: Iterable[str]) -> list[str]:
    """Return the terms once each: coefficients, deviations, and what is counted last."""
    names = dict.fromkeys(terms)
    return sorted(names, key=lambda term: (term in DIGITS, term == "alpha", term.startswith("sd:")))


def _cell(row: Row | None) -> Cell:
    if row is None or row["estimate"] is None:
        return Cell(NOTHING)
    text = decimal(row["estimate"], DIGITS.get(row["term"], 3))
    error = number_or_nan(row.get("se"))
    if not error > 0:
        return Cell(text)
    p = probability(two_sided(row["estimate"] / error))
    return Cell(text, note=f"{decimal(error)}, p {p}".replace("p <", "p\u00a0<"), role="ours")
