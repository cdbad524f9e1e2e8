"""Learning the priors of SIRFS from the training objects and lights of the MIT-Berkeley set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from datasets.mit_berkeley import MitBerkeley
from evaluation.sirfs.absolute_albedo import fit_gray_absolute
from evaluation.sirfs.absolute_color import color_whitening, fit_color_absolute
from evaluation.sirfs.light_training import light_priors
from evaluation.sirfs.prior_files import rounded_priors
from evaluation.sirfs.priors import MIXTURES, SirfsPriors
from evaluation.sirfs.scale_mixture import fit_scale_mixture
from evaluation.sirfs.training_data import TrainingSamples, training_samples
from shading_model.arrays import Float

STEPS = 5
"""How often `train_priors` reports."""

Report = Callable[[int, int, str], None]


def train_priors(root: Path, report: Report = lambda *_: None) -> SirfsPriors:
    """Return the priors learned from the set, rounded as a file holds them.

    Only its ten training objects, the lights fitted to them and the measured environments play a
    part; no photograph does.

    Parameters
    ----------
    root : Path
        The folder of the MIT-Berkeley set.
    report : callable
        Called with how much is done, how much there is in all, and what was done last.

    Returns
    -------
    SirfsPriors

    Raises
    ------
    RelightlabError
        If a file of the set is missing or damaged.

    Examples
    --------
    >>> train_priors(Path("nowhere"))
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: no such file: ...
    """
    root = Path(root)
    lights = light_priors(root)
    report(1, STEPS, "lights")
    samples = training_samples(MitBerkeley(root))
    report(2, STEPS, "samples")
    mixtures = {
        name: fit_scale_mixture(
            pooled(samples, f"{name}_differences" if name == "curvature" else f"{name}s")
        )
        for name in MIXTURES
    }
    report(3, STEPS, "differences")
    gray_absolute = fit_gray_absolute(pooled(samples, "gray"))
    report(4, STEPS, "gray albedo")
    color = pooled(samples, "color")
    whitening = color_whitening(color)
    color_absolute = fit_color_absolute(color @ whitening)
    report(5, STEPS, "colour of albedo")
    learned = SirfsPriors(
        **mixtures,
        gray_absolute=gray_absolute,
        color_whitening=whitening,
        color_absolute=color_absolute,
        lights=lights,
    )
    return rounded_priors(learned)


def pooled(samples: Sequence[TrainingSamples], field: str) -> Float:
    """Return one kind of samples of all objects together.

    Parameters
    ----------
    samples : sequence of TrainingSamples
    field : str
        Of `TrainingSamples`.

    Returns
    -------
    (n,) or (n, 3) array

    Examples
    --------
    >>> numbers, colors = np.zeros(2), np.zeros((2, 3))
    >>> one = TrainingSamples(numbers, numbers, colors, numbers, colors)
    >>> pooled([one, one], "color").shape
    (4, 3)
    """
    return np.concatenate([getattr(sample, field) for sample in samples])
