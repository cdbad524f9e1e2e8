"""The parameters models are built with unless the user chooses others: what the project ships."""

from __future__ import annotations

from datasets.shading_dictionary import shipped_dictionary
from shading_model.object_model import ModelParameters


def shipped_parameters() -> ModelParameters:
    """Return the shipped dictionary with the default thresholds and limits.

    Raises
    ------
    RelightlabError
        If the shipped dictionary is missing or damaged.

    Examples
    --------
    >>> shipped_parameters().thresholds
    RetinexThresholds(gray=1.4, chromaticity=0.065)
    """
    return ModelParameters(shipped_dictionary())
