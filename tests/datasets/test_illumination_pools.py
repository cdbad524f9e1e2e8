"""Pools of natural lights and the draws from them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from datasets.environment_maps import shipped_lights
from datasets.illumination_pools import (
    MEASURED_FILE,
    from_mit_axes,
    natural_lights,
    table1_lights,
)
from shading_model.errors import RelightlabError
from shading_model.harmonic_conversion import visible_normals
from shading_model.seeds import generator_for


@pytest.fixture
def measured_root(data_root: Path) -> Path:
    """The data root, where it holds the measured pool."""
    if not (data_root / MEASURED_FILE).is_file():
        pytest.skip(f"{data_root} holds no {MEASURED_FILE}")
    return data_root


def write_pool(root: Path, stored: object) -> Path:
    """A file of the measured pool's layout."""
    path = root / MEASURED_FILE
    path.parent.mkdir()
    savemat(path, {"Ldata": {"natural_test_color": stored}})
    return path


def test_a_pool_file_is_read_and_its_axes_converted(tmp_path: Path) -> None:
    """Each light of a file of the measured layout is the conversion of one slice."""
    stored = np.random.default_rng(0).normal(size=(9, 3, 5))
    write_pool(tmp_path, stored)
    lights = natural_lights(tmp_path)
    assert len(lights) == 5
    np.testing.assert_array_equal(
        lights[3].coefficients, from_mit_axes(stored[:, :, 3]).coefficients
    )


def test_without_data_the_shipped_pool_is_used(tmp_path: Path) -> None:
    """No root, or a root without the file, gives the lights of the shipped table."""
    for root in (None, tmp_path):
        for ours, theirs in zip(natural_lights(root), shipped_lights(), strict=True):
            np.testing.assert_array_equal(ours.coefficients, theirs.coefficients)


@pytest.mark.parametrize(
    ("stored", "sentence"),
    [
        (np.zeros((9, 5)), r"expected natural_test_color of shape \(9, 3, n\)"),
        (np.full((9, 3, 2), np.nan), "NaN or infinite"),
    ],
)
def test_a_pool_of_other_content_is_refused(tmp_path: Path, stored: object, sentence: str) -> None:
    """Wrong shapes and NaN get the sentence."""
    write_pool(tmp_path, stored)
    with pytest.raises(RelightlabError, match=sentence):
        natural_lights(tmp_path)


def test_a_damaged_pool_is_refused(tmp_path: Path) -> None:
    """A truncated file, a text and another variable are each told apart from an absent file."""
    path = write_pool(tmp_path, np.random.default_rng(0).normal(size=(9, 3, 50)))
    whole = path.read_bytes()
    for content in (whole[: len(whole) // 2], b"text", b""):
        path.write_bytes(content)
        with pytest.raises(RelightlabError, match=r"Ldata\.mat"):
            natural_lights(tmp_path)
    savemat(path, {"other": 1})
    with pytest.raises(RelightlabError, match=r"does not hold Ldata\.natural_test_color"):
        natural_lights(tmp_path)


def test_table1_draws_are_distinct_and_nested() -> None:
    """Twenty different monochrome lights, the same every time, of which five are the first five."""
    twenty = table1_lights(None)
    assert len({light.coefficients.tobytes() for light in twenty}) == len(twenty) == 20
    for short, long in zip(table1_lights(None, count=5), twenty, strict=False):
        assert long.coefficients.shape == (9,)
        np.testing.assert_array_equal(short.coefficients, long.coefficients)


def test_another_name_is_another_draw() -> None:
    """The name of the draw, and nothing else, decides it."""
    first, second = table1_lights(None), table1_lights(None, seed="another")
    assert any(
        not np.array_equal(a.coefficients, b.coefficients)
        for a, b in zip(first, second, strict=True)
    )


@pytest.mark.parametrize("count", [0, -1, 91])
def test_a_draw_must_fit_the_pool(count: int) -> None:
    """Neither none nor more than there are can be drawn."""
    with pytest.raises(RelightlabError, match=f"between 1 and 90 lights, got {count}"):
        table1_lights(None, count=count)


def test_generators_depend_on_each_name() -> None:
    """Splitting the names elsewhere gives another stream; the stream of a name is pinned."""
    first = generator_for("ab", "c").integers(0, 2**32)
    assert first != generator_for("a", "bc").integers(0, 2**32)
    assert first == generator_for("ab", "c").integers(0, 2**32)


@pytest.mark.real_data
def test_the_measured_pool_is_lit_from_above_with_a_blue_sky(measured_root: Path) -> None:
    """Its 776 lights peak near 1, come from above rather than below, most of all in blue."""
    lights = natural_lights(measured_root)
    assert len(lights) == 776
    peaks = [light.shade(visible_normals()).max() for light in lights]
    assert 0.97 < np.median(peaks) < 1.01
    red, _, blue = np.mean([light.coefficients[1] for light in lights], axis=0)
    assert blue > red > 0


@pytest.mark.real_data
def test_the_measured_draw_is_twenty_of_the_pool(measured_root: Path) -> None:
    """Every Table 1 light is one of the pool's, averaged over its channels."""
    pool = np.array([light.monochrome().coefficients for light in natural_lights(measured_root)])
    for light in table1_lights(measured_root):
        assert (pool == light.coefficients).all(axis=1).any()
