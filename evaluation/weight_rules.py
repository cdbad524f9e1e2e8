"""Rules that choose the weights w = (1, w_p, w_g) of the detail layers, by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from evaluation.rerendering import RerenderingCell
from shading_model.arrays import Float, Mask
from shading_model.errors import RelightlabError
from shading_model.object_model import Weights

NEIGHBOURS = 100
"""Points the paper draws for each regression."""
MANUAL = Weights(0.5, 0.5)
"""Weights an artist might start from: half of either layer. Not adjusted to any object."""


@dataclass(frozen=True, eq=False)
class CellGrid:
    """The cells of one table entry: every object under every light.

    Parameters
    ----------
    cells : tuple of tuples of RerenderingCell
        Objects by lights.
    coefficients : (l, 9) array
        The lights.
    manual : Weights
        What the artist chose.
    """

    cells: tuple[tuple[RerenderingCell, ...], ...]
    coefficients: Float
    manual: Weights = MANUAL

    @cached_property
    def oracle(self) -> Float:
        """Oracle weights, (objects, lights, 2)."""
        chosen = [[cell.oracle() for cell in row] for row in self.cells]
        return np.array([[(w.parametric, w.geometric) for w in row] for row in chosen])

    def errors(self, weights: Float) -> Float:
        """Return the error of every cell at weights (objects, lights, 2).

        Returns
        -------
        (objects, lights) array
        """
        return np.array(
            [
                [cell.error(Weights(*w.tolist())) for cell, w in zip(row, ws, strict=True)]
                for row, ws in zip(self.cells, weights, strict=True)
            ]
        )

    def constant(self, weights: Weights) -> Float:
        """Return the same weights for every cell, (objects, lights, 2)."""
        shape = (len(self.cells), len(self.coefficients), 2)
        return np.broadcast_to([weights.parametric, weights.geometric], shape)


WeightRule = Callable[[CellGrid], Float]


def regressed(grid: CellGrid, neighbours: int = NEIGHBOURS) -> Float:
    """Return weights predicted from the light by a linear model learned on other objects.

    For each object and light, the oracle weights of the other objects are fitted by least squares
    as an affine function of the nine coefficients, over the `neighbours` points nearest in
    coefficient space. Because all objects share the same lights, those points lie at few distinct
    lights; directions they do not span get no slope (the solution of minimum norm). Points at
    equal distance all count alike: ties at the last place are kept.

    Parameters
    ----------
    grid : CellGrid
    neighbours : int

    Returns
    -------
    (objects, lights, 2) array
        NaN if there is no other object.
    """
    distance = np.linalg.norm(grid.coefficients[:, None] - grid.coefficients[None], axis=-1)
    others = len(grid.cells) - 1
    predicted = np.full((len(grid.cells), len(grid.coefficients), 2), np.nan)
    if not others:
        return predicted
    for light in range(len(grid.coefficients)):
        order = np.argsort(distance[light], kind="stable")
        near = order[: -(-neighbours // others)]
        offset = grid.coefficients[near] - grid.coefficients[light]
        for index in range(len(grid.cells)):
            known = _known_mean(np.delete(grid.oracle, index, axis=0)[:, near])
            predicted[index, light] = _affine_at_zero(offset, known)
    return predicted


def regressed_by_own_lights(
    oracle: Float, coefficients: Float, neighbours: int = NEIGHBOURS
) -> Float:
    """Return weights as `regressed` predicts them, where every object has lights of its own.

    Parameters
    ----------
    oracle : (objects, lights, 2) array
        Oracle weights; NaN where a cell is missing, which then teaches and learns nothing.
    coefficients : (objects, lights, 9) array
    neighbours : int
        As many points of other objects as are nearest; all of them where there are fewer.

    Returns
    -------
    (objects, lights, 2) array
        NaN where a cell is missing, or no other object has a known one.

    Examples
    --------
    >>> lights = np.arange(18.0).reshape(2, 1, 9)
    >>> oracle = np.array([[[0.2, 0.4]], [[1.0, 0.5]]])
    >>> regressed_by_own_lights(oracle, lights).tolist()
    [[[1.0, 0.5]], [[0.2, 0.4]]]
    """
    predicted = np.full(oracle.shape, np.nan)
    known: Mask = np.isfinite(np.concatenate([oracle, coefficients], axis=-1)).all(axis=-1)
    for index in range(len(oracle)):
        taught = known.copy()
        taught[index] = False
        points, weights = coefficients[taught], oracle[taught]
        for light in np.flatnonzero(known[index]) if len(points) else ():
            offset = points - coefficients[index, light]
            distance = np.linalg.norm(offset, axis=-1)
            last = np.sort(distance)[min(neighbours, len(points)) - 1]
            near = distance <= last
            predicted[index, light] = _affine_at_zero(offset[near], weights[near])
    return predicted


def _known_mean(weights: Float) -> Float:
    """Return the mean over objects of the weights that are not NaN, (lights, 2)."""
    known = np.isfinite(weights)
    total = np.where(known, weights, 0.0).sum(axis=0)
    mean: Float = np.divide(total, known.sum(axis=0), out=np.full_like(total, np.nan),
                            where=known.any(axis=0))  # fmt: skip
    return mean


def _affine_at_zero(offset: Float, values: Float) -> Float:
    """Return the value at offset zero of the affine least-squares fit, (2,)."""
    centre = offset.mean(axis=0)
    slope = np.linalg.lstsq(offset - centre, values - values.mean(axis=0), rcond=1e-8)[0]
    result: Float = values.mean(axis=0) - centre @ slope
    return result


def checked_weights(grid: CellGrid, name: str, rule: WeightRule) -> Float:
    """Return the weights a rule chooses, if they are weights of the grid's cells.

    Parameters
    ----------
    grid : CellGrid
    name : str
        Of the rule.
    rule : WeightRule

    Returns
    -------
    (objects, lights, 2) array
        NaN where the rule has no answer.

    Raises
    ------
    RelightlabError
        If they are of another shape.
    """
    weights = np.asarray(rule(grid), dtype=np.float64)
    expected = (len(grid.cells), len(grid.coefficients), 2)
    if weights.shape != expected:
        raise RelightlabError(
            f"the weight rule {name!r} returned shape {weights.shape},"
            f" expected (objects, lights, 2) = {expected}"
        )
    return weights


WEIGHT_RULES: dict[str, WeightRule] = {
    "coarse": lambda grid: grid.constant(Weights(0.0, 0.0)),
    "default": lambda grid: grid.constant(Weights(1.0, 1.0)),
    "regression": regressed,
    "oracle": lambda grid: grid.oracle,
    "manual": lambda grid: grid.constant(grid.manual),
}
"""Every rule of Table 1; a new one is a line here."""
