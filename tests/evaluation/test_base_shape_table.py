"""Tests of the study of base shapes: its grid and the table made of the rows."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np
import pytest

from datasets.model_parameters import shipped_parameters
from datasets.records import LitPhotograph
from datasets.synthetic import Synthetic
from evaluation.base_shape_grid import (
    available_shapes,
    available_variants,
    base_shape_experiment,
)
from evaluation.base_shape_models import BaseShapeContext
from evaluation.base_shape_table import RULES, BaseShapeTable, base_shape_table
from evaluation.base_shapes import BASE_SHAPES
from evaluation.experiment import Experiment
from evaluation.grid_run import run_grid
from evaluation.grid_status import GridStatus, grid_status
from evaluation.row_store import MemoryRows
from evaluation.study_variants import TABLE, VARIANTS
from shading_model.errors import RelightlabError
from tests.evaluation.conftest import OBJECTS
from tests.evaluation.sirfs.fake_fits import diverging_fit, pretend

NEEDING_TRUTH = ("ground-truth", "kinect")
MEASURED = (TABLE, "half-height", "small-object")


@pytest.fixture(scope="module")
def measured(tiny_set: Synthetic) -> Iterator[tuple[Experiment, GridStatus]]:
    """Three variants of every shape on the tiny set, with fits that cost nothing."""
    with pytest.MonkeyPatch.context() as patch:
        pretend(patch)
        context = BaseShapeContext(tiny_set, shipped_parameters())
        experiment = base_shape_experiment(context, MEASURED)
        yield experiment, run_grid(experiment, MemoryRows())


@pytest.fixture(scope="module")
def table(measured: tuple[Experiment, GridStatus]) -> BaseShapeTable:
    """The table of `measured`."""
    return base_shape_table(*measured)


def test_the_grid_is_variants_by_objects_by_shapes_by_lights(
    measured: tuple[Experiment, GridStatus],
) -> None:
    """Every cell is there once, and every one was measured."""
    experiment, status = measured
    assert experiment.size == len(MEASURED) * len(OBJECTS) * len(BASE_SHAPES) * 10
    assert status.complete
    assert not status.failed


def test_rows_have_every_shape_and_rule(table: BaseShapeTable) -> None:
    """There is one row for each rule and shape, each over all objects and cells."""
    rows = table.rows()
    assert [(row["weights"], row["shape"]) for row in rows] == [
        (rule, shape) for rule in RULES for shape in BASE_SHAPES
    ]
    for row in rows:
        assert (row["dataset"], row["objects"], row["cells"]) == ("synthetic", 3, 30)
        assert row["low"] <= row["imse"] <= row["high"]
        assert 0 < row["relative_imse"] < 1


def test_a_mean_is_that_of_the_objects(table: BaseShapeTable) -> None:
    """The entry of a shape is the mean of its entries by object."""
    for row in table.rows():
        own = [
            one["imse"]
            for one in table.object_rows()
            if (one["shape"], one["weights"]) == (row["shape"], row["weights"])
        ]
        assert row["imse"] == pytest.approx(np.mean(own))


def test_no_rule_is_better_than_the_oracle(table: BaseShapeTable) -> None:
    """In every variant, shape, object and light the oracle has the least error."""
    for variant in MEASURED:
        for shape in BASE_SHAPES:
            oracle = table.errors[variant, shape, "oracle"]
            for rule in RULES:
                assert (oracle <= table.errors[variant, shape, rule] * (1 + 1e-9)).all()


def test_no_shape_is_better_than_the_true_one(table: BaseShapeTable) -> None:
    """Under known lights the true shape has the least error, whatever the rule."""
    for rule in RULES:
        means = {shape: table.errors[TABLE, shape, rule].mean() for shape in BASE_SHAPES}
        assert min(means, key=lambda shape: means[shape]) == "ground-truth"


def test_a_flat_shape_does_not_depend_on_its_height(table: BaseShapeTable) -> None:
    """Half of nothing is nothing; the other shapes do change."""
    for shape in BASE_SHAPES:
        half, whole = (table.errors[v, shape, "oracle"] for v in ("half-height", TABLE))
        flat = shape in {"flat", "sirfs", "sirfs-stereo"}  # the fake fits are flat
        assert np.array_equal(half, whole) == flat


def test_a_smaller_object_changes_the_simulated_sensor_alone(table: BaseShapeTable) -> None:
    """The variant of the sensor leaves every other shape its errors, to the bit."""
    for shape in BASE_SHAPES:
        small, usual = (table.errors[v, shape, "oracle"] for v in ("small-object", TABLE))
        assert np.array_equal(small, usual) == (shape != "kinect")


def test_sensitivity_orders_the_published_four(table: BaseShapeTable) -> None:
    """Each variant and rule has the order of the four rivals, from least to most error."""
    rows = table.sensitivity()
    assert len(rows) == len(MEASURED) * len(RULES)
    for row in rows:
        assert sorted(row["order"]) == sorted({"contour", "kinect", "sirfs", "sirfs-stereo"})
        errors = [row["imse"][shape] for shape in row["order"]]
        assert errors == sorted(errors)


def test_tests_and_pairs_are_over_the_rivals(table: BaseShapeTable) -> None:
    """Friedman's test is over three objects and four shapes, with six pairs for each rule."""
    assert [(t["weights"], t["objects"], t["methods"]) for t in table.tests()] == [
        (rule, 3, 4) for rule in RULES
    ]
    assert len(table.pairs()) == 6 * len(RULES)
    assert all(row["wins"] + row["losses"] <= 3 for row in table.pairs())


