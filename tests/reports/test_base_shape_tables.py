"""Tests of reports.base_shape_tables and base_shape_sensitivity: every number, and its reading."""

from __future__ import annotations

import pytest

from evaluation.base_shape_table import RULES
from reports.base_shape_comparison import measured_objects
from reports.base_shape_sensitivity import (
    changed_orders,
    sensitivity_table,
    sensitivity_words,
)
from reports.base_shape_tables import TOO_FEW, object_table, pair_table, shape_table
from reports.base_shape_words import RULE_WORDS, SHAPE_WORDS
from reports.content import Cell, Table
from reports.table1_tables import NONE
from tests.reports.small_study import BOUNDS, PAPERS, study_document


def lines(table: Table, rule: str) -> dict[str, tuple[Cell, ...]]:
    """Return the rows of a weight rule by their first cell."""
    (group,) = [group for group in table.groups if group.title == RULE_WORDS[rule]]
    return {row[0].text: row for row in group.rows}


def test_every_shape_stands_under_every_rule() -> None:
    """There is a group for each rule with a row for each of the six shapes, in order."""
    table = shape_table(study_document(), SHAPE_WORDS)
    assert [group.title for group in table.groups] == [RULE_WORDS[rule] for rule in RULES]
    for rule in RULES:
        assert list(lines(table, rule)) == [SHAPE_WORDS[shape] for shape in {**PAPERS, **BOUNDS}]
    assert table.rows is not None
    assert table.rows.file == "table2-mit-berkeley.json"


def test_numbers_stand_beside_the_published() -> None:
    """Error, interval, share, paired difference, and proportions to contour here and published."""
    document = study_document()
    kinect = lines(shape_table(document, SHAPE_WORDS), "oracle")["Kinect (simulated)"]
    row = next(r for r in document["rows"] if (r["weights"], r["shape"]) == ("oracle", "kinect"))
    assert [cell.text for cell in kinect[1:]] == [
        *("0.03100", "31.0 %", "+0.00100"),
        *("1.03", f"{0.0304 / 0.0295:.2f}", "0.0304"),
    ]
    assert kinect[1].note == f"{row['low']:.5f} to {row['high']:.5f}"
    assert kinect[3].note == f"{row['difference_low']:+.5f} to {row['difference_high']:+.5f}"
    stereo = lines(shape_table(document, SHAPE_WORDS), "oracle")["SIRFS-stereo"]
    assert stereo[3].text == "−0.01100"  # noqa: RUF001  a minus sign


def test_what_was_not_published_is_a_dash() -> None:
    """Bounds and regression weights have no published number, and contour no difference to it."""
    table = shape_table(study_document(), SHAPE_WORDS)
    for row in lines(table, "regression").values():
        assert [cell.text for cell in row[-2:]] == [NONE, NONE]
    assert [cell.text for cell in lines(table, "oracle")["flat"][-2:]] == [NONE, NONE]
    assert lines(table, "oracle")["contour (ours)"][3].text == NONE


def test_one_object_has_no_interval() -> None:
    """An interval over a single object would say nothing, so there is none."""
    for row in lines(shape_table(study_document(objects=1), SHAPE_WORDS), "oracle").values():
        assert all(cell.note == "" for cell in row)


def test_rules_without_a_value_are_left_out() -> None:
    """One object has no regression weights: no table has the rule, unless cells are missing."""
    document = study_document(objects=1)
    for row in document["rows"]:
        if row["weights"] == "regression":
            row |= {"imse": None, "difference": None, "objects": 0, "cells": 0}
    assert measured_objects(document) == 1
    tables = (shape_table, pair_table, sensitivity_table)
    for make in tables:
        titles = [group.title for group in make(document, SHAPE_WORDS).groups]
        assert titles == [RULE_WORDS["default"], RULE_WORDS["oracle"]]
    lacking = document | {"missing": [{"object": "cup", "reason": "no room"}]}
    assert len(shape_table(lacking, SHAPE_WORDS).groups) == 3


def test_missing_errors_are_marked() -> None:
    """A shape without results says so, and the caption how many cells are missing."""
    cell = {"object": "cup", "shape": "sirfs", "light": "03", "reason": "the fit diverged"}
    document = study_document(missing=[cell])
    for row in document["rows"]:
        if row["shape"] == "sirfs":
            row |= {"imse": None, "relative_imse": None, "difference": None}
    table = shape_table(document, SHAPE_WORDS)
    assert table.caption.startswith("{INCOMPLETE: 1 cell missing.}")
    sirfs = lines(table, "oracle")["SIRFS"]
    assert [sirfs[1].text, sirfs[2].text, sirfs[3].text] == ["missing", NONE, "missing"]
    assert sirfs[1].role == "absent"


