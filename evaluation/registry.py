"""The experiments, by name: each a function from data and parameters to a grid of cells."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from datasets.records import Dataset
from evaluation.experiment import Experiment
from evaluation.table1_grid import NAME, Table1Context, table1_experiment
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ModelParameters


def table1_on(
    dataset: Dataset,
    lights: Sequence[LogHarmonics],
    parameters: ModelParameters,
    *,
    channels: str = "gray",
    seed: str = "",
) -> Experiment:
    """Return Table 1 on a dataset under these lights.

    Parameters
    ----------
    dataset : Dataset
    lights : sequence of LogHarmonics
    parameters : ModelParameters
    channels : {"gray", "color"}
    seed : str
        Name that the lights were drawn by.

    Returns
    -------
    Experiment
    """
    return table1_experiment(Table1Context(dataset, tuple(lights), parameters, channels), seed)


EXPERIMENTS: dict[str, Callable[..., Experiment]] = {NAME: table1_on}
"""Called with a dataset, its lights and parameters; the contract tests run on each."""