def test_a_missing_cell_is_missing_alone(measured: tuple[Experiment, GridStatus]) -> None:
    """One cell that failed is named with its reason, and its shape is counted without it."""
    experiment, status = measured
    key = (TABLE, "bear", "kinect", "03")
    failed = {**status.rows[key], "status": "failed", "reason": "no power", "values": {}}
    rows = {**status.rows, key: failed}
    found = base_shape_table(experiment, GridStatus(rows, (key,), 0, ()))
    assert found.missing[0]["object"] == "bear"
    assert "no power" in found.missing[0]["reason"]
    counts = {row["shape"]: row["cells"] for row in found.rows() if row["weights"] == "default"}
    assert counts == {shape: 30 - (shape == "kinect") for shape in BASE_SHAPES}
    assert all(math.isfinite(row["imse"]) for row in found.rows())


def test_a_fit_that_fails_leaves_the_other_shapes(
    tiny_set: Synthetic, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where SIRFS cannot be fitted, its cells alone are missing, with the reason."""
    pretend(monkeypatch, diverging_fit)
    context = BaseShapeContext(tiny_set, shipped_parameters())
    experiment = base_shape_experiment(context, objects=["cup"])
    rows = MemoryRows()
    run_grid(experiment, rows)
    missing = grid_status(experiment, rows).missing
    assert {key[2] for key in missing} == {"sirfs", "sirfs-stereo"}
    found = base_shape_table(experiment, grid_status(experiment, rows))
    assert any("diverged" in one["reason"] for one in found.missing)
    failed = ("sirfs", "sirfs-stereo")
    for row in found.rows():
        known = row["shape"] not in failed and row["weights"] != "regression"
        assert (row["objects"], math.isfinite(row["imse"])) == (int(known), known)
        assert math.isfinite(row["relative_imse"]) is known


def test_an_object_that_a_shape_failed_on_is_in_no_mean(table: BaseShapeTable) -> None:
    """Every shape's means are over the same objects, as many as the row says."""
    errors = {key: found.copy() for key, found in table.errors.items()}
    for rule in RULES:
        errors[TABLE, "sirfs", rule][0] = np.nan
    for row in dataclasses.replace(table, errors=errors).rows():
        own = table.errors[TABLE, row["shape"], row["weights"]][1:]
        assert row["objects"] == len(own)
        assert row["imse"] == pytest.approx(own.mean())
        assert row["relative_imse"] == pytest.approx(own.mean() / table.power[TABLE][1:].mean())


def test_without_the_contour_there_is_no_difference_to_it(table: BaseShapeTable) -> None:
    """Differences are to the contour shape or to nothing."""
    for row in dataclasses.replace(table, shapes=("kinect", "flat")).rows():
        assert math.isfinite(row["imse"])
        assert math.isnan(row["difference"])


def test_every_variant_can_be_measured(tiny_set: Synthetic) -> None:
    """Each of them gives the contour of a cup ten finite errors; leaving one out, others."""
    context = BaseShapeContext(tiny_set, shipped_parameters())
    experiment = base_shape_experiment(context, tuple(VARIANTS), ["contour"], ["cup"])
    found = base_shape_table(experiment, run_grid(experiment, MemoryRows()))
    assert not found.missing
    means = {variant: found.errors[variant, "contour", "oracle"].mean() for variant in VARIANTS}
    assert all(map(math.isfinite, means.values()))
    assert means["leave-one-out"] != means[TABLE]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"variants": ["mean", "median"]}, "Unknown variant 'median'"),
        ({"shapes": ["contur"]}, "Unknown base shape 'contur'"),
        ({"objects": ["teapot"]}, "Unknown object 'teapot'"),
    ],
)
def test_unknown_names_are_refused(
    tiny_set: Synthetic, changes: dict[str, list[str]], words: str
) -> None:
    """Names that are not there are refused before anything is measured."""
    context = BaseShapeContext(tiny_set, shipped_parameters())
    with pytest.raises(RelightlabError, match=words):
        base_shape_experiment(context, **changes)


class Lit(Synthetic):
    """A set whose objects have as many photographs as is said."""

    counts: dict[str, int]

    def lit_photographs(self, name: str) -> tuple[LitPhotograph, ...]:
        """Return the first photographs alone."""
        return super().lit_photographs(name)[: self.counts[name]]


@pytest.mark.parametrize(
    ("counts", "words"),
    [
        ((0, 0, 0), "has no photographs of its objects under other lights"),
        ((10, 9, 10), "expected equally many .* got bear 10, cup 9, medal 10"),
    ],
)
def test_photographs_that_do_not_match_in_number_are_refused(
    tiny_set: Synthetic, counts: tuple[int, ...], words: str
) -> None:
    """A set without photographs under other lights, or with other numbers, is refused."""
    lacking = Lit(tiny_set.root)
    lacking.counts = dict(zip(OBJECTS, counts, strict=True))
    with pytest.raises(RelightlabError, match=words):
        base_shape_experiment(BaseShapeContext(lacking, shipped_parameters()))


def test_sets_say_what_they_lack(tiny_set: Synthetic) -> None:
    """Without a diffuse photograph or a true shape, what needs it is not offered."""

    class Lacking(Synthetic):
        has_diffuse_photograph = False
        has_true_shape = False

    lacking = Lacking(tiny_set.root)
    assert set(available_variants(tiny_set)) - set(available_variants(lacking)) == {"diffuse"}
    assert set(BASE_SHAPES) - set(available_shapes(lacking)) == set(NEEDING_TRUTH)
    assert available_shapes(tiny_set) == tuple(BASE_SHAPES)


def test_variants_are_described_apart() -> None:
    """Each variant has words of its own, so that no two rows of the table look the same."""
    assert len({one.words for one in VARIANTS.values()}) == len(VARIANTS)
