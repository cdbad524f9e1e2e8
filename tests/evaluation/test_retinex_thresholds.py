"""Retinex thresholds learned leave-one-object-out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from datasets.mit_berkeley import OBJECTS, SETTINGS, MitBerkeley
from datasets.records import Capture, GroundTruth, LitPhotograph, Photograph
from datasets.synthetic import Synthetic
from evaluation.intrinsic_metrics import intrinsic_error
from evaluation.retinex_thresholds import (
    CHROMATICITY,
    GRAY,
    default_thresholds,
    error_grid,
    learn,
    leave_one_out,
    shipped_table,
    thresholds_for,
)
from shading_model.errors import RelightlabError
from shading_model.retinex import DEFAULT_THRESHOLDS, Retinex, RetinexThresholds, retinex

SHAPE = (len(GRAY), len(CHROMATICITY))


def test_the_table_is_complete() -> None:
    """Both settings, all objects, every pair on the searched grid and not at its end."""
    table = shipped_table()
    assert set(table["settings"]) == set(SETTINGS)
    for learned in table["settings"].values():
        assert set(learned["without"]) == set(OBJECTS)
        for gray, chromaticity in [learned["all"], *learned["without"].values()]:
            assert gray in GRAY[1:-1]
            assert chromaticity in CHROMATICITY[1:-1]


def test_an_object_gets_what_was_learned_without_it() -> None:
    """Known sets, settings and objects have thresholds; all else has none."""
    pair = shipped_table()["settings"]["natural"]["without"]["teabag1"]
    assert thresholds_for("mit-berkeley", "natural", "teabag1") == RetinexThresholds(*pair)
    assert thresholds_for("mit-berkeley", "natural", "bear") is None
    assert thresholds_for("mit-berkeley", "studio", "teabag1") is None
    assert thresholds_for("synthetic", "natural", "teabag1") is None


def test_ordinary_photographs_get_the_learned_defaults() -> None:
    """What the shading model uses where nothing else is said is what was learned."""
    assert default_thresholds() == DEFAULT_THRESHOLDS


@given(st.integers(0, 2**32 - 1))
def test_the_best_pair_is_that_of_the_others(seed: int) -> None:
    """For each object, the least mean error over the remaining ones, found by deleting it."""
    errors = np.random.default_rng(seed).random((5, *SHAPE))
    everything, without = leave_one_out(errors)
    row, column = np.argwhere(errors.mean(axis=0) == errors.mean(axis=0).min())[0]
    assert everything == RetinexThresholds(GRAY[row], CHROMATICITY[column])
    for index, found in enumerate(without):
        others = np.delete(errors, index, axis=0).mean(axis=0)
        at = others[GRAY.index(found.gray), CHROMATICITY.index(found.chromaticity)]
        assert np.isclose(at, others.min(), rtol=1e-12)


def test_an_object_never_votes_on_its_own_thresholds() -> None:
    """An object that wants one pair badly gets the others' choice."""
    errors = np.ones((4, *SHAPE))
    errors[0, 2, 3] = -100
    errors[1:, 5, 6] = 0.5
    everything, without = leave_one_out(errors)
    assert everything == RetinexThresholds(GRAY[2], CHROMATICITY[3])
    assert without[0] == RetinexThresholds(GRAY[5], CHROMATICITY[6])
    assert without[1:] == [everything] * 3


def direct_error(capture: Capture, thresholds: RetinexThresholds) -> float:
    """The score of one photograph's separation."""
    photograph, truth = capture.photograph, capture.truth
    assert truth.albedo is not None
    assert truth.shading is not None
    parts = retinex(photograph.image, photograph.mask, thresholds)
    return intrinsic_error(
        parts.albedo, parts.shading, truth.albedo, truth.shading, photograph.mask
    )


def test_the_grid_holds_the_score_of_every_pair(tiny_set: Synthetic) -> None:
    """Rows are gray thresholds, columns those of chromaticity."""
    grid = error_grid(tiny_set, "cup", "laboratory")
    capture = tiny_set.load("cup", "laboratory")
    assert grid.shape == SHAPE
    assert np.ptp(grid) > 0
    for row, column in ((0, 0), (3, 8), (8, 2)):
        expected = direct_error(capture, RetinexThresholds(GRAY[row], CHROMATICITY[column]))
        assert np.isclose(grid[row, column], expected, rtol=1e-9)


