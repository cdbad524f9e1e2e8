"""One photograph in the loss: what its log albedo costs, given slopes and light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from evaluation.sirfs.albedo_kernels import add_mixed_channels, mixed_channels
from evaluation.sirfs.entropy import HistogramCost, Places
from evaluation.sirfs.pair_kernels import LINES, color_difference_loss, difference_loss
from evaluation.sirfs.priors import SirfsPriors
from evaluation.sirfs.regions import Runs, pair_runs, runs_of
from evaluation.sirfs.scale_mixture import CostTable
from evaluation.sirfs.settings import TermWeights
from evaluation.sirfs.shading_kernels import log_albedo, log_albedo_adjoint
from shading_model.arrays import Float, Image, Mask

_SMALLEST_DIFFERENCE = 1e-9
"""Keeps the slope of a gray difference defined at zero, where its cost is flat."""
_COLOR_FLOOR = 1e-4
_PAIR_SCALE = 3.0 / 25.0


@dataclass(frozen=True, eq=False)
class View:
    """A photograph, ready for the loss.

    Parameters
    ----------
    log_image : (c, h, w) array
        Log intensities; zero where not valid.
    valid : (h, w) bool array
    runs, pairs : int arrays
        See `evaluation.sirfs.regions`.
    differences : CostTable
        Of log albedo between neighbours.
    white, whitening : (3, 3) arrays, optional
        In colour: what differences, and values, are multiplied by.
    histogram : HistogramCost
    smoothness : float
        Weight of the differences.
    """

    log_image: Float
    valid: Mask
    runs: Runs
    pairs: Runs
    differences: CostTable
    histogram: HistogramCost
    smoothness: float
    white: Float | None = None
    whitening: Float | None = None

    @property
    def channels(self) -> int:
        """Number of channels, 1 or 3."""
        return len(self.log_image)


@dataclass(frozen=True, eq=False)
class ViewGradient:
    """What a view costs, and how the cost changes with slopes and light.

    Parameters
    ----------
    terms : dict of float
        Weighted.
    by_light : (c, 9) array
    """

    terms: dict[str, float]
    by_light: Float


def view_of(
    image: Image, valid: Mask, priors: SirfsPriors, weights: TermWeights, share: float = 1.0
) -> View:
    """Return a photograph ready for the loss.

    Parameters
    ----------
    image : (h, w, 1) or (h, w, 3) array
        Linear intensities, above zero where valid.
    valid : (h, w) bool array
    priors : SirfsPriors
    weights : TermWeights
    share : float
        Of the view in the mean over views.

    Returns
    -------
    View
    """
    planes = np.ascontiguousarray(np.moveaxis(image, -1, 0), dtype=np.float64)
    log_image = np.log(planes, out=np.zeros_like(planes), where=valid & (planes > 0))
    gray = len(planes) == 1
    mixture = priors.gray_difference if gray else priors.color_difference
    absolute = priors.gray_absolute if gray else priors.color_absolute
    histogram = HistogramCost(
        absolute,
        weights.entropy_width / 20.0,
        share * weights.albedo_entropy,
        share * weights.albedo_absolute,
        int(valid.sum()),
    )
    return View(
        log_image,
        valid,
        runs_of(valid),
        pair_runs(valid),
        mixture.cost_table(),
        histogram,
        share * weights.albedo_smoothness * _PAIR_SCALE / planes.size,
        None if gray else mixture.precision_root,
        None if gray else priors.color_whitening,
    )


@dataclass(frozen=True, eq=False)
class ViewBuffers:
    """Scratch arrays of a view's size, so that an evaluation allocates next to nothing."""

    albedo: Float
    mixed: Float
    by_mixed: Float
    by_albedo: Float
    lines: Float
    places: Places

    @classmethod
    def of(cls, view: View) -> ViewBuffers:
        """Return buffers for a view."""
        shape = view.log_image.shape
        pixels = int(view.valid.sum()) if view.channels == 3 else 0
        return cls(
            albedo=np.zeros(shape),
            mixed=np.zeros(shape),
            by_mixed=np.zeros(shape),
            by_albedo=np.zeros(shape),
            lines=np.zeros((LINES, shape[-1])),
            places=Places.of(pixels),
        )


def view_loss(
    view: View, buffers: ViewBuffers, down: Float, right: Float, light: Float, gradients: Float
) -> ViewGradient:
    """Return what a view costs, and add to the gradient by slopes.

    Parameters
    ----------
    view : View
    buffers : ViewBuffers
        Afterwards `albedo` holds the log albedo.
    down, right : (h, w) arrays
        Slopes.
    light : (c, 9) array
    gradients : (5, h + 4, w + 4) array
        See `evaluation.sirfs.height_kernels`.

    Returns
    -------
    ViewGradient
    """
    log_albedo(down, right, view.runs, light, view.log_image, buffers.albedo)
    buffers.by_albedo[:] = 0.0
    terms = _gray_terms(view, buffers) if view.channels == 1 else _color_terms(view, buffers)
    by_light = np.zeros_like(light)
    log_albedo_adjoint(down, right, view.runs, light, buffers.by_albedo, gradients, by_light)
    return ViewGradient(terms, by_light)


def _gray_terms(view: View, buffers: ViewBuffers) -> dict[str, float]:
    table, gradient = view.differences, buffers.by_albedo[0]
    summed = 0.0
    if view.smoothness:
        summed = difference_loss(
            buffers.albedo[0],
            view.pairs,
            table.values,
            table.spacing,
            table.start,
            _SMALLEST_DIFFERENCE,
            gradient,
            buffers.lines,
        )
        gradient *= view.smoothness
    entropy, absolute = view.histogram.gray(buffers.albedo[0], view.runs, gradient)
    return _terms(view, summed, entropy, absolute)


def _color_terms(view: View, buffers: ViewBuffers) -> dict[str, float]:
    if view.white is None or view.whitening is None:
        raise ValueError("a view in colour needs its two whitening matrices")
    table, mixed, by_mixed, runs = view.differences, buffers.mixed, buffers.by_mixed, view.runs
    summed = 0.0
    if view.smoothness:
        mixed_channels(buffers.albedo, view.white, runs, mixed)
        by_mixed[:] = 0.0
        summed = color_difference_loss(
            mixed, view.pairs, table.values, table.spacing, _COLOR_FLOOR, by_mixed, buffers.lines
        )
        back = np.ascontiguousarray(view.white.T)
        add_mixed_channels(by_mixed, back, view.smoothness, runs, buffers.by_albedo)
    mixed_channels(buffers.albedo, view.whitening, runs, mixed)
    entropy, absolute = view.histogram.color(mixed, runs, buffers.places, by_mixed)
    back = np.ascontiguousarray(view.whitening.T)
    add_mixed_channels(by_mixed, back, 1.0, runs, buffers.by_albedo)
    return _terms(view, summed, entropy, absolute)


def _terms(view: View, summed: float, entropy: float, absolute: float) -> dict[str, float]:
    return {
        "albedo_smoothness": view.smoothness * summed,
        "albedo_entropy": entropy,
        "albedo_absolute": absolute,
    }
