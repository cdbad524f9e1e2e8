"""Limited-memory BFGS that starts from a metric, with strong Wolfe line searches."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from evaluation.sirfs.line_search import Trial, wolfe_step
from shading_model.arrays import Float

MEMORY = 10
RECENT = 5
RELATIVE_CHANGE = 5e-5
"""A run ends when the last `RECENT` values are within this of the newest."""
LARGEST_GRADIENT = 1e-5
SMALLEST_STEP = 1e-9

Function = Callable[[Float], tuple[float, Float]]
"""Takes a point, returns value and gradient."""
Metric = Callable[[Float], Float]
"""Takes a gradient, returns the step of steepest descent in the metric, without its sign."""
Watch = Callable[[int, float, Float], None]
"""Called after each step with evaluations so far, value and point."""


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a run ended.

    Parameters
    ----------
    point : (n,) array
    value : float
    evaluations, steps : int
    stopped : str
        Why, in words.
    """

    point: Float
    value: float
    evaluations: int
    steps: int
    stopped: str


def minimise(
    function: Function,
    start: Float,
    metric: Metric,
    *,
    most_evaluations: int,
    memory: int = MEMORY,
    relative_change: float = RELATIVE_CHANGE,
    watch: Watch | None = None,
) -> Minimum:
    """Minimise a function of many variables.

    Parameters
    ----------
    function : callable
    start : (n,) array
    metric : callable
        Linear, symmetric and positive; scaled anew in every step.
    most_evaluations : int
    memory : int
        Pairs of steps and changes of gradient that are kept.
    relative_change : float
        See `RELATIVE_CHANGE`.
    watch : callable, optional

    Returns
    -------
    Minimum
        A value that is not finite at the start is returned as it is.

    Examples
    --------
    >>> scale = np.array([1.0, 10.0])
    >>> found = minimise(lambda x: (float(scale @ x**2), 2 * scale * x), np.ones(2), lambda g: g,
    ...                  most_evaluations=50)
    >>> bool(np.abs(found.point).max() < 1e-3)
    True
    """
    run = _Run(function, np.array(start, dtype=np.float64), metric, memory)
    if not math.isfinite(run.value):
        return run.ended(f"the loss at the start is {run.value}")
    recent: deque[float] = deque([run.value], maxlen=RECENT + 1)
    while run.evaluations < most_evaluations:
        if np.abs(run.gradient).max() <= LARGEST_GRADIENT:
            return run.ended("the gradient is zero")
        if not run.step(most_evaluations):
            return run.ended("no step lowers the loss any more")
        if watch:
            watch(run.evaluations, run.value, run.point)
        recent.append(run.value)
        if len(recent) > RECENT and (max(recent) - run.value <= relative_change * abs(run.value)):
            return run.ended("the loss hardly changes any more")
    return run.ended(f"{most_evaluations} evaluations were made")


class _Run:
    """The state of a run: a point, its gradient, and what earlier steps tell of the curvature."""

    def __init__(self, function: Function, start: Float, metric: Metric, memory: int) -> None:
        self._function, self._metric = function, metric
        self._pairs: deque[tuple[Float, Float, float]] = deque(maxlen=memory)
        self._scale = 0.0
        self.point = start
        self.value, self.gradient = function(start)
        self.evaluations, self.steps = 1, 0
        self._latest = (0.0, self.value, self.gradient)

    def ended(self, why: str) -> Minimum:
        return Minimum(self.point, self.value, self.evaluations, self.steps, why)

    def step(self, most_evaluations: int) -> bool:
        """Take a step; return whether there was one."""
        direction = self._direction()
        slope = float(self.gradient @ direction)
        if not slope < 0:
            self._pairs.clear()
            direction = -self._metric(self.gradient)
            slope = float(self.gradient @ direction)
        first = 1.0 if self._pairs else min(1.0, 1.0 / math.sqrt(-slope))
        trials = min(25, most_evaluations - self.evaluations)
        start = Trial(0.0, self.value, slope)
        found = wolfe_step(lambda t: self._tried(t, direction), start, first, trials)
        if found is None or found.step * np.abs(direction).max() < SMALLEST_STEP:
            if not self._pairs:
                return False
            self._pairs.clear()
            return self.evaluations < most_evaluations and self.step(most_evaluations)
        self._move(found, direction)
        return True

    def _tried(self, length: float, direction: Float) -> Trial:
        value, gradient = self._function(self.point + length * direction)
        self.evaluations += 1
        self._latest = (length, value, gradient)
        return Trial(length, value, float(gradient @ direction))

    def _move(self, found: Trial, direction: Float) -> None:
        if self._latest[0] != found.step:
            self._tried(found.step, direction)
        change = self._latest[2] - self.gradient
        moved = found.step * direction
        curvature = float(moved @ change)
        if curvature > 1e-10 * math.sqrt(float(moved @ moved) * float(change @ change)):
            self._pairs.append((moved, change, 1.0 / curvature))
            self._scale = curvature / float(change @ self._metric(change))
        self.point = self.point + moved
        self.value, self.gradient = found.value, self._latest[2]
        self.steps += 1

    def _direction(self) -> Float:
        """Return minus the two-loop product of inverse Hessian and gradient."""
        if not self._pairs:
            return -self._metric(self.gradient)
        left = self.gradient.copy()
        shares = []
        for moved, change, inverse in reversed(self._pairs):
            shares.append(inverse * float(moved @ left))
            left -= shares[-1] * change
        result = self._metric(left)
        result *= self._scale
        for (moved, change, inverse), share in zip(self._pairs, reversed(shares), strict=True):
            result += (share - inverse * float(change @ result)) * moved
        result *= -1.0
        return result