def test_learning_writes_down_the_least_mean_error(tiny_set: Synthetic) -> None:
    """Thresholds, mean error and fingerprint belong to the set they were learned on."""
    table = learn(tiny_set, workers=1)
    assert table["dataset"] == "synthetic"
    assert table["fingerprint"] == tiny_set.fingerprint()
    learned = table["settings"]["natural"]
    chosen = RetinexThresholds(*learned["all"])
    errors = [direct_error(tiny_set.load(name, "natural"), chosen) for name in tiny_set.objects]
    assert np.isclose(learned["least_mean_lmse"], np.mean(errors), atol=1e-6)
    assert set(learned["without"]) == set(tiny_set.objects)


class WithoutTruth:
    """A set whose photographs have no truth."""

    name, objects, settings = "bare", ("one",), ("natural",)

    def load(self, name: str, setting: str) -> Capture:
        """A white square."""
        photograph = Photograph(np.ones((5, 5, 3)), np.ones((5, 5), bool), name, "made")
        return Capture(photograph, GroundTruth(), setting)

    def lit_photographs(self, name: str) -> tuple[LitPhotograph, ...]:
        """None."""
        del name
        return ()

    def fingerprint(self) -> str:
        """Nothing to hash."""
        return ""


def test_learning_needs_the_truth() -> None:
    """A set without albedo and shading is told so by the object's name."""
    with pytest.raises(RelightlabError, match="the true albedo and shading of one"):
        error_grid(WithoutTruth(), "one", "natural")


@pytest.mark.real_data
def test_the_table_belongs_to_the_present_set(mit_berkeley_root: Path) -> None:
    """The fingerprint written beside the thresholds is that of the files."""
    assert MitBerkeley(mit_berkeley_root).fingerprint() == shipped_table()["fingerprint"]


@pytest.mark.real_data
@pytest.mark.slow
@pytest.mark.parametrize("setting", SETTINGS)
def test_the_shipped_thresholds_are_the_best_of_their_neighbourhood(
    mit_berkeley_root: Path, setting: str
) -> None:
    """Over all objects their mean error is the one claimed, and no neighbouring pair's is less.

    Likewise for those learned without an object, over the nineteen others.
    """
    learned = shipped_table()["settings"][setting]
    row, column = GRAY.index(learned["all"][0]), CHROMATICITY.index(learned["all"][1])
    around = [(row, column), (row - 1, column), (row + 1, column), (row, column - 1),
              (row, column + 1)]  # fmt: skip
    dataset = MitBerkeley(mit_berkeley_root)
    errors = []
    for name in OBJECTS:
        capture = dataset.load(name, setting)
        truth, mask = capture.truth, capture.photograph.mask
        assert truth.albedo is not None
        assert truth.shading is not None
        separator = Retinex(capture.photograph.image, mask)
        parts = [separator.separate(RetinexThresholds(GRAY[i], CHROMATICITY[j])) for i, j in around]
        errors.append(
            [intrinsic_error(p.albedo, p.shading, truth.albedo, truth.shading, mask) for p in parts]
        )
    means = np.mean(errors, axis=0)
    assert np.isclose(means[0], learned["least_mean_lmse"], rtol=1e-4)
    assert means.argmin() == 0
    pairs = [[GRAY[i], CHROMATICITY[j]] for i, j in around]
    for index, name in enumerate(OBJECTS):
        others = np.delete(errors, index, axis=0).mean(axis=0)
        if learned["without"][name] in pairs:
            assert others.argmin() == pairs.index(learned["without"][name])


@pytest.mark.real_data
@pytest.mark.slow
@pytest.mark.parametrize("name", ["apple", "potato"])
def test_the_grid_of_a_measured_object_is_its_direct_score(
    mit_berkeley_root: Path, name: str
) -> None:
    """At the thresholds learned without it, the searched grid holds the score measured here."""
    dataset = MitBerkeley(mit_berkeley_root)
    for setting in SETTINGS:
        thresholds = thresholds_for("mit-berkeley", setting, name)
        assert thresholds is not None
        grid = error_grid(dataset, name, setting)
        at = grid[GRAY.index(thresholds.gray), CHROMATICITY.index(thresholds.chromaticity)]
        assert np.isclose(at, direct_error(dataset.load(name, setting), thresholds), rtol=1e-6)
