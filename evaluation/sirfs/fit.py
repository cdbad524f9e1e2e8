"""Fitting SIRFS to a photograph, or to several of one object under different lights.

The loss has many minima, and which is found depends on the path. So fits start, as the original's,
from a flat shape at full resolution. Descending at a quarter and a half of the resolution first
(`QUICK_EVALUATIONS`) comes to a like loss in a third of the time, but to errors that differ more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from evaluation.sirfs.descent import Descent, Fixed, Unknowns, descend
from evaluation.sirfs.framing import Frame, checked_photograph, frame_around
from evaluation.sirfs.objective import Problem
from evaluation.sirfs.priors import SirfsPriors
from evaluation.sirfs.problem import Observation, doubled_height, problem_of
from evaluation.sirfs.result import SirfsFit
from evaluation.sirfs.settings import TermWeights, term_weights
from shading_model.arrays import Float, Image, Map, Mask, check_map
from shading_model.errors import RelightlabError
from shading_model.height_field import normals_of_slopes, slopes
from shading_model.illumination import LogHarmonics

EVALUATIONS = (1000,)
"""At most so many, at full resolution: as the original does it, from a flat shape."""
QUICK_EVALUATIONS = (300, 200, 250)
"""At a quarter, at half and at full resolution: a third of the work, often to another minimum."""
SMALLEST_SIDE = 32
"""The shorter side of a reduced rectangle has at least so many pixels."""

FitProgress = Callable[[float, float, float], None]
"""Called with evaluations done, evaluations at most (in full resolutions), and the loss."""


@dataclass(frozen=True, eq=False)
class FitOptions:
    """How a photograph is fitted.

    Parameters
    ----------
    light : {"laboratory", "natural"}
        Which lights are likely.
    channels : {"color", "gray"}
    without : tuple of str
        Terms of `evaluation.sirfs.settings.TERMS` that are left out.
    known_height : (h, w) array, optional
        The shape, if it is known: only the light is fitted. NaN is taken as the least height.
    known_light : LogHarmonics, optional
        The light, if it is known: only the shape is fitted.
    depth : (h, w) array, optional
        An external depth map in pixels, NaN where unknown, that the shape is drawn to.
    depth_blur : float
        Width in pixels of the blur that relates the shape to `depth`.
    evaluations : tuple of int
        At most so many at each resolution, each twice the one before; the last is full resolution.
    """

    light: str = "laboratory"
    channels: str = "color"
    without: tuple[str, ...] = ()
    known_height: Map | None = None
    known_light: LogHarmonics | None = None
    depth: Float | None = None
    depth_blur: float = 0.0
    evaluations: tuple[int, ...] = EVALUATIONS


def fit_sirfs(
    image: Image,
    mask: Mask,
    priors: SirfsPriors,
    options: FitOptions = FitOptions(),
    *,
    outline: Mask | None = None,
    progress: FitProgress | None = None,
) -> SirfsFit:
    """Fit shape, albedo, shading and light to one photograph.

    Time and memory grow linearly with the pixels of the rectangle around the object. The same
    inputs give the same bytes.

    Parameters
    ----------
    image : (h, w, 3) array
        Linear intensities; pixels outside the mask play no part.
    mask : (h, w) bool array
    priors : SirfsPriors
    options : FitOptions
    outline : (h, w) bool array, optional
        The object's silhouette, where `mask` is less than it; its border is taken for an occluding
        contour. By default the mask.
    progress : callable, optional

    Returns
    -------
    SirfsFit

    Raises
    ------
    RelightlabError
        For unknown names in the options, sizes that differ, NaN or negative or too few pixels, or a
        loss that is not finite.
    """
    return fit_sirfs_stereo((image,), mask, priors, options, outline=outline, progress=progress)[0]


def fit_sirfs_stereo(
    images: Sequence[Image],
    mask: Mask,
    priors: SirfsPriors,
    options: FitOptions = FitOptions(),
    *,
    outline: Mask | None = None,
    progress: FitProgress | None = None,
) -> tuple[SirfsFit, ...]:
    """Fit one shape, and an albedo and light for each, to photographs under different lights.

    Parameters
    ----------
    images : sequence of (h, w, 3) arrays
        Taken from one place, under lights that need not be known.
    mask, priors, options, outline, progress
        As for `fit_sirfs`.

    Returns
    -------
    tuple of SirfsFit
        One for each photograph; all have the same height and normals.

    Raises
    ------
    RelightlabError
        As `fit_sirfs`, or if there is no photograph.
    """
    weights = term_weights(options.light, options.channels, options.without)
    if not images:
        raise RelightlabError("expected at least one photograph to fit, got none")
    frame, seen = _observation(images, mask, outline, options)
    start = _start(seen, priors, options, frame)
    descent, evaluations = _coarse_to_fine(seen, start, priors, weights, options, progress)
    if not math.isfinite(descent.evaluation.loss):
        raise RelightlabError(f"the fit diverged: its loss is {descent.evaluation.loss}")
    problem = problem_of(seen, priors, weights, options.light, options.channels)
    return tuple(_result(descent, problem, view, frame, evaluations) for view in range(len(images)))


def _observation(
    images: Sequence[Image], mask: Mask, outline: Mask | None, options: FitOptions
) -> tuple[Frame, Observation]:
    checked = [checked_photograph(image, mask, options.channels) for image in images]
    inside = np.asarray(mask, dtype=bool)
    silhouette = inside if outline is None else inside | np.asarray(outline, dtype=bool)
    frame = frame_around(silhouette)
    depth = options.depth
    if depth is not None:
        depth = frame.cut(check_map(depth, np.ones_like(inside), "depths"))
    seen = Observation(
        tuple(frame.cut(image) for image, _ in checked),
        tuple(frame.cut(valid) for _, valid in checked),
        frame.cut(silhouette),
        depth,
        options.depth_blur,
    )
    return frame, seen


def _start(seen: Observation, priors: SirfsPriors, options: FitOptions, frame: Frame) -> Unknowns:
    """Return a flat shape under a light that shades nothing, or what is known."""
    problem_light = priors.lights[options.light, options.channels]
    channels = problem_light.mean.size // 9
    height = np.zeros(seen.shape)
    if options.known_height is not None:
        known = frame.cut(np.asarray(options.known_height, dtype=np.float64))
        if known.shape != seen.shape:
            raise RelightlabError("expected a known height of the photograph's size")
        height = np.where(np.isfinite(known), known, np.nanmin(known))
    coefficients = np.zeros(problem_light.mean.size)
    if options.known_light is not None:
        given = options.known_light.coefficients
        columns = given if given.ndim == 2 else np.repeat(given[:, None], channels, axis=1)
        if channels == 1:
            columns = columns.mean(axis=1, keepdims=True)
        coefficients = np.ascontiguousarray(columns.T).ravel()
    return Unknowns(height, np.tile(coefficients, (len(seen.images), 1)))


def _coarse_to_fine(
    seen: Observation,
    start: Unknowns,
    priors: SirfsPriors,
    weights: TermWeights,
    options: FitOptions,
    progress: FitProgress | None,
) -> tuple[Descent, float]:
    """Minimise the loss at rising resolutions; return the last descent, and the work done."""
    fixed = Fixed(options.known_height is not None, options.known_light is not None)
    stages = _stages(seen, () if fixed.height else options.evaluations[:-1])
    limits = options.evaluations[-len(stages) :]
    most = sum(n / stage.scale**2 for n, stage in zip(limits, stages, strict=True))
    unknowns, done, descent = None, 0.0, None
    for stage, limit in zip(stages, limits, strict=True):
        problem = problem_of(stage, priors, weights, options.light, options.channels)
        if unknowns is None:
            unknowns = _at_scale(start, stage, problem)
        else:
            unknowns = Unknowns(doubled_height(unknowns.height, stage.shape), unknowns.lights)
        share, before = stage.scale**-2, done

        def watch(count: int, loss: float, share: float = share, before: float = before) -> None:
            if progress is not None:
                progress(before + share * count, most, loss)

        descent = descend(problem, unknowns, most_evaluations=limit, fixed=fixed, watch=watch)
        unknowns = descent.unknowns
        done += share * descent.evaluations
    if descent is None:
        raise RelightlabError("expected at least one stage of evaluations, got none")
    return descent, done


def _stages(seen: Observation, reduced: Sequence[int]) -> list[Observation]:
    """Return the observation at rising resolutions, as many reduced ones as make sense."""
    stages = [seen]
    for _ in reduced:
        if min(stages[0].shape) < 2 * SMALLEST_SIDE:
            break
        half = stages[0].halved()
        if not all(valid.sum() > SMALLEST_SIDE for valid in half.valid):
            break
        stages.insert(0, half)
    return stages


def _at_scale(start: Unknowns, stage: Observation, problem: Problem) -> Unknowns:
    away = start.lights - problem.whitening.mean
    lights: Float = np.asarray(np.linalg.solve(problem.whitening.inverse, away.T).T, np.float64)
    if start.height.shape == stage.shape:
        return Unknowns(start.height, lights)
    return Unknowns(np.zeros(stage.shape), lights)


def _result(
    descent: Descent, problem: Problem, view: int, frame: Frame, evaluations: float
) -> SirfsFit:
    seen = problem.views[view]
    valid = seen.valid
    inside = frame.pasted(valid.astype(np.float64)) == 1.0
    anywhere = np.any(np.stack([each.valid for each in problem.views]), axis=0)
    right, up = slopes(descent.unknowns.height)
    log_albedo = np.moveaxis(descent.log_albedo[view], 0, -1)
    log_image = np.moveaxis(seen.log_image, 0, -1)
    light = problem.whitening.inverse @ descent.unknowns.lights[view] + problem.whitening.mean
    coefficients = light.reshape(seen.channels, 9).T

    def placed(values: Float, where: Mask) -> Float:
        known = where if values.ndim == 2 else where[..., None]
        return frame.pasted(np.where(known, values, np.nan))

    return SirfsFit(
        mask=inside,
        height=placed(descent.unknowns.height, anywhere),
        normals=placed(normals_of_slopes(right, up), anywhere),
        albedo=placed(np.exp(log_albedo), valid),
        shading=placed(np.exp(log_image - log_albedo), valid),
        illumination=LogHarmonics(coefficients if seen.channels == 3 else coefficients[:, 0]),
        final_loss=descent.evaluation.loss,
        terms=descent.evaluation.terms,
        evaluations=evaluations,
        stopped=descent.stopped,
    )
