"""The experiments, by name: each a function from data and parameters to a grid of cells."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from datasets.records import Dataset
from evaluation.base_shape_grid import NAME as BASE_SHAPES
from evaluation.base_shape_grid import base_shape_experiment
from evaluation.base_shape_models import BaseShapeContext
from evaluation.experiment import Experiment
from evaluation.methods import MethodContext, method_experiment
from evaluation.part_registries import find_part
from evaluation.sirfs_fits import UNKEPT, SirfsFits
from evaluation.sirfs_grid import NAME as SIRFS
from evaluation.sirfs_grid import SirfsContext, sirfs_experiment
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
    quick: bool = False,
    fits: SirfsFits = UNKEPT,
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
    quick : bool
        Without the cells that need SIRFS.
    fits : SirfsFits
        Where fits of SIRFS are kept.

    Returns
    -------
    Experiment
    """
    context = Table1Context(
        *(dataset, tuple(lights), parameters, channels), fits=None if quick else fits
    )
    return table1_experiment(context, seed)


def paper_model_on(
    dataset: Dataset,
    lights: Sequence[LogHarmonics],
    parameters: ModelParameters,  # noqa: ARG001
    *,
    channels: str = "gray",
    seed: str = "",
) -> Experiment:
    """Return the paper's model measured as anybody's method is; `parameters` play no part.

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
    method = find_part("method", PAPER_MODEL)
    return method_experiment(MethodContext(dataset, tuple(lights), channels, method), seed)


def sirfs_on(
    dataset: Dataset,
    lights: Sequence[LogHarmonics],  # noqa: ARG001
    parameters: ModelParameters,  # noqa: ARG001
    *,
    channels: str = "gray",
    seed: str = "",
    fits: SirfsFits = UNKEPT,
) -> Experiment:
    """Return the fits of SIRFS and their errors; `lights` and `parameters` play no part.

    Parameters
    ----------
    dataset : Dataset
    lights : sequence of LogHarmonics
    parameters : ModelParameters
    channels : {"gray", "color"}
        That are fitted.
    seed : str
    fits : SirfsFits
        Where fits are kept, and which terms of the loss are left out.

    Returns
    -------
    Experiment
    """
    return sirfs_experiment(SirfsContext(dataset, fits), channels=[channels], seed=seed)


def base_shapes_on(
    dataset: Dataset,
    lights: Sequence[LogHarmonics],  # noqa: ARG001
    parameters: ModelParameters,
    *,
    channels: str = "gray",
    seed: str = "",
    fits: SirfsFits = UNKEPT,
) -> Experiment:
    """Return the study of base shapes; `lights` play no part: the photographs have their own.

    Parameters
    ----------
    dataset : Dataset
        With photographs under known lights.
    lights : sequence of LogHarmonics
    parameters : ModelParameters
    channels : {"gray", "color"}
    seed : str
    fits : SirfsFits
        Where fits of SIRFS are kept.

    Returns
    -------
    Experiment
    """
    return base_shape_experiment(BaseShapeContext(dataset, parameters, channels, fits), seed=seed)


PAPER_MODEL = "paper-model"
EXPERIMENTS: dict[str, Callable[..., Experiment]] = {
    NAME: table1_on,
    f"{NAME} method {PAPER_MODEL}": paper_model_on,
    SIRFS: sirfs_on,
    BASE_SHAPES: base_shapes_on,
}
"""Called with a dataset, its lights and parameters; the contract tests run on each."""
