"""Limited-memory BFGS that starts from a metric, with strong Wolfe line searches."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from evaluation.sirfs.line_search import MOST_TRIALS, Trial, wolfe_step
from shading_model.arrays import Float

MEMORY = 10
RECENT = 20
RELATIVE_CHANGE = 1e-4
"""A run ends when the value fell by less than this share of itself in the last `RECENT` steps."""
LARGEST_GRADIENT = 1e-5
SMALLEST_STEP = 1e-9

SMALLEST_CURVATURE = 1e-10
"""Steps along which the gradient changes less than this, relatively, teach nothing."""
_FAST = {"reassoc", "contract", "nsz"}

Function = Callable[[Float, Float], float]
"""Takes a point, fills the gradient there, returns the value."""
Metric = Callable[[Float, Float], None]
"""Takes a gradient, fills the step of steepest descent in the metric, without its sign."""
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
    >>> def function(x, gradient):
    ...     gradient[:] = 2 * scale * x
    ...     return float(scale @ x**2)
    >>> def metric(gradient, step):
    ...     step[:] = gradient
    >>> found = minimise(function, np.ones(2), metric, most_evaluations=50)
    >>> bool(np.abs(found.point).max() < 1e-3)
    True
    """
    run = _Run(function, np.array(start, dtype=np.float64), metric, memory)
    if not math.isfinite(run.value):
        return run.ended(f"the loss at the start is {run.value}")
    recent: deque[float] = deque([run.value], maxlen=RECENT + 1)
    while run.evaluations < most_evaluations:
        if _largest(run.gradient) <= LARGEST_GRADIENT:
            return run.ended("the gradient is zero")
        if not run.step(most_evaluations):
            return run.ended("no step lowers the loss any more")
        if watch:
            watch(run.evaluations, run.value, run.point)
        recent.append(run.value)
        if len(recent) > RECENT and recent[0] - run.value <= relative_change * abs(run.value):
            return run.ended("the loss hardly changes any more")
    return run.ended(f"{most_evaluations} evaluations were made")


class _Run:
    """The state of a run: a point, its gradient, and what earlier steps tell of the curvature.

    All vectors are made once: fresh memory for each would cost more than the arithmetic.
    """

    def __init__(self, function: Function, start: Float, metric: Metric, memory: int) -> None:
        self._function, self._metric = function, metric
        self._moves, self._changes = np.zeros((2, memory, start.size))
        self._inverses = np.zeros(memory)
        self._shares = np.zeros(memory)
        self._known, self._next = 0, 0
        self._scale = 1.0
        self.point = start
        self.gradient = np.empty_like(start)
        self._direction, self._left, self._trial, self._trial_gradient = np.empty((4, start.size))
        self.value = function(start, self.gradient)
        self.evaluations, self.steps = 1, 0
        self._latest = 0.0

    def ended(self, why: str) -> Minimum:
        return Minimum(self.point, self.value, self.evaluations, self.steps, why)

    def step(self, most_evaluations: int) -> bool:
        """Take a step; return whether there was one."""
        slope = self._choose_direction()
        if not slope < 0:
            self._known = 0
            slope = self._choose_direction()
        first = 1.0 if self._known else min(1.0, 1.0 / math.sqrt(max(-slope, 1e-300)))
        trials = min(MOST_TRIALS, most_evaluations - self.evaluations)
        found = wolfe_step(self._tried, Trial(0.0, self.value, slope), first, trials)
        if found is None or found.step * _largest(self._direction) < SMALLEST_STEP:
            if not self._known:
                return False
            self._known = 0
            return self.evaluations < most_evaluations and self.step(most_evaluations)
        self._move(found)
        return True

    def _tried(self, length: float) -> Trial:
        add_scaled(self.point, length, self._direction, self._trial)
        value = self._function(self._trial, self._trial_gradient)
        self.evaluations += 1
        self._latest = length
        return Trial(length, value, float(self._trial_gradient @ self._direction))

    def _move(self, found: Trial) -> None:
        if self._latest != found.step:
            self._tried(found.step)
        moved, change = self._moves[self._next], self._changes[self._next]
        add_scaled(self._trial_gradient, -1.0, self.gradient, change)
        np.multiply(self._direction, found.step, out=moved)
        curvature, length = float(moved @ change), float(change @ change)
        if curvature > SMALLEST_CURVATURE * math.sqrt(float(moved @ moved) * length):
            self._inverses[self._next] = 1.0 / curvature
            self._metric(change, self._left)
            self._scale = curvature / float(change @ self._left)
            self._known = min(self._known + 1, len(self._moves))
            self._next = (self._next + 1) % len(self._moves)
        self.point, self._trial = self._trial, self.point
        self.gradient, self._trial_gradient = self._trial_gradient, self.gradient
        self.value = found.value
        self.steps += 1

    def _choose_direction(self) -> float:
        """Fill the direction, minus inverse Hessian times gradient; return the slope along it."""
        newest = [(self._next - 1 - k) % len(self._moves) for k in range(self._known)]
        order = np.array(newest, dtype=np.int64)
        np.copyto(self._left, self.gradient)
        first_loop(self._moves, self._changes, self._inverses, order, self._shares, self._left)
        self._metric(self._left, self._direction)
        self._direction *= -self._scale if self._known else -1.0
        second_loop(
            self._moves, self._changes, self._inverses, order, self._shares, self._direction
        )
        return float(self.gradient @ self._direction)


def _largest(values: Float) -> float:
    return max(float(values.max()), -float(values.min()))


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def add_scaled(
    first: Float, factor: float, second: Float, out: Float
) -> None:  # pragma: no cover  compiled
    """Fill ``out = first + factor * second``.

    Parameters
    ----------
    first, second, out : (n,) arrays
    factor : float
    """
    for j in range(first.size):
        out[j] = first[j] + factor * second[j]


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def first_loop(
    moves: Float,
    changes: Float,
    inverses: Float,
    order: NDArray[np.int64],
    shares: Float,
    left: Float,
) -> None:  # pragma: no cover  compiled
    """Take from a gradient what earlier steps explain, newest first (Nocedal and Wright, alg. 7.4).

    Parameters
    ----------
    moves, changes : (m, n) arrays
        Of point and gradient.
    inverses : (m,) array
        One over their inner products.
    order : (k,) array
        Rows, newest first.
    shares : (m,) array
        Filled.
    left : (n,) array
        Changed.
    """
    for row in order:
        moved, change = moves[row], changes[row]
        total = 0.0
        for j in range(left.size):
            total += moved[j] * left[j]
        shares[row] = total * inverses[row]
        for j in range(left.size):
            left[j] -= shares[row] * change[j]


@njit(cache=True, error_model="numpy", fastmath=_FAST)
def second_loop(
    moves: Float,
    changes: Float,
    inverses: Float,
    order: NDArray[np.int64],
    shares: Float,
    direction: Float,
) -> None:  # pragma: no cover  compiled
    """Add to a direction of descent what `first_loop` took, oldest first.

    Parameters
    ----------
    moves, changes, inverses, order, shares
        As for `first_loop`.
    direction : (n,) array
        Minus the step; changed.
    """
    for row in order[::-1]:
        moved, change = moves[row], changes[row]
        total = 0.0
        for j in range(direction.size):
            total += change[j] * direction[j]
        factor = -shares[row] - total * inverses[row]
        for j in range(direction.size):
            direction[j] += factor * moved[j]
