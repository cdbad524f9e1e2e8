"""Table 1: re-rendering error of our object models (`tab:mse`, section `subsec:rerender_error`).

The protocol, with the choices the paper leaves open
----------------------------------------------------
Objects and settings
    All objects of a dataset, each photographed in the settings ``natural`` (shaded by a log-linear
    spherical-harmonic light, no cast shadows) and ``laboratory`` (a real photograph).
Lights
    Twenty draws without replacement from the pool of natural lights, the same for every object and
    every run (seeded by name), each the mean over its colour channels: monochrome, nine
    coefficients.
Target
    ``I = A* exp(B(N*) . L)`` with the true albedo and normals. The light multiplies all colours
    alike and the colour of the light in the source photograph is not the model's fault, so albedos
    are compared as the mean of their channels (``gray``); ``color`` compares all three.
Model
    Built from one photograph of the object in that setting with no knowledge of the truth. The
    coarse shading is ``shade(Z, L) = exp(B(N_Z) . L)``, in the dataset's own convention, with the
    normals of the contour shape's height (epsilon = 1, chosen on the ten training objects of
    MIT-Berkeley). Detail layers enter as they are (`eq:model`); the mean shading of every source
    photograph is one half.
Retinex thresholds
    On a measured set each object's thresholds are learned on the other objects of the same setting
    (`evaluation.retinex_thresholds`); elsewhere the shipped defaults are used.
Detail sources
    (a) ``default``: shading and albedo by colour Retinex. (c) ``gt-shading``: the true shading S*
    of the photograph, and the albedo I / S*. (b) ``sirfs-shading``: the shading S' of SIRFS (see
    below), which is coloured, and the albedo I / S'. Albedos are per channel; the shading that
    detail is derived from is the mean over the channels.
B + M
    SIRFS (`evaluation.sirfs`) fits shape, albedo and light to the same photograph in colour, by the
    light model of the setting's name (``laboratory`` where there is none of that name). Its entry
    is its own albedo under the new light on its own shape, ``A exp(B(N) . L)``, without detail
    layers or weights; in ``gray`` the albedo of the colour fit is averaged as any other. The
    contour that its shape bends away at is that of the object: the mask of the laboratory
    photograph where there is one, for a natural photograph of MIT-Berkeley is blank where the
    depth is not known. Pixels of the mask that are black in a channel are not explained by the fit
    and count as black. Its priors were trained on the ten training objects of MIT-Berkeley, their
    albedos and shapes, so its errors on those are optimistic, and so are those of (b): the same
    entries over the ten test objects stand beside (``test_rows``).
    A fit that fails leaves its cells missing. A quick run leaves out (b) and B + M, and lists them
    as open.
Weights
    ``oracle``: joint least squares over k, k w_p, k w_g for each cell. ``regression``: see
    `evaluation.weight_rules.regressed`; its training points always come from all other objects of
    the dataset, whichever are reported. ``default``: (1, 1). ``manual``: what the user gives, by
    default (0.5, 0.5). ``coarse``: (0, 0). B + M: ``none``.
Error
    ``IMSE' = min_k |I - k A S|^2 / n`` (`eq:MSEmetric`) over the n pixels of the mask whose true
    normal is known, k >= 0 for each cell; a table entry is the mean over its cells, and its
    relative error is that mean over the cells' mean of I^2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from datasets.records import Dataset
from evaluation.experiment import Experiment
from evaluation.grid_run import DEFAULT_OPTIONS, Progress, RunOptions, run_grid
from evaluation.grid_status import GridStatus
from evaluation.kept_models import KeptModels
from evaluation.model_parts import PAPER_PARTS, ModelParts
from evaluation.rerendering import monochrome_coefficients
from evaluation.row_store import MemoryRows, Rows
from evaluation.sirfs_fits import UNKEPT, SirfsFits
from evaluation.stored_cells import missing_reason
from evaluation.table1_grid import (
    NAME,
    VERSION,
    Table1Context,
    object_results,
    table1_experiment,
)
from evaluation.table1_record import MissingCell, Table1
from evaluation.weight_rules import MANUAL, WEIGHT_RULES, WeightRule
from shading_model.errors import unknown_name
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ModelParameters, Weights

PROTOCOL, PROTOCOL_VERSION = NAME, VERSION


def run_table1(
    dataset: Dataset,
    lights: Sequence[LogHarmonics],
    parameters: ModelParameters,
    *,
    objects: Sequence[str] = (),
    channels: str = "gray",
    manual: Weights = MANUAL,
    seed: str = "",
    parts: ModelParts = PAPER_PARTS,
    rules: Mapping[str, WeightRule] = WEIGHT_RULES,
    store: Rows | None = None,
    kept: KeptModels | None = None,
    quick: bool = False,
    fits: SirfsFits = UNKEPT,
    options: RunOptions = DEFAULT_OPTIONS,
    progress: Progress | None = None,
) -> Table1:
    """Measure Table 1 on a dataset; the protocol is in this module's docstring.

    Time grows with objects times settings; memory holds as many objects as there are workers. The
    numbers depend on neither workers nor store.

    Parameters
    ----------
    dataset : Dataset
    lights : sequence of LogHarmonics
        One colour each.
    parameters : ModelParameters
        Their Retinex thresholds are used where none were learned for the dataset.
    objects : sequence of str
        The objects to report; all of the dataset by default.
    channels : {"gray", "color"}
    manual : Weights
    seed : str
        Name that the lights were drawn by.
    parts : ModelParts
        Base shape and detail layer of one's own.
    rules : mapping of str to WeightRule
        The weight rules reported.
    store : Rows, optional
        Cells it holds are not measured again; without one, rows are kept in memory.
    kept : KeptModels, optional
        Where object models are kept; without it they are built for each run.
    quick : bool
        Leave out the entries that need SIRFS, some seconds for each object and setting.
    fits : SirfsFits
        Where fits of SIRFS are kept.
    options : RunOptions
        Workers, scheduler, cells to measure, time limit.
    progress : callable, optional

    Returns
    -------
    Table1

    Raises
    ------
    RelightlabError
        For unknown objects or axes, coloured lights, a store of another protocol version, or data
        that cannot be read.
    """
    for name in objects:
        if name not in dataset.objects:
            raise unknown_name("object", name, dataset.objects)
    coefficients = monochrome_coefficients(lights).T
    experiment = table1_experiment(
        Table1Context(
            *(dataset, tuple(lights), parameters, channels, parts, kept),
            fits=None if quick else fits,
        ),
        seed,
    )
    status = run_grid(experiment, store or MemoryRows(), options, progress)
    chosen = tuple(name for name in dataset.objects if not objects or name in objects)
    results = object_results(experiment, status)
    return Table1(
        dataset.name,
        chosen,
        channels,
        coefficients,
        results,
        manual,
        _missing(experiment, status),
        parts.method,
        rules,
    )


def _missing(experiment: Experiment, status: GridStatus) -> tuple[MissingCell, ...]:
    found = []
    for key in status.missing:
        reason = missing_reason(status.rows.get(key))
        found.append(MissingCell(dict(zip(experiment.axes, key, strict=True)), reason))
    return tuple(found)
