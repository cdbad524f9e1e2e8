"""Tests of experiments: their cells and tasks, and the contract that every one of them keeps."""

from __future__ import annotations

import math
from typing import Any

import pytest

from datasets.model_parameters import shipped_parameters
from datasets.synthetic import Synthetic
from evaluation.experiment import Experiment, parse_only
from evaluation.grid_run import RunOptions, measure_task, run_grid
from evaluation.registry import EXPERIMENTS
from evaluation.row_store import MemoryRows
from shading_model.errors import RelightlabError
from tests.evaluation.conftest import LIGHTS
from tests.evaluation.small_grids import LIGHTS as SMALL_LIGHTS
from tests.evaluation.small_grids import OBJECTS, small_experiment


@pytest.fixture(params=sorted(EXPERIMENTS))
def experiment(request: pytest.FixtureRequest, tiny_set: Synthetic) -> Experiment:
    """Every registered experiment, on the tiny set."""
    return EXPERIMENTS[request.param](tiny_set, LIGHTS[:2], shipped_parameters())


def values_of(rows: list[dict[str, Any]]) -> dict[tuple[str, ...], object]:
    """Return what rows say of each cell, without how long it took."""
    return {tuple(row["cell"].values()): (row["status"], row["values"]) for row in rows}


@pytest.mark.slow
def test_every_experiment_keeps_the_contract(experiment: Experiment) -> None:
    """Cells are finite or failed with a reason, and depend on neither order, workers nor others."""
    store = MemoryRows()
    run_grid(experiment, store)
    rows = store.read()[0]
    assert [row["cell"] for row in rows] != []
    for row in rows:
        finite = bool(row["values"]) and all(map(math.isfinite, row["values"].values()))
        assert (row["status"] == "done" and finite) or row["reason"]
    expected = values_of(rows)
    assert set(expected) == set(map(experiment.key, experiment.cells()))

    two_workers = MemoryRows()
    run_grid(experiment, two_workers, RunOptions(workers=2))
    assert values_of(two_workers.read()[0]) == expected

    last_task = experiment.tasks(experiment.cells())[-1]
    backwards = measure_task(experiment, last_task[::-1])
    assert values_of(backwards).items() <= expected.items()
    assert len(backwards) == len(last_task)
    alone = measure_task(experiment, last_task[:1])
    assert values_of(alone).items() <= expected.items()


def test_a_registered_experiment_is_named_as_registered(experiment: Experiment) -> None:
    """The name, axes and inputs of an experiment are filled in, and its cells are distinct."""
    assert experiment.name in EXPERIMENTS
    assert {"data", "code"} <= set(experiment.inputs)
    cells = list(map(experiment.key, experiment.cells()))
    assert len(cells) == len(set(cells)) == experiment.size > 0


def test_cells_are_the_product_of_the_axes() -> None:
    """Cells come in grid order, the last axis fastest, and tasks group them by what is shared."""
    experiment = small_experiment()
    cells = list(experiment.cells())
    assert [experiment.key(cell) for cell in cells[:4]] == [
        ("apple", "00"),
        ("apple", "01"),
        ("apple", "02"),
        ("bear", "00"),
    ]
    assert len(cells) == experiment.size == len(OBJECTS) * len(SMALL_LIGHTS)
    tasks = experiment.tasks(cells)
    assert [len(task) for task in tasks] == [3, 3, 3, 3]
    assert [cell for task in tasks for cell in task] == cells


def test_only_some_cells() -> None:
    """Wanted values keep the order of the axis, whatever order they are asked for in."""
    cells = small_experiment().cells({"object": ["cup", "apple"], "light": ["01"]})
    assert [cell["object"] for cell in cells] == ["apple", "cup"]


@pytest.mark.parametrize(
    ("only", "words"),
    [
        ({"objects": ["cup"]}, "Unknown axis 'objects'. Did you mean 'object'?"),
        ({"object": ["cap"]}, "Unknown object 'cap'. Did you mean 'cup'?"),
    ],
)
def test_unknown_axes_and_values(only: dict[str, list[str]], words: str) -> None:
    """What the grid does not have is refused with the nearest name it has."""
    with pytest.raises(RelightlabError) as caught:
        list(small_experiment().cells(only))
    assert words in str(caught.value)


@pytest.mark.parametrize("word", ["object", "object=", "object=,", "object= , "])
def test_words_that_choose_nothing(word: str) -> None:
    """A word without an axis's value is refused with the form expected."""
    with pytest.raises(RelightlabError, match="expected axis=value"):
        parse_only([word])


def test_the_input_hash_holds_everything() -> None:
    """Another name, version or input is another hash; another context or seed name is not."""
    changes: list[dict[str, Any]] = [
        {},
        {"name": "other"},
        {"version": 2},
        {"inputs": {"data": "cd"}},
    ]
    assert len({small_experiment(**change).input_hash() for change in changes}) == 4
    assert small_experiment(seed="x").input_hash() == small_experiment().input_hash()
