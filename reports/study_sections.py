"""The sections of a study's report, and all of its plots."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from reports.content import (
    Judgement,
    Judgements,
    Plot,
    Prose,
    Section,
)
from reports.figures import PlotFigure
from reports.paper_table3 import table3
from reports.rows_behind import rows_behind
from reports.study_exclusion_tables import everyone_table, exclusion_table
from reports.study_figures import Panel, forest_figure
from reports.study_flow_figure import flow_figure
from reports.study_model_tables import model_tables
from reports.study_order_figure import order_figure
from reports.study_tables import (
    consistency_table,
    full_rates,
    marked,
    rates_tables,
)
from reports.study_test_tables import planned_tables
from reports.study_words import EVERYBODY, NOTHING, Row, counted, interval, number_or_nan, percent

CHANCE = 0.5
EXPLAINED = (
    "Each rate is held against chance, 50 %, by its interval that allows for what the answers of"
    " one subject have in common. “Not shown” means that the data do not show a difference, not"
    " that there is none; that is what the test of equivalence is for."
)

Document = Mapping[str, Any]


def study_plots(document: Document) -> tuple[Plot, ...]:
    """Return all plots of a study: forest plots, side and half, exclusion flow.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    tuple of Plot
    """
    mark = document["mark"]
    order = order_figure(document["rates"], mark)
    found: list[tuple[PlotFigure, tuple[str, ...]]] = [
        (figure, ("rates", "deviations", "published")) for figure in _forests(document)
    ]
    found += [(order, ("rates",))] if order else []
    found += (
        [(flow_figure(document["started"], document["exclusions"], mark), ("exclusions",))]
        if document["exclusions"]
        else []
    )
    return tuple(
        Plot(
            replace(figure, caption=marked(document, figure.caption)), rows_behind(document, *parts)
        )
        for figure, parts in found
    )


def _forests(document: Document) -> Iterable[PlotFigure]:
    rates = [row for row in full_rates(document) if row["group"] != "side"]
    for figure in document["figures"]:
        panels = [_titled(rates, document["published"], one) for one in figure["conditions"]]
        words = (figure["identifier"], figure["title"], figure["caption"])
        yield forest_figure(*words, panels, document["mark"])


def _titled(rates: Iterable[Row], published: Iterable[Row], condition: Row) -> Panel:
    pair = (condition["task"], condition["condition"])
    own, theirs = (
        [row for row in rows if (row["task"], row["condition"]) == pair]
        for rows in (rates, published)
    )
    return Panel(condition["title"], own, theirs)


def study_sections(document: Document) -> Iterator[Section]:
    """Yield the sections of a study's report: findings, tables, figures, tests, models, exclusions.

    Parameters
    ----------
    document : mapping
        See `reports.study_results`.

    Yields
    ------
    Section
    """
    yield _finding_section(document)
    if document["table3"]:
        yield Section("insertions", "Inserted against real", (table3(document),))
    plots = {plot.figure.identifier: plot for plot in study_plots(document)}
    asides = {name: plots.pop(name, None) for name in ("side-and-half", "exclusion-flow")}
    for identifier, plot in plots.items():
        yield Section(identifier, plot.figure.title, (plot,))
    yield Section("rates", "All rates", (rates_tables(document),))
    if document["tests"]:
        main, folded = planned_tables(document)
        yield Section("planned-tests", "Planned tests", (main, *([folded] if folded else [])))
    if (order := asides["side-and-half"]) is not None:
        yield Section("order", order.figure.title, (order,))
    if document["models"]:
        notes = tuple(Prose(f"{note[:1].upper()}{note[1:]}.") for note in document["notes"])
        yield Section("model-terms", "Models", (*model_tables(document), *notes))
    if (flow := asides["exclusion-flow"]) is not None:
        whole = [everyone_table(document)] if document["rates_with_everyone"] else []
        yield Section("flow", flow.figure.title, (flow, exclusion_table(document), *whole))
    if document["consistency"]:
        yield _consistency_section(document)


def _finding_section(document: Document) -> Section:
    every = {
        (row["task"], row["condition"]): row
        for row in document["rates"]
        if row["group"] == EVERYBODY and row["rate"] is not None
    }
    conditions = [one for figure in document["figures"] for one in figure["conditions"]]
    items = tuple(
        _judgement(one["title"], every[one["task"], one["condition"]])
        for one in conditions
        if (one["task"], one["condition"]) in every
    )
    return Section("findings", "What was found", (Prose(EXPLAINED), Judgements(items)))


def _judgement(title: str, row: Row) -> Judgement:
    low, high = (number_or_nan(row[f"cluster_{end}"]) for end in ("low", "high"))
    where = "above" if low > CHANCE else "below" if high < CHANCE else "apart from"
    ends = interval(row["cluster_low"], row["cluster_high"])
    return Judgement(
        "not shown" if where == "apart from" else "holds",
        f"{title}: {where} chance",
        f"{percent(row['rate'])} % of {counted(row['trials'], 'trial')} of"
        f" {counted(row['subjects'], 'subject')}",
        "" if ends == NOTHING else f"95 % by subject {ends}",
    )


def _consistency_section(document: Document) -> Section:
    rows = document["consistency"]
    below = sum(row["below"] for row in rows)
    text = (
        f"Of the {len(rows)} deviations printed in the paper's Table 3, {below} are below the"
        " binomial standard error of their rate by more than rounding explains. This concerns the"
        " published numbers alone, not the answers analysed here."
    )
    title = "The published deviations"
    odd = tuple(Prose(sentence) for sentence in document["disagreements"])
    return Section("consistency", title, (Prose(text), consistency_table(document), *odd))
