"""Re-rendering error of one object under many lights (`eq:MSEmetric`)."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from datasets.records import GroundTruth
from evaluation.rerendering import RerenderingCell, rerendering_cells, target_image
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ObjectModel, Weights
from tests.evaluation.cells import random_lights, random_model, random_truth

seeds = st.integers(0, 2**32 - 1)
weight = st.floats(-3, 3)


def direct_error(
    model: ObjectModel, truth: GroundTruth, light: LogHarmonics, weights: Weights, channels: str
) -> float:
    """Both pictures, the scale k >= 0 that fits best, and the mean squared difference."""
    target, relit = target_image(truth, light), model.relight(light, weights)
    compared = np.isfinite(target).all(axis=-1) & model.mask
    wanted, ours = target[compared], relit[compared]
    if channels == "gray":
        wanted, ours = wanted.mean(axis=-1), ours.mean(axis=-1)
    k = max(np.vdot(ours, wanted) / np.vdot(ours, ours), 0.0)
    return float(np.mean((wanted - k * ours) ** 2))


@settings(max_examples=40)
@given(seeds, weight, weight, st.sampled_from(["gray", "color"]))
def test_a_cell_gives_the_error_of_the_pictures(
    seed: int, parametric: float, geometric: float, channels: str
) -> None:
    """For any weights, from inner products alone, as measured on the two pictures."""
    generator = np.random.default_rng(seed)
    model, truth = random_model(generator), random_truth(generator)
    lights, weights = random_lights(generator), Weights(parametric, geometric)
    cells = rerendering_cells(model, truth, lights, channels)
    for cell, light in zip(cells, lights, strict=True):
        expected = direct_error(model, truth, light, weights, channels)
        assert np.isclose(cell.error(weights), expected, rtol=1e-9, atol=1e-13)


@settings(max_examples=60)
@given(seeds, weight, weight, st.sampled_from([0.02, 0.2, 1.0]))
def test_no_weights_beat_the_oracle(
    seed: int, parametric: float, geometric: float, detail: float
) -> None:
    """Whatever another rule chose, on any model whose coarse shading is not opposed."""
    generator = np.random.default_rng(seed)
    model, truth = random_model(generator, detail), random_truth(generator)
    for cell in rerendering_cells(model, truth, random_lights(generator)):
        assert np.linalg.solve(cell.gram, cell.cross)[0] > 0
        best = cell.error(cell.oracle())
        for weights in (Weights(parametric, geometric), Weights(0, 0), Weights(1, 1)):
            assert best <= cell.error(weights) + 1e-12 * cell.power


def test_the_oracle_is_joint_least_squares() -> None:
    """Over k, k w_p and k w_g on the pictures themselves."""
    generator = np.random.default_rng(3)
    model, truth = random_model(generator), random_truth(generator)
    (light,) = random_lights(generator, 1)
    (cell,) = rerendering_cells(model, truth, [light], "color")
    compared = np.isfinite(target_image(truth, light)).all(axis=-1) & model.mask
    layers = np.stack(
        [
            model.relight(light, Weights(0, 0))[compared].ravel(),
            (model.albedo * model.parametric_residual[..., None])[compared].ravel(),
            (model.albedo * model.geometric_detail[..., None])[compared].ravel(),
        ],
        axis=-1,
    )
    target = target_image(truth, light)[compared].ravel()
    k, *scaled = np.linalg.lstsq(layers, target, rcond=None)[0]
    assert np.isclose(cell.oracle().parametric, scaled[0] / k)
    assert np.isclose(cell.oracle().geometric, scaled[1] / k)


@given(seeds, st.floats(1e-3, 1e3))
@settings(max_examples=20)
def test_scaling_the_target_scales_the_error_by_the_square(seed: int, scale: float) -> None:
    """IMSE by c^2; the relative error, the weights and the order of rules stay."""
    generator = np.random.default_rng(seed)
    model, truth, lights = (
        random_model(generator),
        random_truth(generator),
        random_lights(generator),
    )
    assert truth.albedo is not None
    scaled = dataclasses.replace(truth, albedo=scale * truth.albedo)
    for one, other in zip(
        rerendering_cells(model, truth, lights),
        rerendering_cells(model, scaled, lights),
        strict=True,
    ):
        for weights in (Weights(0, 0), Weights(1, 1), one.oracle()):
            assert np.isclose(other.error(weights), scale**2 * one.error(weights), rtol=1e-7)
            relative = one.error(weights) / one.power
            assert np.isclose(other.error(weights) / other.power, relative, rtol=1e-7)
        assert np.isclose(other.oracle().parametric, one.oracle().parametric, rtol=1e-6)


@given(seeds, st.floats(1e-2, 1e2))
@settings(max_examples=20)
def test_the_scale_of_the_model_does_not_matter(seed: int, scale: float) -> None:
    """A brighter model is scaled back by k."""
    generator = np.random.default_rng(seed)
    model, truth, lights = (
        random_model(generator),
        random_truth(generator),
        random_lights(generator),
    )
    brighter = dataclasses.replace(model, albedo=scale * model.albedo)
    for one, other in zip(
        rerendering_cells(model, truth, lights),
        rerendering_cells(brighter, truth, lights),
        strict=True,
    ):
        assert np.isclose(one.error(Weights(1, 0.5)), other.error(Weights(1, 0.5)), rtol=1e-7)


def true_model(truth: GroundTruth, generator: np.random.Generator) -> ObjectModel:
    """A model made of the truth, with no detail."""
    model = random_model(generator)
    assert truth.normals is not None
    assert truth.albedo is not None
    nothing = np.zeros(model.mask.shape)
    return dataclasses.replace(
        model,
        normals=truth.normals,
        albedo=truth.albedo,
        parametric_residual=nothing,
        geometric_detail=nothing,
    )


@given(seeds, st.sampled_from(["gray", "color"]))
@settings(max_examples=20)
def test_ground_truth_in_gives_zero(seed: int, channels: str) -> None:
    """True normals and albedo are relit without error by every rule, and need no weights."""
    generator = np.random.default_rng(seed)
    truth = random_truth(generator)
    model = true_model(truth, generator)
    for cell in rerendering_cells(model, truth, random_lights(generator), channels):
        assert cell.oracle() == Weights(0, 0)
        for weights in (Weights(0, 0), Weights(1, 1), cell.oracle()):
            assert cell.error(weights) < 1e-12


def test_a_missing_detail_is_found_by_the_oracle() -> None:
    """A target that is the model itself at weights (0.7, -0.4) gives these weights and no error."""
    generator = np.random.default_rng(5)
    layers = np.column_stack([np.ones(50), generator.normal(size=(50, 2))])
    target = 2.5 * layers @ [1, 0.7, -0.4]
    cell = RerenderingCell(
        layers.T @ layers / 50, layers.T @ target / 50, float(target @ target / 50)
    )
    assert np.allclose(dataclasses.astuple(cell.oracle()), (0.7, -0.4))
    assert cell.error(cell.oracle()) < 1e-12
    assert cell.error(Weights(0, 0)) > 0.1


def test_an_opposed_coarse_shading_gets_no_light() -> None:
    """Where the best k would be negative, k is zero: the whole target is the error."""
    cell = RerenderingCell(np.eye(3), np.array([-0.5, 0.0, 0.0]), power=2.0)
    assert cell.error(Weights(0, 0)) == 2.0
    assert cell.oracle() == Weights(0, 0)


@settings(max_examples=100)
@given(seeds, weight, weight)
def test_no_weights_beat_the_oracle_where_the_coarse_shading_is_opposed(
    seed: int, parametric: float, geometric: float
) -> None:
    """Any columns and target, also such that the best joint k would be negative."""
    columns = np.random.default_rng(seed).normal(size=(6, 4))
    gram = columns.T @ columns
    cell = RerenderingCell(gram[:3, :3], gram[:3, 3], float(gram[3, 3]))
    best = cell.error(cell.oracle())
    for weights in (Weights(parametric, geometric), Weights(0, 0), Weights(1, 1)):
        assert best <= cell.error(weights) + 1e-9 * cell.power


def test_unknown_weights_have_an_unknown_error() -> None:
    """A rule that could not choose (NaN) does not pass for one that did."""
    cell = RerenderingCell(np.eye(3), np.full(3, 0.5), power=2.0)
    assert np.isnan(cell.error(Weights(np.nan, 0.0)))
    assert np.isnan(cell.error(Weights(0.0, np.nan)))


def test_an_empty_layer_gets_no_weight() -> None:
    """A layer of zeros, or of rounding, is not divided by."""
    gram = np.diag([1.0, 0.0, 1e-20])
    cell = RerenderingCell(gram, np.array([0.5, 0.0, 1e-11]), power=1.0)
    assert cell.oracle() == Weights(0, 0)


def test_layers_that_are_alike_share_their_weight() -> None:
    """Two equal layers leave the sum of their weights determined, and the weights finite."""
    layer = np.random.default_rng(6).normal(size=40)
    layers = np.stack([np.ones(40), layer, layer], axis=-1)
    target = layers @ [1.0, 0.8, 0.0]
    cell = RerenderingCell(layers.T @ layers, layers.T @ target, float(target @ target))
    assert np.allclose(dataclasses.astuple(cell.oracle()), (0.4, 0.4))
    assert cell.error(cell.oracle()) < 1e-9


def test_targets_are_nan_where_the_truth_is_unknown() -> None:
    """And take a light of three colours too."""
    truth = random_truth(np.random.default_rng(7))
    assert truth.normals is not None
    colored = target_image(truth, LogHarmonics(np.zeros((9, 3))))
    assert (np.isnan(colored) == np.isnan(truth.normals)).all()
    known = np.isfinite(colored)
    assert truth.albedo is not None
    assert np.allclose(colored[known], truth.albedo[known])


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"truth": GroundTruth()}, "needs the true normals and the true albedo"),
        ({"lights": ()}, "at least one light to relight by, got none"),
        ({"lights": (LogHarmonics(np.zeros((9, 3))),)}, "lights of one colour"),
        ({"channels": "grey"}, "Unknown channels 'grey'. Did you mean 'gray'"),
    ],
)
def test_bad_input_is_one_sentence(change: dict[str, object], sentence: str) -> None:
    """No truth, no lights, coloured lights, unknown channels."""
    generator = np.random.default_rng(8)
    arguments: dict[str, object] = {
        "model": random_model(generator),
        "truth": random_truth(generator),
        "lights": random_lights(generator),
    }
    with pytest.raises(RelightlabError, match=sentence):
        rerendering_cells(**{**arguments, **change})  # type: ignore[arg-type]


def test_a_truth_of_another_size_or_elsewhere_is_refused() -> None:
    """Sizes that differ, and a truth that is known nowhere on the mask."""
    generator = np.random.default_rng(9)
    model, truth, lights = (
        random_model(generator),
        random_truth(generator),
        random_lights(generator),
    )
    assert truth.normals is not None
    assert truth.albedo is not None
    smaller = GroundTruth(normals=truth.normals[1:], albedo=truth.albedo[1:])
    with pytest.raises(RelightlabError, match=r"shape \(9, 11\) but its truth of \(8, 11\)"):
        rerendering_cells(model, smaller, lights)
    elsewhere = dataclasses.replace(
        truth, normals=np.where(model.mask[..., None], np.nan, truth.normals)
    )
    with pytest.raises(RelightlabError, match="known nowhere on the mask"):
        rerendering_cells(model, elsewhere, lights)
