"""Tests of the numbers that a row keeps of a cell."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from evaluation.cell_values import cell_of_values, cell_values
from evaluation.rerendering import RerenderingCell
from shading_model.object_model import Weights


@given(st.integers(0, 2**32 - 1))
def test_a_cell_comes_back_as_it_was(seed: int) -> None:
    """The cell of a row gives the same errors, bit by bit, at any weights."""
    generator = np.random.default_rng(seed)
    columns = generator.normal(size=(20, 3))
    target = generator.normal(size=20)
    cell = RerenderingCell(columns.T @ columns, columns.T @ target, float(target @ target))
    again = cell_of_values(cell_values(cell))
    weights = Weights(*generator.normal(size=2).tolist())
    assert again.error(weights) == cell.error(weights)
    assert again.oracle() == cell.oracle()


def test_a_cell_of_nothing_is_unknown() -> None:
    """Without values every error is NaN."""
    assert np.isnan(cell_of_values({}).error(Weights()))
    assert np.isnan(cell_of_values({}).oracle().parametric)
