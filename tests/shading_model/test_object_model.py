"""The object model (`eq:model`)."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shading_model.arrays import Image, Mask
from shading_model.errors import RelightlabError
from shading_model.geometric_detail import PatchDictionary, geometric_detail, unit_atoms
from shading_model.illumination import LinearHarmonics, LogHarmonics, PointLights
from shading_model.object_model import (
    CoarseShape,
    ModelParameters,
    ObjectModel,
    Weights,
    assemble_model,
    build_model,
    contour_base,
    split_by_shading,
)
from shading_model.retinex import MEAN_SHADING, RetinexThresholds, retinex
from tests.shading_model.outlines import disk, dome, unit_normals

PARAMETERS = ModelParameters(
    PatchDictionary(unit_atoms(np.random.default_rng(0).normal(size=(20, 16))).reshape(20, 4, 4)),
    RetinexThresholds(0.5, 0.1),
)
LIGHT = LogHarmonics(np.array([-0.3, 0.2, 0.4, 0.1, 0.1, -0.1, 0.2, 0.0, 0.1]))
weights = st.floats(-2, 3)


def photographed(radius: int = 20, seed: int = 0) -> tuple[Image, Mask]:
    """A two-coloured dome under a log-harmonic light, with a little noise."""
    mask, _, normals = dome(radius)
    albedo = np.where(
        np.indices(mask.shape)[1][..., None] > radius, [0.7, 0.3, 0.2], [0.2, 0.5, 0.6]
    )
    noise = np.random.default_rng(seed).lognormal(sigma=0.03, size=mask.shape)
    image = albedo * (LIGHT.shade(normals) * noise)[..., None]
    return np.where(mask[..., None], image, 0.3), mask


IMAGE, MASK = photographed()
MODEL = build_model(IMAGE, MASK, PARAMETERS)


@given(weights, weights)
@settings(max_examples=20)
def test_shading_is_the_papers_sum(parametric: float, geometric: float) -> None:
    """S = shade(Z, L) + w_p S_p + w_g S_g, for lights of one colour and of three."""
    chosen = Weights(parametric, geometric)
    detail = parametric * MODEL.parametric_residual + geometric * MODEL.geometric_detail
    gray = LIGHT.shade(MODEL.normals) + detail
    assert np.allclose(MODEL.shade(LIGHT, chosen)[MASK], gray[MASK], rtol=1e-12)
    assert np.allclose(
        MODEL.relight(LIGHT, chosen)[MASK], (MODEL.albedo * gray[..., None])[MASK], rtol=1e-12
    )
    colored = LogHarmonics(np.stack([LIGHT.coefficients * k for k in (1, 0.5, 2)], axis=-1))
    expected = MODEL.albedo * (colored.shade(MODEL.normals) + detail[..., None])
    assert np.allclose(MODEL.relight(colored, chosen)[MASK], expected[MASK], rtol=1e-12)


@given(st.floats(1e-3, 1e3), weights, weights)
@settings(max_examples=20)
def test_relighting_is_homogeneous_in_the_albedo(scale: float, one: float, other: float) -> None:
    """An object painted twice as bright is relit twice as bright."""
    brighter = dataclasses.replace(MODEL, albedo=scale * MODEL.albedo)
    before = MODEL.relight(LIGHT, Weights(one, other))
    after = brighter.relight(LIGHT, Weights(one, other))
    assert np.allclose(after[MASK], scale * before[MASK], rtol=1e-12)


def test_without_detail_a_stronger_light_relights_in_proportion() -> None:
    """With weights zero the picture is linear in a linear light; with detail it is not."""
    light = LinearHarmonics(np.array([0.5, 0.1, 0.3, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0]))
    double = LinearHarmonics(2 * light.coefficients)
    none = Weights(0, 0)
    assert np.allclose(
        MODEL.relight(double, none)[MASK], 2 * MODEL.relight(light, none)[MASK], rtol=1e-12
    )
    assert not np.allclose(MODEL.relight(double)[MASK], 2 * MODEL.relight(light)[MASK], rtol=1e-3)


@pytest.mark.parametrize("seed", [0, 1])
def test_its_own_light_and_residual_give_the_photograph_back(seed: int) -> None:
    """A (shade(Z, L(theta)) + S_p) is the photograph, to 1e-12 of it."""
    image, mask = photographed(seed=seed)
    model = build_model(image, mask, PARAMETERS)
    again = model.relight(model.illumination, Weights(1, 0))
    assert np.abs(again[mask] / image[mask] - 1).max() < 1e-12
    assert np.isnan(again[~mask]).all()


def test_the_layers_are_those_of_the_equations() -> None:
    """Built step by step from Retinex, contour, light fit and dictionary, the model is the same."""
    base = contour_base(MASK, PARAMETERS)
    parts = retinex(IMAGE, MASK, PARAMETERS.thresholds)
    fitted = MODEL.illumination.shade(base.normals, base.height)
    detail = geometric_detail(parts.shading, MASK, PARAMETERS.dictionary)
    for found, expected in (
        (MODEL.albedo, parts.albedo),
        (MODEL.height, base.height),
        (MODEL.normals, base.normals),
        (MODEL.parametric_residual, parts.shading - fitted),
        (MODEL.geometric_detail, detail),
    ):
        assert np.array_equal(found, expected, equal_nan=True)


def test_building_twice_gives_the_same_bytes() -> None:
    """The model depends on its input alone."""
    again = build_model(IMAGE, MASK, PARAMETERS)
    for field in ("albedo", "normals", "parametric_residual", "geometric_detail"):
        assert getattr(again, field).tobytes() == getattr(MODEL, field).tobytes()
    assert again.illumination.positions.tobytes() == MODEL.illumination.positions.tobytes()


def test_the_background_plays_no_part() -> None:
    """Whatever lies outside the mask, NaN included, the model is the same."""
    other = build_model(np.where(MASK[..., None], IMAGE, np.nan), MASK, PARAMETERS)
    assert np.array_equal(other.albedo, MODEL.albedo, equal_nan=True)
    assert np.array_equal(other.geometric_detail, MODEL.geometric_detail, equal_nan=True)


def test_weights_are_one_unless_chosen() -> None:
    """The paper's default is w = (1, 1, 1)."""
    assert Weights() == Weights(1.0, 1.0)
    assert np.array_equal(MODEL.shade(LIGHT), MODEL.shade(LIGHT, Weights(1, 1)), equal_nan=True)


