"""The minimiser: known minima, its metric, its line search, and how it ends."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import rosen, rosen_der

from evaluation.sirfs.line_search import CURVATURE, DECREASE, Trial, wolfe_step
from evaluation.sirfs.quasi_newton import minimise
from shading_model.arrays import Float


def plain(gradient: Float, step: Float) -> None:
    """The Euclidean metric."""
    step[:] = gradient


def rosenbrock(point: Float, gradient: Float) -> float:
    """Rosenbrock's valley in many variables."""
    gradient[:] = rosen_der(point)
    return float(rosen(point))


def test_rosenbrock_valley() -> None:
    """The minimum of Rosenbrock's function in fifty variables is found."""
    found = minimise(rosenbrock, np.zeros(50), plain, most_evaluations=1000, relative_change=0.0)
    np.testing.assert_allclose(found.point, 1.0, atol=1e-4)
    assert found.stopped == "the gradient is zero"


def test_a_metric_is_a_change_of_variables() -> None:
    """Steps in the metric T T' are steps in z with x = T z, evaluation by evaluation."""
    generator = np.random.default_rng(2)
    spread = generator.normal(size=(6, 9)) + np.eye(6, 9)

    def in_z(point: Float, gradient: Float) -> float:
        inner = np.empty(6)
        value = rosenbrock(spread @ point, inner)
        gradient[:] = spread.T @ inner
        return value

    def metric(gradient: Float, step: Float) -> None:
        step[:] = spread @ (spread.T @ gradient)

    in_x = minimise(rosenbrock, np.zeros(6), metric, most_evaluations=25, relative_change=0.0)
    other = minimise(in_z, np.zeros(9), plain, most_evaluations=25, relative_change=0.0)
    np.testing.assert_allclose(in_x.point, spread @ other.point, rtol=1e-6, atol=1e-8)


def test_it_ends_after_its_evaluations() -> None:
    """No more evaluations are made than allowed, and the best point is kept."""
    count = 0

    def counted(point: Float, gradient: Float) -> float:
        nonlocal count
        count += 1
        return rosenbrock(point, gradient)

    found = minimise(counted, np.zeros(20), plain, most_evaluations=17, relative_change=0.0)
    assert found.evaluations == count <= 17
    assert found.value == pytest.approx(rosen(found.point))


def test_it_ends_when_nothing_is_gained() -> None:
    """A run that gains next to nothing in twenty steps ends."""
    found = minimise(rosenbrock, np.zeros(80), plain, most_evaluations=5000, relative_change=0.9)
    assert found.stopped == "the loss hardly changes any more"


def test_a_start_that_is_not_finite_is_returned() -> None:
    """A loss that is not finite at the start is told, not minimised."""

    def nowhere(_: Float, gradient: Float) -> float:
        gradient[:] = 0.0
        return float("nan")

    assert "nan" in minimise(nowhere, np.zeros(2), plain, most_evaluations=9).stopped


def test_zero_gradient_ends_at_once() -> None:
    """At a minimum no step is taken."""
    assert minimise(rosenbrock, np.ones(4), plain, most_evaluations=9).steps == 0


@given(st.floats(0.05, 20.0), st.floats(0.01, 30.0), st.floats(-0.9, 0.9), st.floats(0.0, 3.0))
def test_steps_satisfy_the_strong_wolfe_conditions(
    far: float, first: float, tilt: float, wave: float
) -> None:
    """On wavy valleys the step found decreases enough and leaves little of the slope."""

    def line(step: float) -> Trial:
        away = step - far
        value = away**2 + tilt * away**2 / (1 + away**2) + 0.1 * wave * np.sin(3 * step)
        slope = 2 * away + tilt * 2 * away / (1 + away**2) ** 2 + 0.3 * wave * np.cos(3 * step)
        return Trial(step, float(value), float(slope))

    start = line(0.0)
    if start.slope >= -1e-3:
        return
    found = wolfe_step(line, start, first)
    assert found is not None
    assert found.value <= start.value + DECREASE * found.step * start.slope
    assert abs(found.slope) <= -CURVATURE * start.slope


def test_steps_avoid_values_that_are_not_finite() -> None:
    """A line on which the function ends has a step before its end."""

    def line(step: float) -> Trial:
        inside = step < 0.5
        return Trial(step, -step if inside else float("inf"), -1.0 if inside else 0.0)

    found = wolfe_step(line, Trial(0.0, 0.0, -1.0), 4.0)
    assert found is not None
    assert 0 < found.step < 0.5
