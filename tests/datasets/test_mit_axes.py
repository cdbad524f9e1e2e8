"""Axes of the MIT-Berkeley files."""

from __future__ import annotations

import numpy as np
import pytest

from datasets.mit_axes import harmonics_from_mit_axes, normals_from_mit_axes
from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics


def mit_harmonics(normals: Float) -> Float:
    """The basis in the files' own axes, written out from the format's description."""
    c1, c2, c3, c4, c5 = 0.429043, 0.511664, 0.743125, 0.886227, 0.247708
    n1, n2, n3 = normals.T
    return np.stack(
        [
            np.full_like(n1, c4),
            2 * c2 * n2,
            2 * c2 * n3,
            2 * c2 * n1,
            2 * c1 * n1 * n2,
            2 * c1 * n2 * n3,
            c3 * n3**2 - c5,
            2 * c1 * n1 * n3,
            c1 * (n1**2 - n2**2),
        ],
        axis=-1,
    )


@pytest.mark.parametrize("channels", [(), (3,)])
def test_the_shading_is_the_same_in_both_axes(channels: tuple[int, ...]) -> None:
    """A random light shades random normals alike before and after the conversion."""
    generator = np.random.default_rng(7)
    normals = generator.normal(size=(200, 3))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    coefficients = generator.normal(size=(9, *channels))
    ours = LogHarmonics(harmonics_from_mit_axes(coefficients))
    shading = ours.shade(normals_from_mit_axes(normals))
    np.testing.assert_allclose(
        np.log(shading), mit_harmonics(normals) @ coefficients, rtol=0, atol=1e-12
    )


def test_a_normal_facing_up_in_the_picture_has_positive_y() -> None:
    """Their row axis runs down, so a surface facing the top has N1 = -1 and becomes y = +1."""
    np.testing.assert_array_equal(normals_from_mit_axes(np.array([-1.0, 0.0, 0.0])), [0, 1, 0])


def test_nan_normals_stay_nan() -> None:
    """Outside the object there is no normal in either axes."""
    assert np.isnan(normals_from_mit_axes(np.full((2, 3), np.nan))).all()


@pytest.mark.parametrize("shape", [(), (8,), (3, 9)])
def test_wrong_coefficients_are_refused(shape: tuple[int, ...]) -> None:
    """Coefficients must come first and be nine."""
    with pytest.raises(RelightlabError, match=r"expected spherical-harmonic coefficients"):
        harmonics_from_mit_axes(np.zeros(shape))


@pytest.mark.parametrize("shape", [(), (2,), (3, 9)])
def test_wrong_normals_are_refused(shape: tuple[int, ...]) -> None:
    """Normals must have three components last."""
    with pytest.raises(RelightlabError, match=r"expected normals of shape"):
        normals_from_mit_axes(np.zeros(shape))