def test_quick_tables_say_so() -> None:
    """A run without SIRFS has the shapes that it has, and the stamp before every caption."""
    document = study_document({"contour": 0.02, "kinect": 0.01, **BOUNDS}, quick=True)
    tables = [make(document, SHAPE_WORDS) for make in (shape_table, pair_table, object_table)]
    assert all(table.caption.startswith("{QUICK: without SIRFS.}") for table in tables)
    assert len(lines(tables[0], "oracle")) == 4
    assert len(lines(tables[1], "oracle")) == 1


def test_pairs_have_wins_and_a_reading() -> None:
    """Each of the six pairs has its wins; the reading is the corrected test's."""
    table = pair_table(study_document(), SHAPE_WORDS)
    found = lines(table, "oracle")
    assert len(found) == 6
    row = found["contour (ours), SIRFS-stereo"]
    assert [cell.text for cell in row[1:3]] == ["0", "12"]
    assert row[-1].text == "first clearly above"
    assert found["contour (ours), Kinect (simulated)"][-1].text == "first clearly below"


def test_pairs_of_few_objects_have_no_reading() -> None:
    """With three objects the wins are given, and the reading is that they are too few."""
    table = pair_table(study_document(objects=3), SHAPE_WORDS)
    assert {row[-1].text for group in table.groups for row in group.rows} == {TOO_FEW}


def test_objects_are_in_percent() -> None:
    """The table by object holds every relative error under the published rules."""
    document = study_document()
    table = object_table(document, SHAPE_WORDS)
    assert len(table.groups) == 2
    for rule in ("default", "oracle"):
        for row in document["objects"]:
            if row["weights"] == rule:
                shown = [cell.text for cell in lines(table, rule)[row["object"]]]
                assert f"{100 * row['relative_imse']:.1f}" in shown


@pytest.fixture(scope="module")
def varied() -> dict[str, object]:
    """A study in which half the height turns the order, and leave-one-out lacks SIRFS."""
    turned = {**PAPERS, "kinect": 0.005, **BOUNDS}
    return study_document(
        variants={
            "half-height": turned,
            "leave-one-out": {"contour": 0.03, "kinect": 0.04, **BOUNDS},
        }
    )


def test_changed_orders_are_shown(varied: dict[str, object]) -> None:
    """A variant in another order says so; one measured in part is compared as far as it goes."""
    table = sensitivity_table(varied, SHAPE_WORDS)
    rows = lines(table, "oracle")
    assert rows["mean of the photographs"][1].note == ""
    assert rows["half the height"][1] == Cell(
        "Kinect < SIRFS-stereo < contour < SIRFS", "changes", "ours"
    )
    held_out = rows["mean of the other photographs"]
    assert held_out[1] == Cell("contour < Kinect", "the same, as far as measured")
    assert [cell.text for cell in held_out[4:6]] == [NONE, NONE]


def test_lowest_rival_is_marked(varied: dict[str, object]) -> None:
    """The lowest error of the four shapes stands out where all were measured, and no bound does."""
    for name, row in lines(sensitivity_table(varied, SHAPE_WORDS), "default").items():
        marked = [cell.role == "ours" for cell in row[2:]]
        if name == "mean of the other photographs":
            assert not any(marked)
        else:
            values = [float(cell.text) for cell in row[2:6]]
            assert marked == [*(value == min(values) for value in values), False, False]


def test_changes_are_told_in_words(varied: dict[str, object]) -> None:
    """Each rule says in how many variants its order holds, and where it does not."""
    text = sensitivity_words(varied)
    assert (
        "Oracle weights: the order holds in 1 of 2 variants, and changes with: half the height."
        in text
    )
    assert sensitivity_words(study_document()) == ""


def test_the_first_variant_never_changes(varied: dict[str, object]) -> None:
    """Changes are from the first variant, which is in its own order."""
    rows = [row for row in varied["sensitivity"] if row["weights"] == "oracle"]  # type: ignore[attr-defined]
    assert [row["variant"] for row in changed_orders(rows)] == ["half-height"]
    assert changed_orders(rows[:1]) == ()
