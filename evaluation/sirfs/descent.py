"""Minimising the loss of one problem: the unknowns as one vector, in the pyramid's metric."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from evaluation.sirfs.objective import Evaluation, Objective, Problem
from evaluation.sirfs.pyramid import Pyramid
from evaluation.sirfs.quasi_newton import RELATIVE_CHANGE, minimise
from shading_model.arrays import Float

Watch = Callable[[int, float], None]
"""Called after each step with evaluations so far and the loss."""


@dataclass(frozen=True, eq=False)
class Unknowns:
    """What is fitted.

    Parameters
    ----------
    height : (h, w) array
        Pixels.
    lights : (v, 9 c) array
        White coordinates of each view's light.
    """

    height: Float
    lights: Float


@dataclass(frozen=True)
class Fixed:
    """What is known, and stays as it is.

    Parameters
    ----------
    height, lights : bool
    """

    height: bool = False
    lights: bool = False


@dataclass(frozen=True, eq=False)
class Descent:
    """Where a descent ended.

    Parameters
    ----------
    unknowns : Unknowns
    evaluation : Evaluation
        There.
    log_albedo : tuple of (c, h, w) arrays
        Of each view; meaningful where the view is valid.
    evaluations : int
    stopped : str
        Why, in words.
    """

    unknowns: Unknowns
    evaluation: Evaluation
    log_albedo: tuple[Float, ...]
    evaluations: int
    stopped: str


def descend(
    problem: Problem,
    start: Unknowns,
    *,
    most_evaluations: int,
    fixed: Fixed = Fixed(),
    relative_change: float = RELATIVE_CHANGE,
    watch: Watch | None = None,
) -> Descent:
    """Minimise the loss of a problem from a start.

    Parameters
    ----------
    problem : Problem
    start : Unknowns
    most_evaluations : int
    fixed : Fixed
    relative_change : float
        See `evaluation.sirfs.quasi_newton`.
    watch : callable, optional

    Returns
    -------
    Descent
    """
    objective, pyramid = Objective(problem), Pyramid(problem.shape)
    pixels = start.height.size

    def unpacked(vector: Float) -> Unknowns:
        lights = vector[pixels:].reshape(start.lights.shape)
        return Unknowns(vector[:pixels].reshape(problem.shape), lights)

    def function(vector: Float, gradient: Float) -> float:
        at, out = unpacked(vector), unpacked(gradient)
        # A step that is far too long is told by a loss that is not finite, which is shortened.
        with np.errstate(over="ignore", invalid="ignore"):
            found = objective(at.height, at.lights)
        out.height[:] = 0.0 if fixed.height else found.by_height
        out.lights[:] = 0.0 if fixed.lights else found.by_lights
        return found.loss

    def metric(gradient: Float, step: Float) -> None:
        given, out = unpacked(gradient), unpacked(step)
        out.lights[:] = given.lights
        if fixed.height:
            out.height[:] = 0.0
        else:
            pyramid.metric(given.height, out.height)

    found = minimise(
        function,
        np.concatenate([start.height.ravel(), start.lights.ravel()]),
        metric,
        most_evaluations=most_evaluations,
        relative_change=relative_change,
        watch=None if watch is None else lambda done, loss, _: watch(done, loss),
    )
    end = unpacked(found.point)
    with np.errstate(over="ignore", invalid="ignore"):
        evaluation = objective(end.height, end.lights)
    albedo = tuple(objective.log_albedo(view).copy() for view in range(len(problem.views)))
    return Descent(end, evaluation, albedo, found.evaluations, found.stopped)
