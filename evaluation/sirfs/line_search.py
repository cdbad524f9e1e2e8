"""A step length that satisfies the strong Wolfe conditions (Nocedal and Wright 2006, sec. 3.5)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

DECREASE = 1e-4
"""c_1: the least share of the predicted decrease."""
CURVATURE = 0.9
"""c_2: the largest share of the slope that may be left."""
MOST_TRIALS = 25


@dataclass(frozen=True)
class Trial:
    """The function along a line: step length, value and slope there."""

    step: float
    value: float
    slope: float


Line = Callable[[float], Trial]
"""Takes a step length."""


def wolfe_step(line: Line, start: Trial, first: float, trials: int = MOST_TRIALS) -> Trial | None:
    """Return a step that satisfies the strong Wolfe conditions, or the best that decreases enough.

    Parameters
    ----------
    line : callable
    start : Trial
        At step zero; its slope is negative.
    first : float
        The first step tried.
    trials : int
        At most so many calls of `line`.

    Returns
    -------
    Trial or None
        None if no step with a sufficient decrease was found.

    Examples
    --------
    >>> found = wolfe_step(lambda t: Trial(t, (t - 3) ** 2, 2 * (t - 3)), Trial(0, 9.0, -6.0), 1.0)
    >>> abs(found.slope) <= 0.9 * 6.0
    True
    """
    before, step = start, first
    for left in range(trials, 0, -1):
        trial = line(step)
        if not math.isfinite(trial.value):
            step = before.step + (step - before.step) / 2
            continue
        if not _decreased(trial, start) or (before is not start and trial.value >= before.value):
            return _zoom(line, start, before, trial, left - 1)
        if _flat(trial, start):
            return trial
        if trial.slope >= 0:
            return _zoom(line, start, trial, before, left - 1)
        nearest, farthest = (trial.step + f * (trial.step - before.step) for f in (0.01, 10.0))
        step = min(max(_cubic_minimum(before, trial), nearest), farthest)
        before = trial
    return before if before is not start else None


def _decreased(trial: Trial, start: Trial) -> bool:
    return trial.value <= start.value + DECREASE * trial.step * start.slope


def _flat(trial: Trial, start: Trial) -> bool:
    return abs(trial.slope) <= -CURVATURE * start.slope


def _zoom(line: Line, start: Trial, low: Trial, high: Trial, trials: int) -> Trial | None:
    """Narrow a bracket; `low` is the lower of its ends that decreases enough."""
    for _ in range(trials):
        width = abs(high.step - low.step)
        step = _cubic_minimum(low, high)
        least, most = sorted((low.step, high.step))
        step = min(max(step, least + 0.1 * width), most - 0.1 * width)
        trial = line(step)
        if not (math.isfinite(trial.value) and _decreased(trial, start)) or (
            trial.value >= low.value
        ):
            high = trial if math.isfinite(trial.value) else Trial(step, math.inf, 0.0)
        else:
            if _flat(trial, start):
                return trial
            if trial.slope * (high.step - low.step) >= 0:
                high = low
            low = trial
        if width < 1e-12 * max(abs(low.step), 1e-300):
            break
    return low if low is not start else None


def _cubic_minimum(first: Trial, second: Trial) -> float:
    """Return the minimiser of the cubic through two values and slopes; the middle if there is none.

    Nocedal and Wright, eq. 3.59.
    """
    middle = (first.step + second.step) / 2
    if not math.isfinite(second.value) or first.step == second.step:
        return middle
    between = first.step - second.step
    d1 = first.slope + second.slope - 3 * (first.value - second.value) / between
    inside = d1 * d1 - first.slope * second.slope
    if inside < 0:
        return middle if second.slope >= 0 else math.inf
    d2 = math.copysign(math.sqrt(inside), second.step - first.step)
    bottom = second.slope - first.slope + 2 * d2
    if bottom == 0:
        return middle
    return second.step - (second.step - first.step) * (second.slope + d2 - d1) / bottom
