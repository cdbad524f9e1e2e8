"""Small problems with every term, and priors of their own, for tests of the loss."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from evaluation.sirfs.depth_term import DepthTerm
from evaluation.sirfs.light_prior import LightPrior
from evaluation.sirfs.objective import Objective, Problem
from evaluation.sirfs.priors import SirfsPriors
from evaluation.sirfs.problem import Observation, problem_of
from evaluation.sirfs.scale_mixture import ScaleMixture
from evaluation.sirfs.settings import TERMS, term_weights
from shading_model.arrays import Float, Mask

SHAPE = (40, 47)


def ellipse(shape: tuple[int, int] = SHAPE) -> Mask:
    """An ellipse six pixels from the picture's edge."""
    rows, columns = shape
    y, x = np.mgrid[:rows, :columns]
    down, right = (y - rows / 2) / (rows / 2 - 6), (x - columns / 2) / (columns / 2 - 6)
    inside: Mask = np.hypot(down, right) < 1
    return inside


def toy_priors() -> SirfsPriors:
    """Priors of smooth, known functions."""
    generator = np.random.default_rng(5)
    scales = np.geomspace(1e-2, 2, 40)
    weights = np.exp(-0.5 * ((np.log(scales) + 1) / 1.5) ** 2)
    weights /= weights.sum()
    shape = np.array([[1.0, 0.9, 0.8], [0.9, 1.0, 0.9], [0.8, 0.9, 1.0]])
    knots = np.linspace(-7, 4, 256)
    axes = np.meshgrid(*(np.linspace(-7, 4, 102),) * 3, indexing="ij")
    lights = {}
    for light in ("natural", "laboratory"):
        for channels, size in (("gray", 9), ("color", 27)):
            drawn = 0.4 * generator.normal(size=(60, size))
            covariance = np.cov(drawn.T) + 0.02 * np.eye(size)
            lights[light, channels] = LightPrior(0.3 * drawn[0], covariance, 60)
    return SirfsPriors(
        curvature=ScaleMixture(weights, scales, 8.0),
        gray_difference=ScaleMixture(weights, scales, 8.0),
        color_difference=ScaleMixture(weights, scales, 60.0, shape / np.cbrt(np.linalg.det(shape))),
        gray_absolute=0.3 * (knots + 1) ** 2,
        color_whitening=np.array([[2.0, -0.6, -0.5], [-0.6, 2.0, -0.5], [-0.5, -0.6, 2.0]]),
        color_absolute=np.ascontiguousarray(0.3 * sum((axis + 0.5) ** 2 for axis in axes)),
        lights=lights,
    )


def toy_problem(
    channels: str, terms: tuple[str, ...] = TERMS, views: int = 1, shape: tuple[int, int] = SHAPE
) -> Problem:
    """A problem of random photographs with only these terms."""
    generator = np.random.default_rng(1)
    mask, count = ellipse(shape), 3 if channels == "color" else 1
    left_out = tuple(term for term in TERMS if term not in terms)
    weights = term_weights("laboratory", channels, left_out)
    images = tuple(generator.uniform(0.05, 1, (*shape, count)) for _ in range(views))
    depth = np.where(generator.uniform(size=shape) < 0.5, generator.normal(size=shape), np.nan)
    seen = Observation(images, (mask,) * views, mask)
    problem = problem_of(seen, toy_priors(), weights, "laboratory", channels)
    if "depth" not in terms:
        return problem
    return replace(problem, depth=DepthTerm(depth, weights.depth, weights.depth_power, 1.5))


def toy_point(problem: Problem, seed: int = 3) -> tuple[Float, Float]:
    """A random height map and random lights for a problem."""
    generator = np.random.default_rng(seed)
    lights = generator.normal(size=(len(problem.views), problem.whitening.mean.size))
    return 0.5 * generator.normal(size=problem.shape), 0.5 * lights


def loss_at(problem: Problem, height: Float, lights: Float) -> float:
    """The loss at a point, by an objective made for it."""
    return Objective(problem)(height, lights).loss
