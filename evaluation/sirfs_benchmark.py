"""How long a fit of SIRFS takes, where its time goes, and how far that is from the memory's speed.

Printed by ``python -m evaluation.benchmark``. The bound counts every array of an evaluation once,
over the copy bandwidth measured in the same run on an array of the same size.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from datasets.records import Dataset
from evaluation.sirfs.fit import FitOptions, fit_sirfs
from evaluation.sirfs.framing import checked_photograph, frame_around
from evaluation.sirfs.height_kernels import height_adjoint, padded_height, slopes_of
from evaluation.sirfs.objective import Objective, Problem
from evaluation.sirfs.prior_files import shipped_priors
from evaluation.sirfs.problem import Observation, problem_of
from evaluation.sirfs.settings import term_weights
from evaluation.sirfs.shading_kernels import log_albedo, log_albedo_adjoint
from evaluation.sirfs.view import ViewBuffers, view_loss
from evaluation.sirfs_fits import object_outline
from shading_model.arrays import Float

REPEATS = 15
SETTING = LIGHT = "laboratory"
LIMITS = {"raccoon": 15.0, "sun": 60.0}
"""Seconds that a fit in colour may take."""
HEIGHT_ARRAYS, CHANNEL_ARRAYS = 16, 5
"""Arrays of the rectangle, and of the valid pixels for each channel, that an evaluation touches."""


@dataclass(frozen=True)
class FitTimes:
    """Times of one object.

    Parameters
    ----------
    name : str
    pixels, valid : int
        Of the rectangle, and of the object.
    seconds : float
        Of the whole fit.
    evaluations : float
    parts : dict of float
        Median seconds of the parts of one evaluation, and of ``all`` of it.
    bound : float
        Seconds to touch every array once.
    """

    name: str
    pixels: int
    valid: int
    seconds: float
    evaluations: float
    parts: dict[str, float]
    bound: float


def fit_times(dataset: Dataset, name: str) -> FitTimes:
    """Fit an object in colour, and time the parts of an evaluation at its solution.

    Parameters
    ----------
    dataset : Dataset
    name : str

    Returns
    -------
    FitTimes
    """
    photograph = dataset.load(name, SETTING).photograph
    outline, priors = object_outline(dataset, name, SETTING), shipped_priors()
    options = FitOptions(light=LIGHT)
    fit_sirfs(photograph.image, photograph.mask, priors, FitOptions(evaluations=(2,)))  # compiles
    started = time.perf_counter()
    fit = fit_sirfs(photograph.image, photograph.mask, priors, options, outline=outline)
    seconds = time.perf_counter() - started
    image, valid = checked_photograph(photograph.image, photograph.mask, options.channels)
    frame = frame_around(photograph.mask | outline)
    seen = Observation((frame.cut(image),), (frame.cut(valid),), frame.cut(outline))
    problem = problem_of(seen, priors, term_weights(LIGHT, "color"), LIGHT, "color")
    height = np.nan_to_num(frame.cut(fit.height), nan=float(np.nanmin(fit.height)))
    parts = _parts(problem, height)
    pixels, count = height.size, int(valid.sum())
    touched = 8 * (HEIGHT_ARRAYS * pixels + CHANNEL_ARRAYS * 3 * count)
    return FitTimes(name, pixels, count, seconds, fit.evaluations, parts, touched / _bandwidth())


def report_fit(times: FitTimes) -> list[str]:
    r"""Return the lines that show one object's fit.

    Parameters
    ----------
    times : FitTimes

    Examples
    --------
    >>> parts = {"all": 0.010, "slant": 0.001}
    >>> print("\n".join(report_fit(FitTimes("sun", 9, 4, 20.0, 1000, parts, 0.001))))
    SIRFS on sun in colour: 20.0 s (limit 60) ok; 1000 evaluations, 20.0 ms each with their step
      an evaluation by itself 10.00 ms, 10.0 times the bound of memory (1.00 ms)
        slant                     1.00 ms   10 %
    """
    limit = LIMITS.get(times.name)
    verdict = ""
    if limit is not None:
        verdict = f" (limit {limit:.0f}) {'ok' if times.seconds <= limit else 'SLOWER'}"
    alone = times.parts["all"]
    whole = (
        f"SIRFS on {times.name} in colour: {times.seconds:.1f} s{verdict};"
        f" {times.evaluations:.0f} evaluations,"
        f" {1e3 * times.seconds / times.evaluations:.1f} ms each with their step"
    )
    one = (
        f"  an evaluation by itself {1e3 * alone:.2f} ms, {alone / times.bound:.1f} times the bound"
        f" of memory ({1e3 * times.bound:.2f} ms)"
    )
    return [whole, one] + [
        f"    {part:<22}{1e3 * seconds:8.2f} ms {100 * seconds / alone:4.0f} %"
        for part, seconds in times.parts.items()
        if part != "all"
    ]


def _parts(problem: Problem, height: Float) -> dict[str, float]:
    objective, view = Objective(problem), problem.views[0]
    apart = replace(view, smoothness=0.0)
    buffers = ViewBuffers.of(view)
    lights = np.zeros((1, problem.whitening.mean.size))
    light = np.zeros((3, 9))
    rows, columns = problem.shape
    gradients, padded = np.zeros((5, rows + 4, columns + 4)), np.zeros((rows + 2, columns + 2))
    objective(height, lights)
    down, right = objective.slopes()
    work: dict[str, Callable[[], object]] = {
        "all": lambda: objective(height, lights),
        "slopes": lambda: (padded_height(height, padded), slopes_of(padded, down, right)),
        "curvature": objective.curvature_term,
        "slant": objective.slant_term,
        "contour": objective.contour_term,
        "log albedo": lambda: log_albedo(
            down, right, view.runs, light, view.log_image, buffers.albedo
        ),
        "its adjoint": lambda: log_albedo_adjoint(
            down, right, view.runs, light, buffers.by_albedo, gradients, light.copy()
        ),
        "view": lambda: view_loss(view, buffers, down, right, light, gradients),
        "view without pairs": lambda: view_loss(apart, buffers, down, right, light, gradients),
        "adjoint of heights": lambda: height_adjoint(gradients, np.empty(problem.shape)),
    }
    times = {part: _median_seconds(one) for part, one in work.items()}
    whole, without = times.pop("view"), times.pop("view without pairs")
    times["albedo smoothness"] = whole - without
    times["entropy, absolute"] = without - times["log albedo"] - times["its adjoint"]
    return times


def _median_seconds(work: Callable[[], object]) -> float:
    work()
    seconds = []
    for _ in range(REPEATS):
        started = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - started)
    return float(np.median(seconds))


def _bandwidth(megabytes: float = 20.0) -> float:
    """Return bytes read and written per second by a copy."""
    source = np.ones(int(megabytes * 1e6 / 16))
    target = np.zeros_like(source)
    return 2 * source.nbytes / _median_seconds(lambda: np.copyto(target, source))
