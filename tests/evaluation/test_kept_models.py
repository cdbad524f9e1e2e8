"""Tests of kept object models: what their keys depend on."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from datasets.model_parameters import shipped_parameters
from datasets.synthetic import Synthetic
from evaluation.kept_models import model_key
from evaluation.model_parts import PAPER_PARTS
from evaluation.object_measurement import true_parts
from shading_model.object_model import ModelParameters


@pytest.mark.parametrize(
    "changes",
    [
        {"slope_limit": 0.123},
        {"sparsity": 1},
    ],
)
def test_another_parameter_is_another_key(tiny_set: Synthetic, changes: dict[str, Any]) -> None:
    """A changed parameter of the model changes the key; the same inputs do not."""
    capture = tiny_set.load("cup", "natural")
    parameters = shipped_parameters()

    def key(chosen: ModelParameters) -> str:
        return model_key(capture.photograph, true_parts(capture), chosen, PAPER_PARTS)

    assert key(parameters) == key(replace(parameters))
    assert key(parameters) != key(replace(parameters, **changes))


def test_another_pixel_is_another_key(tiny_set: Synthetic) -> None:
    """A single changed pixel of the photograph, or of its shading, changes the key."""
    capture = tiny_set.load("cup", "natural")
    photograph, images = capture.photograph, true_parts(capture)
    row, column = (int(place[0]) for place in photograph.mask.nonzero())
    image, shading = photograph.image.copy(), images.shading.copy()
    image[row, column] += 1e-9
    shading[row, column] += 1e-9
    keys = {
        model_key(taken, parts, shipped_parameters(), PAPER_PARTS)
        for taken in (photograph, replace(photograph, image=image))
        for parts in (images, replace(images, shading=shading))
    }
    assert len(keys) == 4
