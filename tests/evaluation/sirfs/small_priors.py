"""A set in miniature that priors can be learned from, and priors made up for tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from datasets.mit_berkeley import OBJECTS, TRAINING_OBJECTS
from evaluation.sirfs.light_prior import LightPrior
from evaluation.sirfs.priors import SirfsPriors
from evaluation.sirfs.scale_mixture import ScaleMixture
from shading_model.arrays import Float
from tests.datasets.mit_miniature import write_miniature, write_png


def small_priors() -> SirfsPriors:
    """Priors of random numbers, of a few knots; no two alike."""
    generator = np.random.default_rng(7)

    def mixture(covariance: Float | None = None) -> ScaleMixture:
        scales = np.sort(generator.random(4)) + 0.1
        return ScaleMixture(generator.dirichlet(np.ones(4)), scales, 3.0, covariance)

    def light(size: int) -> LightPrior:
        root = generator.normal(size=(size, size))
        return LightPrior(generator.normal(size=size), root @ root.T, 50)

    return SirfsPriors(
        curvature=mixture(),
        gray_difference=mixture(),
        color_difference=mixture(np.diag([2.0, 1.0, 0.5])),
        gray_absolute=generator.random(256),
        color_whitening=generator.normal(size=(3, 3)),
        color_absolute=generator.integers(0, 9000, size=(6, 6, 6)) / 256,
        lights={("natural", "color"): light(27), ("laboratory", "gray"): light(9)},
    )


def write_training_set(root: Path) -> None:
    """Write all that learning reads: miniatures of the training objects, and lights."""
    generator = np.random.default_rng(11)
    for name in TRAINING_OBJECTS:
        made, folder = write_miniature(root, name), root / "MIT-Berkeley-Laboratory" / name
        varied = made.reflectance * generator.uniform(0.5, 1.0, made.reflectance.shape)
        write_png(folder / "reflectance.png", varied)
        savemat(folder / "L.mat", {"color_lights": twelve_lights(generator)})
    for name in sorted(set(OBJECTS) - set(TRAINING_OBJECTS)):
        folder = root / "MIT-Berkeley-Natural" / name
        folder.mkdir(parents=True)
        savemat(folder / "L.mat", {"L": generator.normal(size=(9, 3)) * 0.1})
    savemat(root / "natural_lights.mat", {"Ls": frontal(generator, 20)})


def twelve_lights(generator: np.random.Generator) -> dict[str, Any]:
    """The lights fitted to an object, as its file holds them."""
    lights = frontal(generator, 12)
    cells = np.empty((1, 10), dtype=object)
    cells[0] = [lights[:, :, k] for k in range(10)]
    return {"light": cells, "diffuse": lights[:, :, 10], "shading": lights[:, :, 11]}


def frontal(generator: np.random.Generator, count: int) -> Float:
    """Random lights from the front, (9, 3, count)."""
    lights = generator.normal(scale=0.1, size=(9, 3, count))
    lights[2] += 0.4
    return lights
