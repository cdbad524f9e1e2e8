"""Who was left out of a study's analysis and what that changes, as tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from reports.content import Table
from reports.study_tables import Column, plain_table, rows_by_name
from reports.study_words import EVERYBODY, condition_words, interval, percent

Document = Mapping[str, Any]


def exclusion_table(document: Document) -> Table:
    """Return who was left out and why.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    Table
    """
    columns = (
        Column("Step", lambda row: row["reason"]),
        Column("subjects left out", lambda row: str(row["subjects"])),
        Column("trials left out", lambda row: str(row["trials"])),
        Column("subjects that remain", lambda row: str(row["remaining_subjects"])),
        Column("trials that remain", lambda row: str(row["remaining_trials"])),
    )
    caption = "Exclusions by the rules fixed beforehand, in the order in which they are applied."
    return plain_table(
        document, "exclusions", caption, columns, [("", document["exclusions"])], ["exclusions"]
    )


def everyone_table(document: Document) -> Table:
    """Return the rates of everybody beside those after exclusions.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    Table
    """
    kept = rows_by_name(row for row in document["rates"] if row["group"] == EVERYBODY)
    pairs = [
        {"name": condition_words(*key[:2]), "everyone": row, "kept": kept[key]}
        for key, row in rows_by_name(document["rates_with_everyone"]).items()
        if key in kept
    ]
    columns = (
        Column("Condition", lambda pair: pair["name"]),
        *(
            Column(f"{words}, {head}", lambda pair, key=key, text=text: text(pair[key]), role)  # type: ignore[misc]
            for key, words in (("everyone", "everybody"), ("kept", "after exclusions"))
            for head, text, role in (
                ("trials", lambda row: str(row["trials"]), ""),
                ("%", lambda row: percent(row["rate"]), "ours"),
                (
                    "by subject",
                    lambda row: interval(row["cluster_low"], row["cluster_high"]),
                    "",
                ),
            )
        ),
    )
    caption = "What the exclusions change: rates with everybody's answers, and without those left"
    parts = ["rates_with_everyone", "rates"]
    return plain_table(document, "with-everyone", f"{caption} out.", columns, [("", pairs)], parts)
