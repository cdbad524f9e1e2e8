"""The bending of a function of three variables."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import check_grad

from evaluation.sirfs.bending import bending
from shading_model.arrays import Float


def test_gradient_against_finite_differences() -> None:
    """For a random function, at the faces, edges and corners, too."""
    generator = np.random.default_rng(0)
    shape = (4, 4, 4)

    def value(flat: Float) -> float:
        return bending(flat.reshape(shape), 1e-2, np.empty(shape))

    def gradient(flat: Float) -> Float:
        found = np.empty(shape)
        bending(flat.reshape(shape), 1e-2, found)
        return found.ravel()

    assert check_grad(value, gradient, generator.normal(size=64)) < 1e-4


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_bowl_along_one_axis(axis: int) -> None:
    """x^2 has the second difference two at every knot but the two faces."""
    axes = np.moveaxis(np.broadcast_to(np.arange(5.0) ** 2, (5, 5, 5)), -1, axis)
    assert np.isclose(bending(axes.copy(), 1e-20, np.empty((5, 5, 5))), 2 * 25 * 3)


def test_twist_counts_twice() -> None:
    """The mixed difference of x y is one, and the thin plate counts it as xy and as yx."""
    x, y, _ = np.mgrid[0.0:4.0, 0.0:4.0, 0.0:4.0]
    assert np.isclose(bending(x * y, 1e-20, np.empty((4, 4, 4))), np.sqrt(2) * 9 * 4)


def test_axes_are_alike() -> None:
    """Turned, a function bends as much."""
    values = np.random.default_rng(1).normal(size=(5, 5, 5))
    scratch = np.empty((5, 5, 5))
    one = bending(values, 1e-3, scratch)
    assert np.isclose(bending(np.ascontiguousarray(values.transpose(2, 0, 1)), 1e-3, scratch), one)