def test_a_given_shape_is_used_as_it_is() -> None:
    """Its normals shade the model; nothing is taken from the contour."""
    _, height, normals = dome(20)
    model = build_model(IMAGE, MASK, PARAMETERS, shape=CoarseShape(height, normals))
    assert np.array_equal(model.height, height, equal_nan=True)
    assert np.array_equal(model.normals, normals, equal_nan=True)
    assert np.allclose(model.shade(LIGHT, Weights(0, 0))[MASK], LIGHT.shade(normals)[MASK])


def test_a_given_shading_divides_the_photograph() -> None:
    """With the true shading, of any scale, the albedo is the photograph over it."""
    _, _, normals = dome(20)
    shading = LIGHT.shade(normals)
    for scale in (1.0, 37.0):
        model = build_model(IMAGE, MASK, PARAMETERS, shading=scale * shading)
        expected = IMAGE / (shading * MEAN_SHADING / np.nanmean(shading))[..., None]
        assert np.allclose(model.albedo[MASK], expected[MASK])


def test_a_coloured_shading_divides_each_channel() -> None:
    """The albedo loses the light's colour and the shading kept is the channels' mean."""
    generator = np.random.default_rng(1)
    shading = generator.uniform(0.5, 1, size=(*MASK.shape, 3))
    parts = split_by_shading(IMAGE, MASK, shading)
    gray = shading.mean(axis=-1)
    assert np.allclose(parts.shading[MASK], gray[MASK] * MEAN_SHADING / gray[MASK].mean())
    ratio = (parts.albedo * shading / IMAGE)[MASK]
    assert np.allclose(ratio, ratio[0, 0])
    assert np.isclose(np.nanmean(parts.shading), MEAN_SHADING)


@pytest.mark.parametrize("value", [0.0, -0.2, np.nan])
def test_a_shading_must_be_positive(value: float) -> None:
    """One pixel at zero, below it or unknown is refused, inside the mask only."""
    shading = np.ones(MASK.shape)
    shading[0, 0] = value
    split_by_shading(IMAGE, MASK, shading)
    shading[20, 20] = value
    with pytest.raises(RelightlabError, match="shading above zero all over the mask"):
        build_model(IMAGE, MASK, PARAMETERS, shading=shading)


