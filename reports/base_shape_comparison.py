"""How one base shape stands to another in a measured Table 2.

Two shapes are told apart by Wilcoxon's test after Holm's correction where there are objects enough
for it to decide; with fewer, their means are compared, alike within a tenth.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from evaluation.base_shapes import RIVAL_SHAPES

LEVEL = 0.05
LEAST_SHOWN = 0.0001
ALIKE = 0.1
"""Means are called alike if their ratio is within a tenth of one."""
BELOW, ABOVE, SAME = "clearly below", "clearly above", "not told apart from"
BELOW_BY_MEAN, ABOVE_BY_MEAN, ALIKE_BY_MEAN = "below", "above", "alike"
Document = Mapping[str, Any]


@dataclass(frozen=True)
class Comparison:
    """One shape against another under one weight rule.

    Parameters
    ----------
    weights, first, second : str
    means : (float, float)
        Mean IMSE of both.
    wins, objects : int
        On how many of the objects the first has the smaller error.
    p : float or None
        After Holm's correction; None if there are too few objects for it to decide.
    ahead : bool
        Whether the first has the smaller error in the median.
    """

    weights: str
    first: str
    second: str
    means: tuple[float, float]
    wins: int
    objects: int
    p: float | None
    ahead: bool

    @property
    def word(self) -> str:
        """How the first stands to the second."""
        if self.p is not None:
            return SAME if self.p >= LEVEL else (BELOW if self.ahead else ABOVE)
        first, second = self.means
        if first < second * (1 - ALIKE):
            return BELOW_BY_MEAN
        return ABOVE_BY_MEAN if first > second * (1 + ALIKE) else ALIKE_BY_MEAN

    @property
    def evidence(self) -> str:
        """The numbers in words."""
        first, second = self.means
        test = "by the means alone" if self.p is None else f"p {p_words(self.p)}"
        return (
            f"{self.weights}: {first:.4f} against {second:.4f}, {self.word.removesuffix(' from')}"
            f" ({test}, lower on {self.wins} of {self.objects})"
        )


def least_p(objects: int, pairs: int) -> float:
    """Return the least p that Wilcoxon's test can give after Holm's correction.

    Parameters
    ----------
    objects, pairs : int
        Above zero.

    Returns
    -------
    float

    Examples
    --------
    >>> least_p(3, 6), round(least_p(10, 6), 4)
    (1.0, 0.0117)
    """
    return min(1.0, pairs * 2.0 ** (1 - objects))


def p_words(p: float) -> str:
    """Return a p-value as it is printed.

    Parameters
    ----------
    p : float

    Returns
    -------
    str

    Examples
    --------
    >>> p_words(0.0312), p_words(3e-6)
    ('0.031', '< 0.0001')
    """
    return f"{p:.2g}" if p >= LEAST_SHOWN else f"< {LEAST_SHOWN}"


def measured_objects(document: Document) -> int:
    """Return over how many objects the shapes of the paper's table are compared.

    Parameters
    ----------
    document : mapping
        Of `reports.base_shape_run.BaseShapeStudy`.

    Returns
    -------
    int
        Those on which all are known, under the published rules: a regression of weights learns
        nothing from a single object. Shapes that failed on every object do not count.
    """
    rules, known = judged_rules(document), dict[tuple[str, str], set[str]]()
    for row in document["objects"]:
        if row["shape"] in RIVAL_SHAPES and row["weights"] in rules and row["imse"] is not None:
            known.setdefault((row["shape"], row["weights"]), set()).add(row["object"])
    return len(set.intersection(*known.values())) if known else 0


def can_decide(document: Document) -> bool:
    """Return whether there are objects enough for a test to tell two shapes apart.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    bool
    """
    rules = {row["weights"] for row in document["pairs"]}
    pairs = len(document["pairs"]) // max(len(rules), 1)
    return pairs > 0 and least_p(measured_objects(document), pairs) < LEVEL


def compared(document: Document, first: str, second: str, weights: str) -> Comparison | None:
    """Return how one shape stands to another under one rule, None where one was not measured.

    Parameters
    ----------
    document : mapping
    first, second, weights : str

    Returns
    -------
    Comparison or None
    """
    means = {row["shape"]: row["imse"] for row in document["rows"] if row["weights"] == weights}
    pair = next(
        (
            row
            for row in document["pairs"]
            if row["weights"] == weights and {row["first"], row["second"]} == {first, second}
        ),
        None,
    )
    if pair is None or pair["median_difference"] is None or None in (means[first], means[second]):
        return None
    turned = pair["first"] != first
    return Comparison(
        *(weights, first, second),
        (means[first], means[second]),
        pair["losses" if turned else "wins"],
        measured_objects(document),
        pair["p_holm"] if can_decide(document) else None,
        (pair["median_difference"] < 0) != turned,
    )


def judged_rules(document: Document) -> tuple[str, ...]:
    """Return the weight rules of the published table, in its order.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    tuple of str
    """
    return tuple(dict.fromkeys(row["weights"] for row in document["published"]))


def reported_rules(document: Document) -> tuple[str, ...]:
    """Return the weight rules that there is something to report of.

    Weights regressed for an object are learned on the others, so a set of one object has none,
    though no cell of it is missing.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    tuple of str
    """
    rules = dict.fromkeys(row["weights"] for row in document["rows"])
    known = {row["weights"] for row in document["rows"] if row["imse"] is not None}
    return tuple(rule for rule in rules if rule in known or document["missing"])
