"""What measured rows depend on, as hashes: data, lights, parameters, code."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from datasets.records import Dataset
from evaluation.code_version import code_hash
from evaluation.retinex_thresholds import shipped_table
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ModelParameters


def shared_inputs(
    dataset: Dataset, lights: Sequence[LogHarmonics], channels: str
) -> dict[str, str]:
    """Return the inputs that every row depends on, whatever the method.

    Parameters
    ----------
    dataset : Dataset
    lights : sequence of LogHarmonics
    channels : str

    Returns
    -------
    dict of str
    """
    return {
        "dataset": dataset.name,
        "data": dataset.fingerprint(),
        "lights": _hash(*(light.coefficients for light in lights)),
        "channels": channels,
        "code": code_hash(),
    }


def parameters_hash(parameters: ModelParameters) -> str:
    """Return a hash of the parameters of the paper's model and of the shipped thresholds.

    Parameters
    ----------
    parameters : ModelParameters

    Returns
    -------
    str
    """
    numbers: list[Any] = [
        parameters.thresholds.gray,
        parameters.thresholds.chromaticity,
        parameters.slope_limit,
        parameters.sparsity,
    ]
    learned = hashlib.sha256(repr(shipped_table()["settings"]).encode()).hexdigest()
    return _hash(parameters.dictionary.atoms, np.array(numbers)) + "-" + learned[:16]


def _hash(*arrays: Any) -> str:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(str(np.shape(array)).encode())
        digest.update(np.ascontiguousarray(array, dtype=np.float64).tobytes())
    return digest.hexdigest()
