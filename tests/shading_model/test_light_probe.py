"""Lights fitted to photographed spheres."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shading_model.arrays import Image
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics
from shading_model.light_probe import light_of_probe


def sphere(light: LogHarmonics, side: int) -> Image:
    """Return the picture of a white sphere that touches all four sides, on black."""
    rows, columns = (np.mgrid[:side, :side] - (side - 1) / 2) / (side / 2)
    inside = rows**2 + columns**2 < 1
    upright = np.sqrt(np.where(inside, 1 - rows**2 - columns**2, 0))
    picture = light.shade(np.stack([columns, -rows, upright], axis=-1))
    return np.where(inside[..., None], picture, 0.0)


@settings(max_examples=15)
@given(st.integers(0, 10**6), st.sampled_from([48, 101, 256]))
def test_the_light_of_a_sphere_is_found(seed: int, side: int) -> None:
    """A sphere rendered under a coloured log-linear light gives that light's shading back."""
    coefficients = np.random.default_rng(seed).normal(scale=0.25, size=(9, 3))
    coefficients[0] -= 2
    light = LogHarmonics(coefficients)
    found = light_of_probe(sphere(light, side))
    angles = np.linspace(0, 2 * np.pi, 40)
    radius = np.repeat([0.0, 0.4, 0.8], 40)
    normals = np.column_stack(
        [radius * np.tile(np.cos(angles), 3), radius * np.tile(np.sin(angles), 3),
         np.sqrt(1 - radius**2)]
    )[None]  # fmt: skip
    assert np.allclose(found.shade(normals), light.shade(normals), rtol=0.02)


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (np.ones((40, 60, 3)) / 2, "square"),
        (np.ones((4, 4, 3)) / 2, "at least 8"),
        (np.ones((40, 40)) / 2, "of shape (h, w, 3)"),
        (np.ones((40, 40, 3)), "saturated"),
        (np.zeros((40, 40, 3)), "dark"),
        (np.full((40, 40, 3), np.nan), "NaN"),
        (np.full((40, 40, 3), -1.0), "negative"),
    ],
)
def test_probes_that_cannot_be_used(image: Image, words: str) -> None:
    """Each gets one sentence."""
    with pytest.raises(RelightlabError, match=words.replace("(", r"\(").replace(")", r"\)")):
        light_of_probe(image)
