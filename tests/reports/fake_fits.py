"""Fits of SIRFS that cost nothing, for tests of the report: the truth, or none at all."""

from __future__ import annotations

import numpy as np

from datasets.records import Capture, Dataset
from evaluation.sirfs.result import SirfsFit
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics


def true_fit(capture: Capture, channels: int = 3) -> SirfsFit:
    """Return the truth of a photograph in the form of a fit, in colour or gray."""
    truth, mask = capture.truth, capture.photograph.mask
    assert truth.height is not None
    assert truth.normals is not None
    assert truth.albedo is not None
    assert truth.shading is not None
    light = truth.illumination or LogHarmonics(np.zeros((9, 3)))
    gray = channels == 1
    albedo, shading = (
        values.mean(axis=-1, keepdims=True) if gray else values
        for values in (truth.albedo, truth.shading)
    )
    return SirfsFit(
        mask=mask,
        height=truth.height,
        normals=truth.normals,
        albedo=albedo,
        shading=shading,
        illumination=light.monochrome() if gray else light,
        final_loss=1.0,
        terms={"light": 1.0},
        evaluations=1.0,
        stopped="it is the truth",
    )


class TruthFits:
    """Fits that are the truth."""

    def fit(self, dataset: Dataset, name: str, setting: str) -> SirfsFit:
        """Return the truth of an object in one setting."""
        return true_fit(dataset.load(name, setting))


class FailingFits:
    """Fits that diverge."""

    def fit(self, dataset: Dataset, name: str, setting: str) -> SirfsFit:
        """Fail as a fit that diverges does."""
        raise RelightlabError(f"the fit to {name} of {dataset.name}, {setting}, diverged")
