"""Noise, cells and grooves."""

from __future__ import annotations

import numpy as np
import pytest

from datasets.synthetic_albedo import PALETTES, painted_albedo
from datasets.synthetic_patterns import cells, grooves, smooth_noise, smooth_step, turned
from datasets.synthetic_shapes import SHAPES, picture_coordinates
from shading_model.errors import RelightlabError

X, Y = picture_coordinates(120)


def test_noise_has_unit_variance_and_its_wavelength() -> None:
    """Over many draws the variance is one, and a higher frequency varies faster."""
    draws = [smooth_noise(X, Y, 4.0, np.random.default_rng(s)) for s in range(20)]
    assert np.var(draws) == pytest.approx(1.0, abs=0.15)
    fast = smooth_noise(X, Y, 12.0, np.random.default_rng(0))
    assert np.abs(np.diff(fast)).mean() > 2 * np.abs(np.diff(draws[0])).mean()


def test_cells_are_constant_away_from_their_borders() -> None:
    """Two neighbouring pixels far from a border are in one cell."""
    index, border = cells(X, Y, 12, np.random.default_rng(3))
    clear = (border[:, 1:] > 0.03) & (border[:, :-1] > 0.03)
    assert (np.diff(index)[clear] == 0).all()
    assert border.min() >= 0


def test_grooves_are_valleys_at_whole_numbers() -> None:
    """Depth one at whole numbers, between minus one and zero everywhere."""
    phase = np.linspace(-2, 2, 401)
    depth = grooves(phase)
    assert depth.min() == pytest.approx(-1.0)
    assert depth.max() < 0
    np.testing.assert_allclose(depth[::100], -1.0)


def test_smooth_step_rises_once() -> None:
    """Never falling, from zero to one."""
    rise = smooth_step(np.linspace(-1, 2, 50), 1.0)
    assert (np.diff(rise) >= 0).all()
    assert rise[0] == 0
    assert rise[-1] == 1


def test_turned_coordinates_keep_lengths() -> None:
    """A turn moves no point nearer or farther."""
    np.testing.assert_allclose(np.hypot(*turned(X, Y, 33.0)), np.hypot(X, Y))


def test_every_object_has_its_paints() -> None:
    """The palettes and the shapes name the same objects."""
    assert list(PALETTES) == list(SHAPES)


@pytest.mark.parametrize("name", PALETTES)
def test_albedo_is_chromatic_and_nearly_piecewise_constant(name: str) -> None:
    """Within range; most pixels keep a paint's chromaticity; at least two paints are seen."""
    albedo = painted_albedo(name, 64, np.random.default_rng(0))
    assert albedo.min() >= 0.03
    assert albedo.max() <= 0.9
    seen = albedo / albedo.sum(axis=-1, keepdims=True)
    paints = np.array(PALETTES[name])
    paints = paints / paints.sum(axis=-1, keepdims=True)
    error = np.abs(seen[..., None, :] - paints).max(axis=-1)
    assert (error.min(axis=-1) < 0.02).mean() > 0.9
    assert len(np.unique(error.argmin(axis=-1))) >= 2


def test_an_unknown_object_has_no_paint() -> None:
    """The error names the nearest object."""
    with pytest.raises(RelightlabError, match="Did you mean 'apple'"):
        painted_albedo("aple", 16, np.random.default_rng(0))
