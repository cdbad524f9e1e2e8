"""Retinex: albedo and shading of one photograph."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shading_model.arrays import Image, Map, Mask
from shading_model.errors import RelightlabError
from shading_model.retinex import (
    DARKEST,
    MEAN_SHADING,
    Retinex,
    RetinexThresholds,
    retinex,
)
from tests.shading_model.outlines import disk

COLOURS = np.array([[0.7, 0.2, 0.1], [0.15, 0.5, 0.2], [0.2, 0.25, 0.8], [0.6, 0.6, 0.1]])
SHARP = RetinexThresholds(gray=1.0, chromaticity=0.1)


def painted(radius: int = 40) -> tuple[Image, Map, Image, Mask]:
    """A photograph, smooth shading, albedo in four coloured quarters, and a disk mask."""
    mask, x, y = disk(radius)
    albedo = COLOURS[(x > 0.1).astype(int) + 2 * (y > -0.2)]
    shading = 0.3 + 0.5 * np.exp(-((x - 0.3) ** 2) - y**2)
    return albedo * shading[..., None], shading, albedo, mask


def ratio_spread(values: Map, reference: Map, mask: Mask) -> float:
    """How far two maps are from being multiples of each other: deviation of the log ratio."""
    return float(np.std(np.log(values[mask] / reference[mask])))


def test_flat_colours_under_smooth_light_are_told_apart() -> None:
    """Shading and albedo come back up to one scale, within three percent; paint alone is exact."""
    image, shading, albedo, mask = painted()
    parts = retinex(image, mask, SHARP)
    # What is left is the shading's own change across the painted edges: Retinex calls it albedo.
    assert ratio_spread(parts.shading, shading, mask) < 0.03
    assert ratio_spread(parts.albedo[..., 0], albedo[..., 0], mask) < 0.03
    flat = retinex(albedo, mask, SHARP)
    assert ratio_spread(flat.shading, np.ones_like(shading), mask) < 1e-4


def test_the_local_error_of_the_separation_is_small() -> None:
    """In windows of ten pixels the shading is right up to scale to three parts in ten thousand."""
    image, shading, _, mask = painted()
    found = retinex(image, mask, SHARP).shading
    error = power = 0.0
    for row in range(0, mask.shape[0], 10):
        for column in range(0, mask.shape[1], 10):
            part = (slice(row, row + 10), slice(column, column + 10))
            inside = mask[part]
            truth, ours = shading[part][inside], found[part][inside]
            if truth.size:
                error += np.sum((truth - ours * (truth @ ours) / (ours @ ours)) ** 2)
                power += truth @ truth
    assert error / power < 3e-4


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 2), st.floats(0.005, 1))
def test_albedo_times_shading_is_the_photograph(
    seed: int, gray: float, chromaticity: float
) -> None:
    """Whatever the thresholds, and whatever the picture, zeros included."""
    generator = np.random.default_rng(seed)
    mask = generator.random((14, 17)) > 0.3
    image = generator.random((14, 17, 3)) * (generator.random((14, 17, 1)) > 0.1)
    parts = retinex(image, mask, RetinexThresholds(gray, chromaticity))
    product = parts.albedo * parts.shading[..., None]
    assert np.allclose(product[mask], image[mask], rtol=1e-12, atol=0)
    assert np.isnan(parts.albedo[~mask]).all()
    assert np.isnan(parts.shading[~mask]).all()
    assert (parts.shading[mask] > 0).all()
    assert np.isclose(parts.shading[mask].mean(), MEAN_SHADING)


@given(st.floats(1e-3, 1e3))
def test_a_brighter_photograph_has_a_brighter_albedo(scale: float) -> None:
    """Scaling the photograph scales the albedo and leaves the shading."""
    image, _, _, mask = painted(12)
    one, other = retinex(image, mask, SHARP), retinex(scale * image, mask, SHARP)
    assert np.allclose(other.shading[mask], one.shading[mask], rtol=1e-6)
    assert np.allclose(other.albedo[mask], scale * one.albedo[mask], rtol=1e-6)


def test_components_do_not_see_each_other() -> None:
    """Repainting one component leaves the other's albedo as it was, up to the common scale."""
    image, _, _, mask = painted(15)
    both = np.concatenate([mask, mask], axis=1)
    calm = np.concatenate([image, image], axis=1)
    bright = calm.copy()
    bright[:, mask.shape[1] :] *= np.random.default_rng(0).uniform(0.2, 1, size=image.shape)
    first, second = (retinex(picture, both, SHARP) for picture in (calm, bright))
    ratio = (first.shading / second.shading)[:, : mask.shape[1]][mask]
    assert np.allclose(ratio, ratio[0], rtol=1e-3)


