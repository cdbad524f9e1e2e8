"""Tests of the tables of a study: models side by side, tests, exclusions, words and numbers."""

from __future__ import annotations

from reports.content import Folded
from reports.study_exclusion_tables import everyone_table, exclusion_table
from reports.study_model_tables import MOST_TERMS, model_tables
from reports.study_tables import consistency_table, full_rates
from reports.study_test_tables import planned_tables
from tests.reports.study_document import study_document


def test_models_stand_side_by_side() -> None:
    """A line for each model, a column for each term; below a coefficient its error and p."""
    (table,) = model_tables(study_document())
    assert [cell.text for cell in table.head[0]] == ["Model", "(Intercept)", "sd: subject"]
    name, intercept, deviation = table.groups[0].rows[0]
    assert name.text == "mixed model"
    assert (intercept.text, intercept.note) == ("0.455", "0.137, p\u00a0< 0.001")
    assert (deviation.text, deviation.note) == ("0.754", "")


def test_models_with_many_terms_take_several_tables() -> None:
    """No table is wider than its room, and no model is lost."""
    models = [
        {"model": f"m{model}", "term": f"t{model}-{term}", "estimate": 1.0, "se": 0.5}
        for model in range(3)
        for term in range(7)
    ]
    tables = model_tables(study_document(models=models))
    assert [table.identifier for table in tables] == ["models", "models-2", "models-3"]
    assert all(table.width <= MOST_TERMS + 1 for table in tables)


def test_counts_of_models_have_no_digits() -> None:
    """The number of answers is whole, a log-likelihood has two digits."""
    models = [
        {"model": "m", "term": term, "estimate": value, "se": None}
        for term, value in (("nobs", 3147.0), ("logLik", -1994.2351))
    ]
    (table,) = model_tables(study_document(models=models))
    assert {cell.text for cell in table.groups[0].rows[0]} == {"m", "3147", "−1994.24"}  # noqa: RUF001


def test_tests_of_subpopulations_are_apart() -> None:
    """They are folded away with the caution that belongs to them; the others name their task."""
    base = study_document()["tests"][0]
    group = base | {"kind": "group", "test": "ours differs by age", "estimate": None}
    main, folded = planned_tables(study_document(tests=[base, group]))
    assert isinstance(folded, Folded)
    assert [row[0].text for row in main.groups[0].rows] == ["real: ours is within 5 points of 50 %"]
    assert [cell.text for cell in main.groups[0].rows[0]][1:3] == ["44.0", "41.0 to 47.0"]
    (inner,) = folded.blocks
    assert "no difference between the groups" in inner.caption
    assert inner.width == 4


def test_exclusions_with_and_without() -> None:
    """The steps in order; and the rates of everybody beside those that remain."""
    document = study_document()
    (row,) = exclusion_table(document).groups[0].rows
    assert [cell.text for cell in row] == ["chose a cartoon", "6", "60", "294", "2940"]
    rows = everyone_table(document).groups[0].rows
    assert len(rows) == 4
    assert rows[0][2].text == rows[0][5].text == "45.0"


def test_deviations_are_put_beside_rates() -> None:
    """Each rate gets the deviation of the row with the same names, None where there is none."""
    document = study_document()
    assert {row["deviation"] for row in full_rates(document)} == {0.016}
    assert {row["deviation"] for row in full_rates(document | {"deviations": []})} == {None}


def test_consistency_is_by_condition() -> None:
    """A printed deviation stands beside the binomial one, with the finding."""
    (group,) = consistency_table(study_document()).groups
    assert group.title == "real: ours"
    texts = [cell.text for cell in group.rows[0]]
    assert texts == ["all", "1040", "44.0", "1.5", "1.54", "as binomial"]
