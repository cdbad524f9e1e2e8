"""The sections of the report about the table itself: verdict, entries, and where they differ."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from reports.content import Block, Folded, Judgement, Judgements, Prose, Remarks, Section
from reports.subject import Subject
from reports.table1_differences import difference_table
from reports.table1_entries import has_rival
from reports.table1_tables import entry_table, held_out_table
from reports.table1_verdict import Finding, detail_effect, table1_verdict
from reports.table1_words import COMPARABLE, DETAIL_EFFECT, NO_DIFFERENCE, RIVAL_NOTE


def table_section(subject: Subject) -> Section:
    """Return Table 1 with its verdict.

    Parameters
    ----------
    subject : Subject

    Returns
    -------
    Section
    """
    document = subject.document
    verdict = table1_verdict(document)
    notes = (COMPARABLE, *([RIVAL_NOTE] if has_rival(document) else []))
    compared = tuple(Prose(text) for text in notes)
    effect = (Prose(DETAIL_EFFECT), Judgements(judged(detail_effect(document))))
    held_out = held_out_table(document, subject.settings)
    blocks: tuple[Block, ...] = (
        Prose(f"{{Verdict.}} {verdict.sentence}", "verdict"),
        Judgements(judged(verdict.findings)),
        entry_table(document, subject.settings),
        *([Folded("Over the test objects alone", (held_out,))] if held_out else []),
        Remarks(
            (
                Section("comparable", "What can be compared", compared),
                Section("detail-effect", "What the published table does not show", effect),
            )
        ),
    )
    return Section("table-1", "Table 1, ours beside the published one", blocks)


def difference_section(document: dict[str, Any]) -> Section:
    """Return every pair of entries that comes in another order than published, with reasons.

    Parameters
    ----------
    document : dict

    Returns
    -------
    Section
    """
    table = difference_table(document)
    block = Prose(NO_DIFFERENCE) if table is None else table
    return Section("order", "Where the order differs, and why", (block,))


def judged(findings: Iterable[Finding]) -> tuple[Judgement, ...]:
    """Return findings as statements with the word for whether each holds.

    Parameters
    ----------
    findings : iterable of Finding

    Returns
    -------
    tuple of Judgement
    """
    return tuple(
        Judgement(f.state, f.statement, f"{f.held} of {f.compared}", f.evidence) for f in findings
    )
