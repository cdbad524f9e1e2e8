"""Models, truths and cells made from random arrays."""

from __future__ import annotations

import numpy as np

from datasets.records import GroundTruth
from evaluation.rerendering import RerenderingCell
from shading_model.arrays import Float, Mask
from shading_model.illumination import LogHarmonics, PointLights
from shading_model.object_model import ObjectModel
from tests.shading_model.outlines import unit_normals

SHAPE = (9, 11)


def random_model(generator: np.random.Generator, detail: float = 0.2) -> ObjectModel:
    """A model with random maps on a ragged mask; detail layers of this deviation."""
    mask: Mask = generator.random(SHAPE) > 0.2
    return ObjectModel(
        mask=mask,
        albedo=generator.uniform(0.1, 1, size=(*SHAPE, 3)),
        height=generator.normal(size=SHAPE),
        normals=unit_normals(generator, *SHAPE),
        parametric_residual=detail * generator.normal(size=SHAPE),
        geometric_detail=detail * generator.normal(size=SHAPE),
        illumination=PointLights(np.array([[0.0, 0.0, 50.0]]), np.array([2500.0])),
    )


def random_truth(generator: np.random.Generator) -> GroundTruth:
    """True normals and albedo, unknown at some pixels."""
    normals = unit_normals(generator, *SHAPE)
    normals[generator.random(SHAPE) < 0.1] = np.nan
    return GroundTruth(normals=normals, albedo=generator.uniform(0.1, 1, size=(*SHAPE, 3)))


def random_lights(generator: np.random.Generator, count: int = 2) -> tuple[LogHarmonics, ...]:
    """Lights of one colour and moderate contrast."""
    return tuple(LogHarmonics(0.3 * generator.normal(size=9)) for _ in range(count))


def cell_of_best(weights: Float, generator: np.random.Generator) -> RerenderingCell:
    """A cell whose oracle weights are these two, with a random Gram matrix and strength."""
    root = generator.normal(size=(5, 3))
    gram = root.T @ root
    best = generator.uniform(0.5, 2) * np.array([1.0, *weights])
    cross = gram @ best
    return RerenderingCell(gram, cross, float(best @ cross) + generator.random())
