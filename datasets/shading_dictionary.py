"""The shipped dictionary of smooth shading patches, and the command that learns it again.

``python -m datasets.shading_dictionary`` learns 500 atoms of 12x12 from contour shapes of random
outlines under random lights and writes the file; it needs scikit-learn and no dataset.
"""

from __future__ import annotations

import hashlib
import io
import warnings
from functools import cache
from pathlib import Path

import numpy as np

from datasets.atomic import atomic_path
from shading_model.arrays import Float, Map, Mask
from shading_model.contour_shape import shape_from_contour
from shading_model.errors import RelightlabError
from shading_model.geometric_detail import PatchDictionary, unit_atoms
from shading_model.illumination import PointLights
from shading_model.seeds import generator_for

FILE = Path(__file__).with_name("shading_dictionary.npy")
SHA256 = "ddec147eece304ffc4ca96e67a9090436d497c41ff187c2e1261eb5bac434a6e"
ATOMS = 500
SIDE = 12
OUTLINES = 40
LIGHTS_PER_OUTLINE = 8
PATCHES = 40_000
OUTLINE_SIDE = 320
LEARNING_SPARSITY = 0.1
FLATTEST = 0.02
"""Patches whose deviation from their mean has a smaller norm teach nothing but rounding."""


@cache
def shipped_dictionary() -> PatchDictionary:
    """Return the dictionary that ships with the project, checked against its hash.

    Raises
    ------
    RelightlabError
        If the file is missing or differs from what was shipped.

    Examples
    --------
    >>> shipped_dictionary().atoms.shape
    (500, 12, 12)
    """
    content = FILE.read_bytes() if FILE.is_file() else b""
    if hashlib.sha256(content).hexdigest() != SHA256:
        raise RelightlabError(
            f"{FILE} is missing or damaged: install again, or learn it again with"
            " 'python -m datasets.shading_dictionary'"
        )
    return PatchDictionary(np.load(io.BytesIO(content), allow_pickle=False).astype(np.float64))


def learn_dictionary(patches: Float) -> PatchDictionary:
    """Learn the dictionary.

    Parameters
    ----------
    patches : (n, p * p) array
        Mean-free, of unit norm.

    Returns
    -------
    PatchDictionary
    """
    from sklearn.decomposition import MiniBatchDictionaryLearning  # noqa: PLC0415
    from sklearn.exceptions import ConvergenceWarning  # noqa: PLC0415

    learner = MiniBatchDictionaryLearning(
        n_components=ATOMS,
        alpha=LEARNING_SPARSITY,
        batch_size=1000,
        max_iter=2,
        fit_algorithm="cd",
        transform_algorithm="lasso_cd",
        n_jobs=1,
        random_state=0,
    )
    with warnings.catch_warnings():
        # Each mini-batch is coded only roughly, which is how the method is meant to work.
        warnings.simplefilter("ignore", ConvergenceWarning)
        atoms = unit_atoms(learner.fit(patches).components_)
    side = round(np.sqrt(patches.shape[1]))
    return PatchDictionary(atoms.reshape(-1, side, side))


def smooth_patches(generator: np.random.Generator) -> Float:
    """Return patches of smooth shadings: random outlines under random lights.

    Parameters
    ----------
    generator : numpy.random.Generator

    Returns
    -------
    (n, 144) array
        Mean-free, of unit norm.
    """
    per_shading = PATCHES // (OUTLINES * LIGHTS_PER_OUTLINE)
    drawn = []
    for _ in range(OUTLINES):
        shape = shape_from_contour(random_outline(generator), slope_limit=0.5)
        for _ in range(LIGHTS_PER_OUTLINE):
            shading = random_lights(generator).shade(shape.normals, shape.height)
            drawn.append(_draw_patches(shading, per_shading, generator))
    patches = np.concatenate(drawn)
    bent = np.linalg.norm(patches - patches.mean(axis=1, keepdims=True), axis=1) > FLATTEST
    return unit_atoms(patches[bent])


def random_outline(generator: np.random.Generator, side: int = OUTLINE_SIDE) -> Mask:
    """Return the mask of a smooth star-shaped outline: a circle with six random harmonics.

    Parameters
    ----------
    generator : numpy.random.Generator
    side : int
        Of the picture, in pixels.

    Returns
    -------
    (side, side) bool array
    """
    rows, columns = np.mgrid[:side, :side] - (side - 1) / 2
    angle = np.arctan2(rows, columns)
    order = np.arange(1, 7)
    size = generator.normal(size=6) * 0.25 / order
    phase = generator.uniform(0, 2 * np.pi, 6)
    radius = 1 + np.cos(angle[..., None] * (order + 1) + phase) @ size
    reach = 0.45 * side / radius.max()
    outline: Mask = np.hypot(rows, columns) <= reach * np.maximum(radius, 0.15)
    return outline


def random_lights(generator: np.random.Generator, side: int = OUTLINE_SIDE) -> PointLights:
    """Return one to three point sources in front of and around an outline's picture.

    Parameters
    ----------
    generator : numpy.random.Generator
    side : int
        Of the picture, in pixels.

    Returns
    -------
    PointLights
    """
    count = int(generator.integers(1, 4))
    directions = generator.normal(size=(count, 3))
    directions[:, 2] = np.abs(directions[:, 2]) + 0.2
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    distance = generator.uniform(1.5, 5, size=(count, 1)) * side
    positions = directions * distance + np.array([side / 2, -side / 2, 0.0])
    strength = generator.dirichlet(np.ones(count))
    return PointLights(positions, strength * distance[:, 0] ** 2)


def _draw_patches(shading: Map, count: int, generator: np.random.Generator) -> Float:
    windows = np.lib.stride_tricks.sliding_window_view(shading, (SIDE, SIDE))
    whole = windows[np.isfinite(windows).all(axis=(2, 3))].reshape(-1, SIDE * SIDE)
    scaled = whole / (2 * np.nanmean(shading))
    return scaled[generator.choice(len(whole), size=count, replace=False)]


def main() -> None:
    """Learn the dictionary and write it; print its SHA-256, which belongs into this module."""
    atoms = learn_dictionary(smooth_patches(generator_for("shading-dictionary", 1))).atoms
    with atomic_path(FILE) as path, path.open("wb") as stream:
        np.save(stream, atoms.astype(np.float32))
    print(f"{FILE}: SHA-256 {hashlib.sha256(FILE.read_bytes()).hexdigest()}")


if __name__ == "__main__":
    main()
