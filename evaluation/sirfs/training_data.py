"""What the priors of SIRFS are learned from: log albedos, and differences between neighbours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.ndimage import correlate
from scipy.sparse.linalg import splu

from datasets.mit_berkeley import TRAINING_OBJECTS, MitBerkeley
from shading_model.arrays import Float, Map, Mask
from shading_model.errors import RelightlabError
from shading_model.height_field import slopes
from shading_model.seeds import generator_for

SAMPLES = 30_000
"""Of each kind from each object."""
OFFSETS = (
    *((0, 1), (0, 2)),
    *((1, column) for column in range(-2, 3)),
    *((2, column) for column in range(-2, 3)),
)
"""The pairs of a 5x5 window: from a pixel to its neighbours below and to the right."""


@dataclass(frozen=True, eq=False)
class TrainingSamples:
    """Samples of one object.

    Parameters
    ----------
    curvature_differences : (n,) array
        Of the mean curvature of the true height, 1/pixels.
    gray_differences : (n,) array
        Of the log of the mean of the channels of the true albedo.
    color_differences : (n, 3) array
        Of the log of the true albedo.
    gray : (n,) array
        Logs of the mean of the channels of the true albedo.
    color : (n, 3) array
        Logs of the true albedo.
    """

    curvature_differences: Float
    gray_differences: Float
    color_differences: Float
    gray: Float
    color: Float


def training_samples(
    dataset: MitBerkeley, names: Sequence[str] = TRAINING_OBJECTS
) -> tuple[TrainingSamples, ...]:
    """Return what the training objects of the set teach, 30000 samples of each kind from each.

    Parameters
    ----------
    dataset : MitBerkeley
    names : sequence of str

    Returns
    -------
    tuple of TrainingSamples
        In the order of the names.

    Raises
    ------
    RelightlabError
        If a file of the set is missing or damaged.

    Examples
    --------
    >>> from pathlib import Path
    >>> training_samples(MitBerkeley(Path("mit-berkeley")), ())
    ()
    """
    return tuple(_samples_of(dataset, name) for name in names)


def _samples_of(dataset: MitBerkeley, name: str) -> TrainingSamples:
    truth = dataset.load(name, "laboratory").truth
    if truth.height is None or truth.albedo is None:
        raise RelightlabError(f"learning needs the true height and albedo of {name}")
    known = np.isfinite(truth.height)
    albedo = np.nan_to_num(truth.albedo, nan=0.0)
    lit: Mask = albedo.mean(axis=-1) > 0
    colored: Mask = albedo.min(axis=-1) > 0
    gray = np.log(np.where(lit, albedo.mean(axis=-1), 1.0))
    color = np.log(np.where(colored[..., None], albedo, 1.0))

    def drawn(kind: str, values: Float) -> Float:
        return draw(values, SAMPLES, generator_for("sirfs", kind, name))

    curvature = mean_curvature(filled_height(truth.height))
    return TrainingSamples(
        drawn("curvature", neighbor_differences(curvature, known)),
        drawn("gray differences", neighbor_differences(gray, lit)),
        drawn("color differences", neighbor_differences(color, colored)),
        drawn("gray", gray[lit]),
        drawn("color", color[colored]),
    )


def draw(values: Float, count: int, generator: np.random.Generator) -> Float:
    """Return at most so many of the values, drawn without replacement.

    Parameters
    ----------
    values : (n, ...) array
    count : int
    generator : Generator

    Examples
    --------
    >>> draw(np.arange(3.0), 5, np.random.default_rng(0))
    array([0., 1., 2.])
    """
    if len(values) <= count:
        return values
    drawn: Float = values[generator.choice(len(values), count, replace=False)]
    return drawn


def neighbor_differences(values: Float, valid: Mask) -> Float:
    """Return the differences of all pairs of valid pixels in a common 5x5 window.

    Parameters
    ----------
    values : (h, w) or (h, w, c) array
    valid : (h, w) bool array

    Returns
    -------
    (n,) or (n, c) array
        Pixel minus the one below or to the right, offset by offset of `OFFSETS`.

    Examples
    --------
    >>> neighbor_differences(np.array([[1.0, 2.0, 4.0]]), np.ones((1, 3), bool))
    array([-1., -2., -3.])
    """
    height, width = valid.shape
    parts = []
    for down, right in OFFSETS:
        first = (slice(0, max(height - down, 0)), slice(max(-right, 0), width - max(right, 0)))
        second = (slice(down, None), slice(max(right, 0), width + min(right, 0)))
        if height > down and width > abs(right):
            both = valid[first] & valid[second]
            parts.append(values[first][both] - values[second][both])
    return np.concatenate(parts) if parts else values.reshape(-1, *values.shape[2:])[:0]


def mean_curvature(height: Map) -> Map:
    """Return the mean curvature of a height field: 3x3 stencils, borders replicated.

    ``[(1 + Zx^2) Zyy - 2 Zx Zy Zxy + (1 + Zy^2) Zxx] / [2 (1 + Zx^2 + Zy^2)^(3/2)]``: negative
    where the surface bulges toward the viewer.

    Parameters
    ----------
    height : (h, w) array
        Pixels, finite.

    Returns
    -------
    (h, w) array
        1/pixels.

    Examples
    --------
    >>> x = np.arange(-2.0, 3.0)
    >>> mean_curvature(np.tile(x * x / 2, (5, 1)))[2, 2].round(3)
    np.float64(0.5)
    """
    right, up = slopes(height)
    bent, smooth = np.array([1.0, -2.0, 1.0]), np.array([1.0, 2.0, 1.0]) / 4
    step = np.array([-1.0, 0.0, 1.0]) / 2

    def filtered(rows: Float, columns: Float) -> Map:
        result: Map = correlate(height, np.outer(rows, columns), mode="nearest")
        return result

    along, upward, across = filtered(smooth, bent), filtered(bent, smooth), -filtered(step, step)
    numerator = (1 + right**2) * upward - 2 * right * up * across + (1 + up**2) * along
    curvature: Map = numerator / (2 * (1 + right**2 + up**2) ** 1.5)
    return curvature


def filled_height(height: Map) -> Map:
    """Return a height whose unknown pixels bend least: a thin plate through the known ones.

    Minimises the sum of the squared second differences, twice those across, over the rectangle.

    Parameters
    ----------
    height : (h, w) array
        NaN where unknown.

    Returns
    -------
    (h, w) array
        Finite; the known pixels as they were.

    Raises
    ------
    RelightlabError
        If the known pixels do not hold a plate: fewer than three, or all on one line.

    Examples
    --------
    >>> plane = np.add.outer(2.0 * np.arange(4), np.arange(5.0))
    >>> holed = plane.copy()
    >>> holed[1, 2] = holed[3] = np.nan
    >>> bool(np.allclose(filled_height(holed), plane))
    True
    """
    known = np.isfinite(height).ravel()
    if np.linalg.matrix_rank(_corners(height)) < 3:
        raise RelightlabError(
            "expected known heights at three pixels at least that are not on one line"
        )
    bending = _second_differences(height.shape)
    unknown = bending[:, ~known]
    filled = height.ravel().copy()
    if not known.all():
        side = -(unknown.T @ (bending[:, known] @ filled[known]))
        factor = splu(
            (unknown.T @ unknown).tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        filled[~known] = factor.solve(side)
    return filled.reshape(height.shape)


def _corners(height: Map) -> Float:
    rows, columns = np.nonzero(np.isfinite(height))
    spread = np.stack([np.ones(rows.size), rows, columns], axis=1)
    return np.asarray(spread.T @ spread, dtype=np.float64)


def _second_differences(shape: tuple[int, ...]) -> sparse.csr_array:
    pixels = np.arange(shape[0] * shape[1]).reshape(shape)
    bent, twisted = (1.0, -2.0, 1.0), np.sqrt(2.0) * np.array([1.0, -1.0, -1.0, 1.0])
    corners = (pixels[:-1, :-1], pixels[:-1, 1:], pixels[1:, :-1], pixels[1:, 1:])
    stencils = (
        ((pixels[:-2], pixels[1:-1], pixels[2:]), bent),
        ((pixels[:, :-2], pixels[:, 1:-1], pixels[:, 2:]), bent),
        (corners, twisted),
    )
    blocks = []
    for places, weights in stencils:
        count = places[0].size
        rows = np.tile(np.arange(count), len(places))
        columns = np.concatenate([place.ravel() for place in places])
        entries = (np.repeat(weights, count), (rows, columns))
        blocks.append(sparse.csr_array(entries, shape=(count, pixels.size)))
    return sparse.vstack(blocks).tocsr()
