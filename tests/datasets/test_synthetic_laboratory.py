"""The path-traced laboratory against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from datasets.synthetic_laboratory import (
    LAMP_DIRECTIONS,
    LAMP_DISTANCE,
    PHOTOGRAPHS,
    extended,
    render_laboratory,
)
from shading_model.arrays import Float

STRAY = 0.03


def plate(slope_x: float = 0.0, slope_y: float = 0.0, size: int = 40) -> Float:
    """A small plate in the middle of the picture; slopes are dz/dx and dz/dy (y up)."""
    row, column = np.mgrid[:size, :size] - (size - 1) / 2
    height = slope_x * column - slope_y * row
    height[(np.abs(row) > size / 4) | (np.abs(column) > size / 4)] = np.nan
    return height


def lambert(height: Float, slopes: tuple[float, float], lamps: dict[int, float]) -> Float:
    """Shading of a plate by point lamps where the lamps stand, and by the stray light."""
    rows, columns = height.shape
    reach = max(rows, columns) / 2
    row, column = np.indices(height.shape)
    x, y = (column + 0.5 - columns / 2) / reach, (rows / 2 - row - 0.5) / reach
    points = np.stack([x, y, slopes[0] * x + slopes[1] * y], axis=-1)
    normal = np.array([-slopes[0], -slopes[1], 1.0])
    normal /= np.linalg.norm(normal)
    shading = np.full(height.shape, STRAY)
    for lamp, strength in lamps.items():
        direction = np.array(LAMP_DIRECTIONS[lamp])
        to_lamp = LAMP_DISTANCE * direction / np.linalg.norm(direction) - points
        cosine = np.maximum(to_lamp @ normal, 0.0)
        shading += strength * LAMP_DISTANCE**2 * cosine / np.linalg.norm(to_lamp, axis=-1) ** 3
    return shading


@pytest.mark.parametrize("slopes", [(0.0, 0.0), (-0.4, 0.1), (0.2, -0.3)])
def test_a_plate_has_the_closed_form(slopes: tuple[float, float]) -> None:
    """Small lamps shade a tilted plate as point lamps do, pixel by pixel, to 3 %.

    But for the outermost ring, where the surface is continued level and the true normal is NaN.
    """
    height = plate(*slopes)
    mask = np.isfinite(height)
    inner = ndimage.binary_erosion(mask, np.ones((3, 3)))
    photographs = render_laboratory(height, np.full((40, 40, 3), 0.5), 100, 0)
    for photograph, lamps in zip(photographs, PHOTOGRAPHS, strict=True):
        expected = 0.5 * lambert(height, slopes, lamps)
        np.testing.assert_allclose(photograph[inner].mean(axis=-1), expected[inner], rtol=0.03)
        assert (photograph[~mask] == 0).all()


@pytest.mark.parametrize("transposed", [False, True])
@pytest.mark.parametrize("copies", [1, 2])
def test_pixels_and_paint_line_up(copies: int, transposed: bool) -> None:
    """Photograph over albedo is smooth where every pixel has its own paint, square or oblong."""
    height = np.hstack([plate()] * copies)
    albedo = np.random.default_rng(0).uniform(0.1, 0.9, (*height.shape, 3))
    if transposed:
        height, albedo = height.T, albedo.transpose(1, 0, 2)
    mask = np.isfinite(height)
    shading = (render_laboratory(height, albedo, 16, 0)[1] / albedo)[mask]
    expected = lambert(height, (0.0, 0.0), PHOTOGRAPHS[1])[mask]
    np.testing.assert_allclose(shading, np.repeat(expected[:, None], 3, axis=1), rtol=0.03)


def test_a_wall_casts_a_shadow_away_from_the_lamp() -> None:
    """Beside a wall only stray and bounced light reaches the side the lamp is not on."""
    height = np.zeros((40, 40))
    height[:, 19:21] = 15.0
    photographs = render_laboratory(height, np.full((40, 40, 3), 0.5), 16, 0)
    from_the_left = photographs[1 + 1].mean(axis=-1)
    assert LAMP_DIRECTIONS[1][0] < -0.5
    assert from_the_left[15:25, 22:26].mean() < 0.35 * from_the_left[15:25, 2:6].mean()


def test_interreflection_carries_colour() -> None:
    """A gray floor beside a red wall turns redder than one beside a gray wall."""
    height = np.zeros((40, 40))
    height[:, 20:] = 2.0 * np.arange(20)
    gray = np.full((40, 40, 3), 0.6)
    red = gray.copy()
    red[:, 20:] = (0.8, 0.05, 0.05)
    beside_gray, beside_red = (
        render_laboratory(height, albedo, 16, 0)[2][10:30, 14:19].mean(axis=(0, 1))
        for albedo in (gray, red)
    )
    assert beside_red[0] / beside_red[2] > 1.03 * beside_gray[0] / beside_gray[2]


def test_extension_keeps_the_object() -> None:
    """Values on the object stay; the rest come from the object."""
    values = np.full((5, 5), np.nan)
    values[2, 1:4] = [1.0, 2.0, 3.0]
    filled = extended(values, np.isfinite(values))
    np.testing.assert_array_equal(filled[2, 1:4], [1, 2, 3])
    assert set(np.unique(filled)) == {1.0, 2.0, 3.0}
