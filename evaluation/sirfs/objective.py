"""The loss of SIRFS and its gradient, by height and by light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from evaluation.sirfs.depth_term import DepthTerm
from evaluation.sirfs.height_kernels import (
    CURVATURE_FLOOR,
    FLAT_ENDS,
    curvature_adjoint,
    curvature_of,
    height_adjoint,
    padded_height,
    slant_loss,
    slopes_of,
)
from evaluation.sirfs.light_prior import LightWhitening
from evaluation.sirfs.pair_kernels import LINES, difference_loss
from evaluation.sirfs.regions import Outline, Runs
from evaluation.sirfs.scale_mixture import CostTable
from evaluation.sirfs.settings import TermWeights
from evaluation.sirfs.shading_kernels import contour_loss
from evaluation.sirfs.view import View, ViewBuffers, view_loss
from shading_model.arrays import Float

_CONTOUR_SCALE = 60.0
_WINDOW_AREA = 25.0


@dataclass(frozen=True, eq=False)
class Problem:
    """Everything that the loss depends on but the unknowns.

    Parameters
    ----------
    shape : (h, w)
        Size of the rectangle that heights are known on.
    views : tuple of View
        One photograph, or several under different lights that share one shape.
    runs, pairs : int arrays
        Pixels and pairs whose curvature is compared: where any view is valid.
    curvature : CostTable
    outline : Outline
    weights : TermWeights
    whitening : LightWhitening
        Coordinates of the light.
    precision : (9 c, 9 c) array
        Inverse covariance of the light's Gaussian; its mean is that of `whitening`.
    depth : DepthTerm, optional
    scale : float
        Full-resolution pixels along one pixel here; curvature is compared in full resolution.
    """

    shape: tuple[int, int]
    views: tuple[View, ...]
    runs: Runs
    pairs: Runs
    curvature: CostTable
    outline: Outline
    weights: TermWeights
    whitening: LightWhitening
    precision: Float
    depth: DepthTerm | None = None
    scale: float = 1.0


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The loss at one point.

    Parameters
    ----------
    loss : float
    terms : dict of float
        Weighted; they sum to the loss.
    by_height : (h, w) array
        Overwritten by the next evaluation.
    by_lights : (v, 9 c) array
        By the white coordinates of each view's light.
    """

    loss: float
    terms: dict[str, float]
    by_height: Float
    by_lights: Float


class Objective:
    """The loss as a function; it holds the scratch arrays, so it serves one thread at a time.

    Cost and memory of an evaluation grow linearly with the pixels times the number of views.

    Parameters
    ----------
    problem : Problem
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        rows, columns = problem.shape
        self._padded = np.zeros((rows + 2, columns + 2))
        self._down, self._right = np.zeros((2, rows, columns))
        self._curvature, self._by_curvature = np.zeros((2, rows, columns))
        self._by_height = np.zeros((rows, columns))
        self._partials = np.zeros((5, rows, columns))
        self._gradients = np.zeros((5, rows + 4, columns + 4))
        self._lines = np.zeros((LINES, columns))
        self._buffers = tuple(ViewBuffers.of(view) for view in problem.views)

    def __call__(self, height: Float, lights: Float) -> Evaluation:
        """Return loss, terms and gradient.

        Parameters
        ----------
        height : (h, w) array
        lights : (v, 9 c) array
            White coordinates.
        """
        padded_height(height, self._padded)
        slopes_of(self._padded, self._down, self._right)
        self._gradients[:] = 0.0
        terms = {
            "curvature": self.curvature_term(),
            "slant": self.slant_term(),
            "contour": self.contour_term(),
        }
        by_lights = np.zeros_like(lights)
        terms |= self.view_terms(lights, by_lights)
        height_adjoint(self._gradients, self._by_height)
        if self.problem.depth is not None:
            terms["depth"] = self.problem.depth.add(height, self._by_height)
        return Evaluation(sum(terms.values()), terms, self._by_height, by_lights)

    def log_albedo(self, view: int) -> Float:
        """Return the log albedo (c, h, w) of a view at the last evaluation."""
        return self._buffers[view].albedo

    def slopes(self) -> tuple[Float, Float]:
        """Return dZ/drow and dZ/dcolumn at the last evaluation."""
        return self._down, self._right

    def curvature_term(self) -> float:
        """Return the smoothness of the shape, and add its gradient."""
        problem, table = self.problem, self.problem.curvature
        weight = problem.weights.curvature / (_WINDOW_AREA * self._down.size)
        if not weight:
            return 0.0
        curvature_of(
            self._padded, self._down, self._right, problem.runs, self._curvature, self._partials
        )
        self._by_curvature[:] = 0.0
        # Curvature is one over a length, so a pixel here measures `scale` times that of one there.
        scale = problem.scale
        summed = difference_loss(
            self._curvature,
            problem.pairs,
            table.values,
            table.spacing * scale,
            table.start * scale,
            CURVATURE_FLOOR * scale,
            self._by_curvature,
            self._lines,
        )
        curvature_adjoint(self._by_curvature, weight, problem.runs, self._partials, self._gradients)
        return weight * summed

    def slant_term(self) -> float:
        """Return the isotropy of the shape, and add its gradient."""
        weight = self.problem.weights.slant / self._down.size
        if not weight:
            return 0.0
        return weight * slant_loss(self._down, self._right, weight, self._gradients)

    def contour_term(self) -> float:
        """Return how far the outline's normals are from outward, and add its gradient."""
        problem, outline = self.problem, self.problem.outline
        weight = problem.weights.contour * _CONTOUR_SCALE / (self._down.size * problem.scale)
        if not weight:
            return 0.0
        return weight * contour_loss(
            self._down,
            self._right,
            outline.rows,
            outline.columns,
            outline.outward,
            problem.weights.contour_power,
            FLAT_ENDS,
            weight,
            self._gradients,
        )

    def view_terms(self, lights: Float, by_lights: Float) -> dict[str, float]:
        """Return the means over the views of what albedo and light cost, and add their gradients.

        Parameters
        ----------
        lights, by_lights : (v, 9 c) arrays
        """
        terms: dict[str, float] = {}
        for view, buffers, light, out in zip(
            self.problem.views, self._buffers, lights, by_lights, strict=True
        ):
            found = self._view_term(view, buffers, light, out)
            for name, value in found.items():
                terms[name] = terms.get(name, 0.0) + value
        return terms

    def _view_term(
        self, view: View, buffers: ViewBuffers, light: Float, out: Float
    ) -> dict[str, float]:
        problem = self.problem
        whitening = problem.whitening
        coefficients = whitening.inverse @ light + whitening.mean
        result = view_loss(
            view,
            buffers,
            self._down,
            self._right,
            coefficients.reshape(view.channels, 9),
            self._gradients,
        )
        away = coefficients - whitening.mean
        weight = problem.weights.light / (away.size * len(problem.views))
        pull = weight * (problem.precision @ away)
        out += whitening.inverse.T @ (result.by_light.ravel() + pull)
        return {**result.terms, "light": 0.5 * float(away @ pull)}
