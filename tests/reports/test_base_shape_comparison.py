"""Tests of reports.base_shape_comparison: when two shapes are told apart, and by what."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.stats import wilcoxon

from reports.base_shape_comparison import (
    ABOVE,
    ABOVE_BY_MEAN,
    ALIKE_BY_MEAN,
    BELOW,
    BELOW_BY_MEAN,
    SAME,
    Comparison,
    can_decide,
    compared,
    judged_rules,
    least_p,
    measured_objects,
    p_words,
)
from tests.reports.small_study import PAPERS, study_document


@pytest.mark.parametrize("objects", [3, 6, 10])
def test_least_p_is_that_of_the_clearest_differences(objects: int) -> None:
    """With one pair it is SciPy's p where every difference has the same sign."""
    clearest = np.arange(1.0, objects + 1)
    assert least_p(objects, 1) == pytest.approx(wilcoxon(clearest).pvalue)
    assert least_p(objects, 6) == min(1.0, 6 * least_p(objects, 1))


@pytest.mark.parametrize(("objects", "decides"), [(1, False), (3, False), (7, False), (8, True)])
def test_few_objects_cannot_decide(objects: int, decides: bool) -> None:
    """Six pairs after Holm's correction need eight objects."""
    document = study_document(objects=objects)
    assert measured_objects(document) == objects
    assert can_decide(document) is decides


def test_without_pairs_nothing_is_decided() -> None:
    """One shape alone has no pair, and no test."""
    document = study_document({"contour": 0.01, "flat": 0.02})
    assert not can_decide(document)
    assert compared(document, "contour", "sirfs", "oracle") is None


def test_comparison_turns_around() -> None:
    """The second against the first is the first against the second with wins and losses turned."""
    document = study_document()
    for first, second in itertools.permutations(PAPERS, 2):
        one, other = (
            compared(document, *pair, "oracle") for pair in ((first, second), (second, first))
        )
        assert one is not None
        assert other is not None
        assert one.means == other.means[::-1]
        assert one.wins + other.wins == one.objects == 12
        assert one.p == other.p
        assert {one.word, other.word} == {BELOW, ABOVE}
        assert (one.word == BELOW) == (PAPERS[first] < PAPERS[second])


@pytest.mark.parametrize(
    ("means", "p", "ahead", "word"),
    [
        ((1.0, 2.0), 0.01, True, BELOW),
        ((2.0, 1.0), 0.01, False, ABOVE),
        ((1.0, 2.0), 0.2, True, SAME),
        ((1.0, 2.0), None, True, BELOW_BY_MEAN),
        ((2.0, 1.0), None, False, ABOVE_BY_MEAN),
        ((1.05, 1.0), None, False, ALIKE_BY_MEAN),
    ],
)
def test_words(means: tuple[float, float], p: float | None, ahead: bool, word: str) -> None:
    """A test decides where there is one; else the means do, alike within a tenth."""
    one = Comparison("oracle", "contour", "sirfs", means, 1, 3, p, ahead)
    assert one.word == word
    assert word.removesuffix(" from") in one.evidence
    assert ("by the means alone" in one.evidence) is (p is None)
    assert "lower on 1 of 3" in one.evidence


def test_a_shape_that_failed_is_not_compared() -> None:
    """Without any error of it, a shape is neither better nor worse."""
    document = study_document(PAPERS | {"sirfs": np.nan})
    assert compared(document, "contour", "sirfs", "default") is None


def test_rules_are_those_published() -> None:
    """The paper has no row with regression weights."""
    assert judged_rules(study_document()) == ("default", "oracle")


def test_small_p_has_no_exponent() -> None:
    """A p-value is never printed with an exponent."""
    assert [p_words(p) for p in (1.0, 0.25, 0.00012, 1e-9)] == ["1", "0.25", "0.00012", "< 0.0001"]


def test_objects_are_counted_under_the_published_rules() -> None:
    """One object counts though no regression learns from it; a shape that failed does not count."""
    document = study_document(objects=1)
    for row in document["objects"]:
        if row["weights"] == "regression":
            row["imse"] = None
    assert measured_objects(document) == 1
    assert measured_objects(study_document({**PAPERS, "sirfs": np.nan}, objects=9)) == 9
    apart = study_document(objects=9)
    for row in apart["objects"]:
        if (row["object"], row["shape"]) in {("object 00", "sirfs"), ("object 01", "kinect")}:
            row["imse"] = None
    assert measured_objects(apart) == 7