def test_each_component_has_the_same_mean_log_albedo() -> None:
    """A component ten times as bright is taken to be better lit, not to be painted brighter."""
    image, _, _, mask = painted(15)
    both = np.concatenate([mask, mask], axis=1)
    parts = retinex(np.concatenate([image, 0.1 * image], axis=1), both, SHARP)
    left, right = np.split(parts.shading, 2, axis=1)
    assert np.allclose(left[mask], 10 * right[mask], rtol=1e-3)


def test_an_infinite_chromaticity_threshold_is_gray_retinex() -> None:
    """Colour steps of equal brightness are then shading, and brightness steps still albedo."""
    image = np.full((10, 20, 3), 0.3)
    image[:, 10:] = (0.6, 0.3, 0.15)  # the same geometric mean
    image[5:] *= 4
    gray = retinex(image, np.ones((10, 20), bool), RetinexThresholds(1.0, np.inf))
    assert np.allclose(gray.shading, MEAN_SHADING, rtol=1e-4)
    blind = retinex(image, np.ones((10, 20), bool), RetinexThresholds(np.inf, np.inf))
    assert np.allclose(blind.shading[0, 0] * 4, blind.shading[9, 0])


def test_higher_thresholds_leave_fewer_changes_to_the_albedo() -> None:
    """The mean squared change of the log albedo never rises with either threshold."""
    image, _, _, mask = painted(20)
    noise = np.random.default_rng(4).lognormal(sigma=0.2, size=image.shape)
    separator = Retinex(image * noise, mask)

    def albedo_change(gray: float, chromaticity: float) -> float:
        albedo = separator.separate(RetinexThresholds(gray, chromaticity)).albedo
        logs = np.log(albedo).mean(axis=-1)
        return sum(float(np.nansum(np.diff(logs, axis=axis) ** 2)) for axis in (0, 1))

    levels = (0.02, 0.1, 0.3, 0.8, 5.0)
    by_gray = [albedo_change(level, np.inf) for level in levels]
    by_chromaticity = [albedo_change(np.inf, level) for level in levels]
    for series in (by_gray, by_chromaticity):
        assert series == sorted(series, reverse=True)
        assert series[0] > series[-1]
    assert by_gray[-1] < 1e-9


def test_black_pixels_are_raised_to_the_darkest() -> None:
    """A black dot gives a finite shading and a black albedo, and its own ratio to the brightest."""
    image = np.full((9, 9, 3), 0.5)
    image[4, 4] = 0
    parts = retinex(image, np.ones((9, 9), bool), RetinexThresholds(np.inf, np.inf))
    assert np.isclose(parts.shading[4, 4] / parts.shading[0, 0], DARKEST)
    assert (parts.albedo[4, 4] == 0).all()


def test_one_separator_serves_any_thresholds() -> None:
    """Asking for other thresholds first changes nothing, to the last bit."""
    image, _, _, mask = painted(15)
    separator = Retinex(image, mask)
    separator.separate(RetinexThresholds(0.01, 0.01))
    again = separator.separate(SHARP)
    assert again.shading.tobytes() == retinex(image, mask, SHARP).shading.tobytes()


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda image, mask: (image, ~mask & False), "the mask is empty"),
        (lambda image, mask: (image[:-1], mask), "give a mask of the photograph's size"),
        (lambda image, mask: (image * 0, mask), "black all over the mask"),
        (lambda image, mask: (image - 0.5, mask), "negative pixels inside the mask"),
        (lambda image, mask: (image * np.nan, mask), "NaN or infinite pixels inside the mask"),
        (lambda image, mask: (image[..., :2], mask), "expected an image of shape"),
    ],
)
def test_unusable_pictures_are_refused(
    change: Callable[..., tuple[Image, Mask]], sentence: str
) -> None:
    """Each kind of bad input gets its one sentence."""
    image, _, _, mask = painted(8)
    with pytest.raises(RelightlabError, match=sentence):
        retinex(*change(image, mask))
