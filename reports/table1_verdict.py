"""What a measured Table 1 says about the paper's findings, worked out from the numbers."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

from reports.table1_entries import measured, published
from reports.table1_orderings import FINDINGS, SETTINGS, SOURCES, Comparison


@dataclass(frozen=True)
class Finding:
    """One ordering the paper reports, and whether it holds here.

    Parameters
    ----------
    statement : str
    held, compared : int
        In how many of the comparisons that could be made it holds.
    evidence : str
        The numbers.
    """

    statement: str
    held: int
    compared: int
    evidence: str

    @property
    def state(self) -> str:
        """``holds``, ``holds in part``, ``does not hold`` or ``not measured``."""
        if not self.compared:
            return "not measured"
        if self.held == self.compared:
            return "holds"
        return "holds in part" if self.held else "does not hold"


@dataclass(frozen=True)
class Verdict:
    """Findings, and how many pairs of published entries come in the same order here.

    Parameters
    ----------
    findings : tuple of Finding
    pairs_alike, pairs : int
    """

    findings: tuple[Finding, ...]
    pairs_alike: int
    pairs: int

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        judged = [finding for finding in self.findings if finding.compared]
        if not judged:
            return "Too few entries were measured to compare any ordering with the paper."
        whole = sum(finding.state == "holds" for finding in judged)
        share = (
            f"All {whole} of the paper's orderings that can be checked hold here"
            if whole == len(judged)
            else f"{whole} of the {len(judged)} of the paper's orderings that can be checked"
            f" {'holds' if whole == 1 else 'hold'} here in full"
        )
        return (
            f"{share}; of {self.pairs} pairs of published"
            f" entries measured here, {self.pairs_alike} come in the published order."
        )


def table1_verdict(document: dict[str, Any]) -> Verdict:
    """Return which of the published orderings hold for a result.

    Parameters
    ----------
    document : dict
        See `evaluation.table1_results.table1_document`.

    Returns
    -------
    Verdict
    """
    ours, theirs = measured(document), published(document)
    findings = tuple(_finding(text, rule(ours)) for text, rule in FINDINGS.items())
    both = [key for key in theirs if key in ours]
    pairs = list(combinations(both, 2))
    alike = sum((ours[a] < ours[b]) == (theirs[a] < theirs[b]) for a, b in pairs)
    return Verdict(findings, alike, len(pairs))


def detail_effect(document: dict[str, Any]) -> tuple[Finding, ...]:
    """Return whether each weight rule does better than no detail at all, which no paper row shows.

    Parameters
    ----------
    document : dict

    Returns
    -------
    tuple of Finding
        One for each rule but ``coarse``.
    """
    ours = measured(document)
    return tuple(
        _finding(
            f"{rule.capitalize()} weights do better than the coarse shading alone",
            [
                (f"{setting}, {words}", ours[setting, source, rule], ours[coarse])
                for setting in SETTINGS
                for source, words in SOURCES.items()
                if (coarse := (setting, source, "coarse")) in ours
                and (setting, source, rule) in ours
            ],
        )
        for rule in ("oracle", "regression", "manual", "default")
    )


def _finding(statement: str, comparisons: list[Comparison]) -> Finding:
    held = sum(lower < higher for _, lower, higher in comparisons)
    evidence = "; ".join(
        f"{where}: {_short(lower)} {'<' if lower < higher else '≥'} {_short(higher)}"
        for where, lower, higher in comparisons
    )
    return Finding(statement, held, len(comparisons), evidence)


def _short(value: float) -> str:
    return f"{value:.4f}" if value < 1 else f"{value:.2f}"
