"""Tests of reports.base_shape_verdict: the paper's finding, judged from the numbers."""

from __future__ import annotations

import numpy as np
import pytest

from evaluation.published_table2 import PUBLISHED
from reports.base_shape_verdict import (
    gap_words,
    shape_findings,
    significance_words,
    verdict_words,
)
from reports.base_shape_words import SHAPE_WORDS
from tests.reports.small_study import BOUNDS, PAPERS, study_document


def states(errors: dict[str, float], objects: int = 12) -> list[str]:
    """Return the states of the three findings for mean errors."""
    found = shape_findings(study_document(errors, objects), SHAPE_WORDS)
    return [finding.state for finding in found]


@pytest.mark.parametrize("objects", [1, 3, 12])
def test_the_published_errors_confirm_themselves(objects: int) -> None:
    """In the paper's own proportions with oracle weights, all of its finding holds."""
    oracle = {row["shape"]: row["imse"] for row in PUBLISHED if row["weights"] == "oracle"}
    assert states(oracle, objects) == ["holds"] * 3


@pytest.mark.parametrize("objects", [3, 12])
def test_a_worse_contour_is_told(objects: int) -> None:
    """Where Kinect, SIRFS or neither is better than contour, that is what is said."""
    assert states(PAPERS | {"kinect": 0.01}, objects)[:2] == ["does not hold", "holds"]
    assert states(PAPERS | {"sirfs": 0.01}, objects)[:2] == ["holds", "does not hold"]
    assert states(PAPERS | {"sirfs-stereo": 0.05}, objects)[2] == "does not hold"


def test_rules_may_differ() -> None:
    """What holds under one of the paper's rules alone holds in part."""
    document = study_document()
    for row in document["pairs"]:
        if row["weights"] == "default" and row["second"] == "kinect":
            row["median_difference"] *= -1
    first = shape_findings(document, SHAPE_WORDS)[0]
    assert first.state == "holds in part"
    assert verdict_words(document, shape_findings(document, SHAPE_WORDS)).startswith(
        "That the contour shape is not the barrier {holds in part}"
    )


def test_verdict_has_the_states_and_the_number_of_objects() -> None:
    """The sentence says what holds, what does not and what was not measured."""
    document = study_document({**PAPERS, **BOUNDS})
    text = verdict_words(document, shape_findings(document, SHAPE_WORDS))
    assert text == (
        "That the contour shape is not the barrier {holds}; that SIRFS-stereo is clearly better"
        " {holds}. Measured on 12 objects."
    )
    quick = study_document({"contour": 0.02, "kinect": 0.01, "flat": 0.03}, objects=1)
    text = verdict_words(quick, shape_findings(quick, SHAPE_WORDS))
    assert "not the barrier {does not hold}" in text
    assert "clearly better {was not measured}. Measured on 1 object." in text


def test_enough_objects_are_tested() -> None:
    """Friedman's p stands for each of the paper's rules, with the number of objects."""
    text = significance_words(study_document())
    assert "over 12 objects: default p < 0.0001, oracle p < 0.0001." in text
    assert "regression" not in text


@pytest.mark.parametrize(("objects", "number"), [(1, "one object"), (3, "three objects")])
def test_few_objects_are_said_not_to_be_tested(objects: int, number: str) -> None:
    """With few objects no p is given, and it is said plainly that no test is possible."""
    text = significance_words(study_document(objects=objects))
    assert text.startswith(f"{{No test is possible}}: with {number}, ")
    assert "Friedman" not in text


def test_few_shapes_are_told() -> None:
    """Two of the paper's shapes have no Friedman test; one has no pair."""
    assert "fewer were measured" in significance_words(
        study_document({"contour": 0.02, "kinect": 0.01})
    )
    assert "none can be compared" in significance_words(study_document({"contour": 0.02}))


def test_share_of_the_gap_is_linear_in_the_error() -> None:
    """Half way between flat and true is 50 %; flat is 0 % and true 100 %."""
    document = study_document({"contour": 0.035, "kinect": 0.01, "sirfs": 0.06, **BOUNDS})
    text = gap_words(document, SHAPE_WORDS)
    assert "with oracle weights, contour (ours) 50 %, Kinect (simulated) 100 %, SIRFS 0 %" in text


@pytest.mark.parametrize("errors", [PAPERS, {**PAPERS, "ground-truth": 0.06, "flat": 0.01}])
def test_without_a_gap_nothing_is_said_of_it(errors: dict[str, float]) -> None:
    """Where a bound is unknown, or the flat shape is no worse than the true one, nothing is."""
    assert gap_words(study_document(errors), SHAPE_WORDS) == ""


def test_a_failed_shape_is_not_judged() -> None:
    """Where no cell was measured, nothing is judged and the texts can still be made."""
    document = study_document({**PAPERS, **BOUNDS, "contour": np.nan})
    found = shape_findings(document, SHAPE_WORDS)
    assert [one.state for one in found] == ["not measured"] * 3
    assert "{was not measured}" in verdict_words(document, found)
    assert significance_words(document)
    assert "contour" not in gap_words(document, SHAPE_WORDS)
