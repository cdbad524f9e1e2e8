"""What the regression gate measures of SIRFS: a few fits, what they are worth, and their errors.

A fit is cut off after some hundred evaluations of a loss with many valleys, so it ends elsewhere
when a single bit of the photograph changes. Of seven fits to the objects chosen here, under noise
of 1e-15, errors differed by up to a tenth and losses by up to 0.004; on others, a natural light may
send them into another valley, with errors three times as large. On one platform a fit is the same
to the bit.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from datasets.model_parameters import shipped_parameters
from datasets.records import Dataset
from evaluation.grid_run import Progress, RunOptions
from evaluation.sirfs.metrics import ERROR_NAMES
from evaluation.sirfs_fits import SirfsFits
from evaluation.sirfs_grid import SirfsContext, SirfsTable, run_sirfs
from evaluation.sirfs_measurement import RIVAL, SIRFS_SHADING, SIRFS_SOURCES
from evaluation.table1 import run_table1
from evaluation.table1_record import Table1
from evaluation.weight_rules import WEIGHT_RULES
from shading_model.illumination import LogHarmonics

RULES = tuple(rule for rule in WEIGHT_RULES if rule != "regression")
"""The rules that an object's own cells decide; a regression would need more objects."""
FIGURES = (*ERROR_NAMES, "mean", "final_loss")

Measured = Iterator[tuple[str, Sequence[float]]]


@dataclass(frozen=True, eq=False)
class GateFits:
    """What was measured of the fits.

    Parameters
    ----------
    errors : dict of sequences of float
        By ``setting object sirfs-shading rule`` and ``setting object sirfs none``, one number for
        each light; and by ``setting object sirfs figure``, one number.
    reasons : tuple of str
        Why fits could not be made; their numbers are NaN.
    """

    errors: dict[str, Sequence[float]]
    reasons: tuple[str, ...]


def fitted_variants() -> tuple[str, ...]:
    """Return the words that follow setting and object in the name of a number of SIRFS.

    Returns
    -------
    tuple of str

    Examples
    --------
    >>> len(fitted_variants()), fitted_variants()[-1]
    (13, 'sirfs final_loss')
    """
    detailed = (f"{SIRFS_SHADING} {rule}" for rule in RULES)
    return (*detailed, f"{RIVAL} none", *(f"{RIVAL} {figure}" for figure in FIGURES))


def measure_fits(
    dataset: Dataset,
    lights: Sequence[LogHarmonics],
    options: RunOptions,
    progress: Progress | None = None,
) -> GateFits:
    """Fit all objects of a dataset in all settings, in colour, and measure the fits.

    Parameters
    ----------
    dataset : Dataset
    lights : sequence of LogHarmonics
    options : RunOptions
    progress : callable, optional

    Returns
    -------
    GateFits
    """
    only = {"detail_source": list(SIRFS_SOURCES)}
    with tempfile.TemporaryDirectory() as folder:
        fits = SirfsFits(Path(folder))
        table = run_table1(
            *(dataset, lights, shipped_parameters()),
            fits=fits,
            options=replace(options, only=only),
            progress=progress,
        )
        context = SirfsContext(dataset, fits)
        figures = run_sirfs(context, channels=["color"], options=options)
    reasons = [m.reason for m in table.missing if m.cell["detail_source"] in SIRFS_SOURCES]
    errors = {**dict(_rerendering(table)), **dict(_figures(dataset, figures))}
    return GateFits(errors, tuple(dict.fromkeys(reasons)))


def _rerendering(table: Table1) -> Measured:
    for setting in table.settings():
        variants = [(f"{SIRFS_SHADING} {rule}", SIRFS_SHADING, rule) for rule in RULES]
        for words, source, rule in (*variants, (f"{RIVAL} none", RIVAL, "coarse")):
            rows = table.errors(setting, source, rule)
            for name, row in zip(table.objects, rows, strict=True):
                yield f"{setting} {name} {words}", row.tolist()


def _figures(dataset: Dataset, table: SirfsTable) -> Measured:
    found = {(row["setting"], row["object"]): row for row in table.rows}
    for setting in dataset.settings:
        for name in dataset.objects:
            row = found.get((setting, name), {})
            for figure in FIGURES:
                value = row.get(figure)
                key = f"{setting} {name} {RIVAL} {figure}"
                yield key, (float("nan") if value is None else value,)
