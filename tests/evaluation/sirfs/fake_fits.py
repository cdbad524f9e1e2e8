"""Fits that cost nothing: a flat shape whose shading is the photograph without its colour."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from evaluation import base_shape_grid, sirfs_fits, sirfs_grid, table1_grid
from evaluation.sirfs.fit import FitOptions
from evaluation.sirfs.result import SirfsFit
from shading_model.arrays import Float, Image, Mask
from shading_model.errors import RelightlabError
from shading_model.illumination import C4, LogHarmonics

Fit = Callable[..., SirfsFit]


def flat_fit(image: Image, mask: Mask, priors: Any, options: FitOptions, **_: Any) -> SirfsFit:
    """Return a fit of the right form: facing the viewer, shaded by the mean of the channels."""
    explained = mask & (image > 0).all(axis=-1)
    channels = 3 if options.channels == "color" else 1
    seen = image if channels == 3 else image.mean(axis=-1, keepdims=True)
    gray = np.where(explained, image.mean(axis=-1), np.nan)[..., None]
    shading: Float = np.repeat(gray, channels, axis=-1)
    coefficients = np.zeros((9, 3) if channels == 3 else 9)
    coefficients[0] = np.log(np.nanmean(gray)) / C4
    return SirfsFit(
        mask=explained,
        height=np.where(explained, 0.0, np.nan),
        normals=np.where(explained[..., None], [0.0, 0.0, 1.0], np.nan),
        albedo=np.where(explained[..., None], seen, np.nan) / shading,
        shading=shading,
        illumination=LogHarmonics(coefficients),
        final_loss=float(priors) + len(options.without),
        terms={"curvature": 0.25, "light": 0.75},
        evaluations=12.25,
        stopped="the fit is a fake",
    )


def diverging_fit(*_: Any, **__: Any) -> SirfsFit:
    """Fail as a fit that diverges does."""
    raise RelightlabError("the fit diverged: its loss is not finite")


def pretend(patch: pytest.MonkeyPatch, fit: Fit = flat_fit, priors: str = "no priors") -> None:
    """Let everything that uses SIRFS in this process use a fake instead."""

    def fits(images: Sequence[Image], *given: Any, **named: Any) -> tuple[SirfsFit, ...]:
        return tuple(fit(image, *given, **named) for image in images)

    patch.setattr(sirfs_fits, "fit_sirfs_stereo", fits)
    for module in (sirfs_fits, sirfs_grid, table1_grid, base_shape_grid):
        patch.setattr(module, "priors_in_use", lambda: (1.5, priors))
