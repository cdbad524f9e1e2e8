"""Rules that choose the weights of the detail layers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from evaluation.weight_rules import (
    MANUAL,
    WEIGHT_RULES,
    CellGrid,
    regressed,
    regressed_by_own_lights,
)
from shading_model.arrays import Float
from shading_model.object_model import Weights
from tests.evaluation.cells import cell_of_best

seeds = st.integers(0, 2**32 - 1)


def grid_of(weights: Float, coefficients: Float, seed: int = 0) -> CellGrid:
    """Cells whose oracle weights (objects, lights, 2) are these."""
    generator = np.random.default_rng(seed)
    cells = tuple(tuple(cell_of_best(w, generator) for w in row) for row in weights)
    return CellGrid(cells, coefficients)


@given(seeds, st.integers(2, 5), st.integers(1, 12))
@settings(max_examples=25)
def test_every_rule_gives_finite_weights_for_every_cell(
    seed: int, objects: int, lights: int
) -> None:
    """The contract of the registry, for two objects and more."""
    generator = np.random.default_rng(seed)
    grid = grid_of(
        generator.normal(size=(objects, lights, 2)), generator.normal(size=(lights, 9)), seed
    )
    for rule in WEIGHT_RULES.values():
        weights = rule(grid)
        assert weights.shape == (objects, lights, 2)
        assert np.isfinite(weights).all()
        errors = grid.errors(weights)
        assert errors.shape == (objects, lights)
        assert (grid.errors(WEIGHT_RULES["oracle"](grid)) <= errors + 1e-9).all()


def test_the_table_has_its_five_rules() -> None:
    """Under the names that the documents use."""
    assert list(WEIGHT_RULES) == ["coarse", "default", "regression", "oracle", "manual"]


def test_constant_rules_are_the_stated_constants() -> None:
    """Coarse (0, 0), default (1, 1), manual what the artist chose."""
    cells = grid_of(np.zeros((2, 3, 2)), np.eye(9)[:3]).cells
    grid = CellGrid(cells, np.eye(9)[:3], manual=Weights(0.25, 4.0))
    for rule, pair in (("coarse", (0, 0)), ("default", (1, 1)), ("manual", (0.25, 4))):
        assert (WEIGHT_RULES[rule](grid) == pair).all()
    assert (WEIGHT_RULES["manual"](CellGrid(cells, np.eye(9)[:3])) == (0.5, 0.5)).all()
    assert Weights(0.5, 0.5) == MANUAL


def test_the_oracle_is_each_cells_own() -> None:
    """Read from the cells in order."""
    weights = np.random.default_rng(0).normal(size=(3, 4, 2))
    assert np.allclose(WEIGHT_RULES["oracle"](grid_of(weights, np.eye(9)[:4])), weights)


def test_errors_are_those_of_the_cells() -> None:
    """Object by object and light by light."""
    generator = np.random.default_rng(1)
    grid = grid_of(generator.normal(size=(2, 3, 2)), np.eye(9)[:3])
    weights = generator.normal(size=(2, 3, 2))
    errors = grid.errors(weights)
    assert errors[1, 2] == grid.cells[1][2].error(Weights(*weights[1, 2]))
    assert errors[0, 1] == grid.cells[0][1].error(Weights(*weights[0, 1]))


@given(seeds, st.integers(2, 6), st.integers(1, 9))
@settings(max_examples=25)
def test_weights_that_depend_on_few_lights_alone_are_reproduced(
    seed: int, objects: int, lights: int
) -> None:
    """Up to ten lights in general position: an affine function passes through any values."""
    generator = np.random.default_rng(seed)
    by_light = generator.normal(size=(lights, 2))
    weights = np.broadcast_to(by_light, (objects, lights, 2))
    grid = grid_of(weights, generator.normal(size=(lights, 9)), seed)
    assert np.allclose(regressed(grid), weights, atol=1e-4)


@given(seeds, st.integers(1, 300))
@settings(max_examples=25)
def test_an_affine_function_of_the_light_is_reproduced(seed: int, neighbours: int) -> None:
    """With thirty lights, however many points are drawn."""
    generator = np.random.default_rng(seed)
    coefficients = generator.normal(size=(30, 9))
    by_light = coefficients @ generator.normal(size=(9, 2)) + generator.normal(size=2)
    grid = grid_of(np.broadcast_to(by_light, (4, 30, 2)), coefficients, seed)
    assert np.allclose(regressed(grid, neighbours), by_light, atol=1e-4)


@given(seeds)
@settings(max_examples=15)
def test_an_objects_own_weights_play_no_part(seed: int) -> None:
    """Changing one object's cells leaves its prediction and moves the others'."""
    generator = np.random.default_rng(seed)
    coefficients = generator.normal(size=(6, 9))
    weights = generator.normal(size=(3, 6, 2))
    before = regressed(grid_of(weights, coefficients))
    changed = weights.copy()
    changed[1] += 5
    after = regressed(grid_of(changed, coefficients))
    assert np.allclose(after[1], before[1], atol=1e-4)
    assert np.allclose(after[[0, 2]] - before[[0, 2]], 2.5, atol=1e-3)


def test_far_lights_play_no_part_where_near_ones_suffice() -> None:
    """With 19 others, 100 points lie at the six nearest lights; a seventh is not looked at."""
    generator = np.random.default_rng(2)
    coefficients = generator.normal(size=(8, 9)) * 0.1
    coefficients[7] += 100
    weights = np.broadcast_to(generator.normal(size=(8, 2)), (20, 8, 2)).copy()
    before = regressed(grid_of(weights, coefficients))
    weights[:, 7] += 50
    after = regressed(grid_of(weights, coefficients))
    assert np.allclose(after[:, :7], before[:, :7], atol=1e-6)
    assert not np.allclose(after[:, 7], before[:, 7], atol=1)


def test_the_order_of_objects_and_lights_does_not_matter() -> None:
    """Permuted cells have permuted predictions."""
    generator = np.random.default_rng(3)
    coefficients, weights = generator.normal(size=(7, 9)), generator.normal(size=(4, 7, 2))
    objects, lights = generator.permutation(4), generator.permutation(7)
    straight = regressed(grid_of(weights, coefficients), neighbours=9)
    permuted = regressed(grid_of(weights[objects][:, lights], coefficients[lights]), neighbours=9)
    assert np.allclose(permuted, straight[objects][:, lights], atol=1e-6)


def test_repeated_lights_need_no_slope() -> None:
    """All lights alike: the prediction is the mean over the others and the copies."""
    weights = np.random.default_rng(4).normal(size=(3, 5, 2))
    predicted = regressed(grid_of(weights, np.ones((5, 9))))
    for k in range(3):
        assert np.allclose(predicted[k], np.delete(weights, k, axis=0).mean(axis=(0, 1)))


def test_one_object_has_nothing_to_learn_from() -> None:
    """The prediction is NaN, and so is its error."""
    grid = grid_of(np.ones((1, 3, 2)), np.eye(9)[:3])
    assert np.isnan(regressed(grid)).all()
    assert regressed(grid).shape == (1, 3, 2)


@pytest.mark.parametrize("objects", [2, 3])
def test_weights_alike_everywhere_are_kept(objects: int) -> None:
    """A constant needs no light to be learned."""
    grid = grid_of(np.full((objects, 4, 2), 0.3), np.random.default_rng(5).normal(size=(4, 9)))
    assert np.allclose(regressed(grid), 0.3, atol=1e-6)


def test_own_lights_that_are_shared_are_regressed_as_shared_ones() -> None:
    """Where all objects have the same lights, the prediction is that of `regressed`.

    Asked for as many neighbours as there are points of others at whole lights.
    """
    generator = np.random.default_rng(3)
    lights = generator.normal(size=(7, 9))
    grid = grid_of(generator.normal(size=(4, 7, 2)), lights)
    own = np.broadcast_to(lights, (4, 7, 9))
    for neighbours in (3, 9, 21):
        one = regressed(grid, neighbours)
        assert np.allclose(regressed_by_own_lights(grid.oracle, own, neighbours), one)


def test_a_missing_cell_teaches_nothing() -> None:
    """A NaN weight has a NaN prediction and leaves the others what they would be without it."""
    generator = np.random.default_rng(4)
    lights, oracle = generator.normal(size=(3, 5, 9)), generator.normal(size=(3, 5, 2))
    oracle[0, 2] = np.nan
    found = regressed_by_own_lights(oracle, lights)
    assert np.isnan(found[0, 2]).all()
    assert np.isfinite(np.delete(found.reshape(-1, 2), 2, axis=0)).all()
