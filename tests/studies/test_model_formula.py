"""Tests of studies.model_formula: R's names, contrasts and interactions, and what is refused."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from shading_model.errors import RelightlabError
from studies.model_formula import design_of, parse_formula

FRAME = pd.DataFrame(
    {
        "chose": [1, 0, 1, 0],
        "rival": ["b", "a", "c", "b"],
        "left": [0.5, -0.5, 0.5, -0.5],
        "who": ["w1", "w1", "w2", None],
    }
)


def test_words_are_contrasts_and_numbers_stay() -> None:
    """Levels but the first in order are indicators named as R does; numbers are one column."""
    matrix, terms = design_of(parse_formula("chose ~ rival + left"), FRAME)
    assert terms == ("(Intercept)", "rivalb", "rivalc", "left")
    np.testing.assert_array_equal(matrix[:, 0], 1)
    np.testing.assert_array_equal(matrix[:, 1], [1, 0, 0, 1])
    np.testing.assert_array_equal(matrix[:, 2], [0, 0, 1, 0])
    np.testing.assert_array_equal(matrix[:, 3], FRAME["left"])


def test_interactions_are_products() -> None:
    """A term with ':' is the product of its columns."""
    matrix, terms = design_of(parse_formula("chose ~ rival:left"), FRAME)
    assert terms == ("(Intercept)", "rivalb:left", "rivalc:left")
    np.testing.assert_array_equal(matrix[:, 1], [0.5, 0, 0, -0.5])


@pytest.mark.parametrize("text", ["chose ~ 1", "chose ~ (1|who)", "chose ~", "chose~1+(1 | who)"])
def test_no_terms_leave_the_intercept(text: str) -> None:
    """A formula without fixed effects has the intercept."""
    formula = parse_formula(text)
    assert formula.fixed == ()
    assert formula.factors in {(), ("who",)}


@pytest.mark.parametrize(
    "text",
    [
        "chose",
        "~ rival",
        "chose ~ log(left)",
        "chose ~ rival * left",
        "chose ~ (left|who)",
        "chose ~ __import__('os')",
        "chose ~ rival - 1",
        "log(chose) ~ rival",
    ],
)
def test_other_formulas_are_refused(text: str) -> None:
    """Functions, slopes and code are no part of a formula: the sentence shows one that is."""
    with pytest.raises(RelightlabError, match="expected a formula such as 'chose ~ baseline"):
        parse_formula(text)


def test_columns_must_be_there_and_full() -> None:
    """An unknown column and an empty cell are told by the column's name."""
    with pytest.raises(RelightlabError, match=r"'rivals'\. Did you mean 'rival'"):
        design_of(parse_formula("chose ~ rivals"), FRAME)
    with pytest.raises(RelightlabError, match="a value in every row of the column 'who'"):
        design_of(parse_formula("chose ~ (1|who)"), FRAME)