def test_maps_outside_the_mask_are_nan_in_any_model() -> None:
    """The invariant holds for models put together by hand too."""
    shape = (4, 5)
    mask = np.zeros(shape, bool)
    mask[1:3, 1:4] = True
    model = ObjectModel(
        mask=mask,
        albedo=np.ones((*shape, 3)),
        height=np.ones(shape),
        normals=unit_normals(np.random.default_rng(0), *shape),
        parametric_residual=np.zeros(shape),
        geometric_detail=np.zeros(shape),
        illumination=PointLights(np.array([[0.0, 0.0, 9.0]]), np.ones(1)),
    )
    for name in ("albedo", "height", "normals", "parametric_residual", "geometric_detail"):
        values = getattr(model, name)
        assert np.isnan(values[~mask]).all()
        assert np.isfinite(values[mask]).all()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("albedo", "albedo"),
        ("height", "height"),
        ("normals", "normals"),
        ("parametric_residual", "parametric residual"),
        ("geometric_detail", "geometric detail"),
    ],
)
def test_maps_of_another_size_are_refused(name: str, words: str) -> None:
    """The sentence names the map."""
    with pytest.raises(RelightlabError, match=f"expected {words} of shape"):
        dataclasses.replace(MODEL, **{name: getattr(MODEL, name)[:-1]})


@pytest.mark.parametrize(
    ("image", "mask", "sentence"),
    [
        (IMAGE, np.zeros_like(MASK), "the mask is empty"),
        (IMAGE[1:], MASK, "give a mask of the photograph's size"),
        (IMAGE * 0, MASK, "black all over the mask"),
        (-IMAGE, MASK, "negative pixels inside the mask"),
        (np.concatenate([IMAGE, IMAGE[..., :1]], axis=-1), MASK, "expected an image of shape"),
    ],
)
def test_unusable_pictures_are_refused(image: Image, mask: Mask, sentence: str) -> None:
    """Each kind of bad input gets its one sentence, from the function users call."""
    with pytest.raises(RelightlabError, match=sentence):
        build_model(image, mask, PARAMETERS)


@pytest.mark.parametrize(
    "mask",
    [
        np.pad(np.ones((1, 1), bool), 2),
        np.ones((1, 30), bool),
        np.ones((12, 12), bool),
        np.indices((9, 9)).sum(axis=0) % 2 == 0,
        disk(10)[0] & ~np.pad(disk(3)[0], 7),
    ],
    ids=["one pixel", "a line", "the whole picture", "a checkerboard", "a ring"],
)
def test_odd_masks_make_models(mask: Mask) -> None:
    """A model is finite on its mask and NaN outside, whatever the mask."""
    generator = np.random.default_rng(2)
    image = generator.uniform(0.1, 1, size=(*mask.shape, 3))
    model = build_model(image, mask, PARAMETERS)
    relit = model.relight(LIGHT)
    assert np.isfinite(relit[mask]).all()
    assert np.isnan(relit[~mask]).all()
    again = model.relight(model.illumination, Weights(1, 0))
    assert np.allclose(again[mask], image[mask], rtol=1e-9)


def test_a_gray_and_a_saturated_photograph_make_models() -> None:
    """A gray image has a gray albedo; one that is white all over has no detail to speak of."""
    gray = build_model(IMAGE.mean(axis=-1), MASK, PARAMETERS)
    assert np.allclose(gray.albedo[MASK][:, 0], gray.albedo[MASK][:, 2])
    white = build_model(np.ones_like(IMAGE), MASK, PARAMETERS)
    assert np.abs(white.geometric_detail[MASK]).max() < 1e-5
    assert np.allclose(white.albedo[MASK], 1 / MEAN_SHADING)


def test_parts_put_together_are_the_given_ones() -> None:
    """`assemble_model` keeps albedo and shape and derives the layers only."""
    base = contour_base(MASK, PARAMETERS)
    parts = split_by_shading(IMAGE, MASK, np.ones(MASK.shape))
    model = assemble_model(MASK, base, parts, PARAMETERS)
    assert np.array_equal(model.albedo, parts.albedo, equal_nan=True)
    assert np.isclose(
        np.nanmean(model.parametric_residual + model.illumination.shade(base.normals, base.height)),
        MEAN_SHADING,
    )
