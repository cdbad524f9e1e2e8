"""One distant light fitted to the shading of a sphere."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shading_model.distant_light import fit_distant_light, relative_difference
from shading_model.harmonic_conversion import visible_normals
from tests.shading_model.probe_pictures import degrees_between


@given(st.floats(-1.3, 1.3), st.floats(-3.1, 3.1), st.floats(0.01, 50))
def test_a_distant_light_is_found(tilt: float, turn: float, intensity: float) -> None:
    """Shading by max(0, N . d) gives direction and intensity back, with attached shadow or not."""
    toward = np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
    normals = visible_normals()
    light = fit_distant_light(normals, intensity * np.maximum(0.0, normals @ toward))
    assert light is not None
    assert degrees_between(light.direction, toward) < 1e-5
    assert light.intensity == pytest.approx(intensity, rel=1e-9)
    assert light.residual < 1e-9


def test_the_residual_tells_another_kind_of_light() -> None:
    """A sphere as bright everywhere is far from any distant light, which then is in front."""
    light = fit_distant_light(visible_normals(), np.ones(2000))
    assert light is not None
    assert degrees_between(light.direction, np.array([0.0, 0.0, 1.0])) < 0.2
    assert 0.2 < light.residual < 0.4


def test_no_light_has_no_direction() -> None:
    """Two normals against each other, as bright as each other, cancel."""
    assert fit_distant_light(np.array([[1.0, 0, 0], [-1.0, 0, 0]]), np.ones(2)) is None


def test_the_difference_is_relative_to_the_picture() -> None:
    """Scaling both changes nothing."""
    found, picture = np.array([1.0, 2.0, 4.0]), np.array([1.0, 2.0, 3.0])
    assert relative_difference(found, picture) == pytest.approx(1 / np.sqrt(14))
    assert relative_difference(5 * found, 5 * picture) == pytest.approx(1 / np.sqrt(14))
