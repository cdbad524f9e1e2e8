"""What the regression gate measures: small sets, the same on every machine, and their errors.

The synthetic set is made on the spot, all objects in both settings at a small size; of MIT-Berkeley
a few objects are taken, with the learned thresholds of the whole set. Both are relit under the
first lights of Table 1, by every detail source and weight rule; models on the base shapes of Table
2 are compared with the sets' photographs; SIRFS is fitted to fewer objects.
"""

from __future__ import annotations

import math
import platform
from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_info

from datasets.illumination_pools import TABLE1_SEED, table1_lights
from datasets.mit_berkeley import MitBerkeley
from datasets.model_parameters import shipped_parameters
from datasets.records import Dataset
from datasets.synthetic import DEFAULT_SEED, synthesize
from datasets.synthetic_manifest import parameters_of
from evaluation.code_version import NUMERIC_PACKAGES
from evaluation.gate_base_shapes import measure_shapes
from evaluation.gate_sirfs import measure_fits
from evaluation.grid_run import Progress, RunOptions
from evaluation.object_sets import ChosenObjects
from evaluation.provenance import code_commit
from evaluation.table1 import PROTOCOL, PROTOCOL_VERSION, run_table1
from evaluation.table1_grid import BASELINE, QUICK_SOURCES
from evaluation.table1_record import Table1
from evaluation.weight_rules import WEIGHT_RULES
from shading_model.errors import unknown_name
from shading_model.illumination import LogHarmonics

SETS = ("synthetic", "mit-berkeley")
SYNTHETIC_SIZE, SYNTHETIC_SAMPLES = 96, 4
SYNTHETIC_OBJECTS: tuple[str, ...] | None = None
"""All that there are."""
MIT_OBJECTS = ("cup1", "pear", "raccoon", "sun")
FITTED = {"synthetic": ("folded_paper", "crumpled_paper", "medal"), "mit-berkeley": ("pear",)}
"""The objects that SIRFS is fitted to, in every setting: those whose fits wander least."""
LIGHTS = 4
DIGITS = 8
"""Significant digits that an error is kept with."""
INTRINSIC = ("lmse", "point_light_residual", "harmonic_residual")

Errors = dict[str, tuple[float | None, ...]]
"""Errors by ``setting object source rule`` or ``setting object residual``, or as in
`evaluation.gate_base_shapes` and `evaluation.gate_sirfs`; None: not measured."""


@dataclass(frozen=True, eq=False)
class GateSet:
    """What the gate measures of one dataset.

    Parameters
    ----------
    dataset : Dataset
    lights : tuple of LogHarmonics
    content : str
        What the numbers depend on, alike on every machine: how the set was made, or its hash.
    fitted : tuple of str
        The objects that SIRFS is fitted to.
    """

    dataset: Dataset
    lights: tuple[LogHarmonics, ...]
    content: str
    fitted: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class GateMeasurement:
    """The errors of one dataset, and what they were measured by.

    Parameters
    ----------
    dataset, protocol, content, commit : str
    fingerprint : str
        Of the set's files; those of a set made on the spot may differ between machines.
    platform : dict of str
        What the last digits of a number may depend on.
    errors : Errors
    reasons : tuple of str
        Why cells could not be measured; not kept in a record, which has all cells.
    """

    dataset: str
    protocol: str
    content: str
    fingerprint: str
    commit: str
    platform: dict[str, str]
    errors: Errors
    reasons: tuple[str, ...] = field(default=())

    @property
    def size(self) -> int:
        """Number of errors."""
        return sum(map(len, self.errors.values()))


def synthetic_gate_set(folder: Path, workers: int = 1, progress: Progress | None = None) -> GateSet:
    """Make the gate's synthetic set.

    Parameters
    ----------
    folder : Path
        To make it in.
    workers : int
    progress : callable, optional

    Returns
    -------
    GateSet
    """
    made = synthesize(
        folder,
        size=SYNTHETIC_SIZE,
        samples=SYNTHETIC_SAMPLES,
        objects=SYNTHETIC_OBJECTS,
        workers=workers,
        progress=progress,
    )
    parameters = parameters_of(SYNTHETIC_SIZE, DEFAULT_SEED, SYNTHETIC_SAMPLES)
    content = ", ".join(f"{name} {value}" for name, value in parameters.items())
    lights = table1_lights(None, count=LIGHTS)
    fitted = tuple(name for name in FITTED["synthetic"] if name in made.objects)
    return GateSet(made, lights, f"{content}; {TABLE1_SEED}", fitted)


def mit_gate_set(root: Path) -> GateSet:
    """Return the gate's objects of MIT-Berkeley.

    Parameters
    ----------
    root : Path
        The data root, which holds ``mit-berkeley``.

    Returns
    -------
    GateSet
    """
    chosen = ChosenObjects(MitBerkeley(root / "mit-berkeley"), MIT_OBJECTS)
    content = f"{chosen.fingerprint()}; {TABLE1_SEED}"
    return GateSet(chosen, table1_lights(root, count=LIGHTS), content, FITTED["mit-berkeley"])


def measure_gate(
    subject: GateSet, workers: int = 1, progress: Progress | None = None
) -> GateMeasurement:
    """Measure Table 1 on a gate's set, base shapes of Table 2, and SIRFS on some of its objects.

    Parameters
    ----------
    subject : GateSet
    workers : int
    progress : callable, optional

    Returns
    -------
    GateMeasurement
    """
    options = RunOptions(workers)
    dataset, parameters = subject.dataset, shipped_parameters()
    table = run_table1(
        dataset, subject.lights, parameters, quick=True, options=options, progress=progress
    )
    errors, reasons = dict(_errors(table)), [missing.reason for missing in table.missing]
    shapes, why = measure_shapes(dataset, options, progress)
    errors.update((key, tuple(map(rounded, row))) for key, row in shapes.items())
    reasons += why
    if subject.fitted:
        chosen = ChosenObjects(dataset, subject.fitted)
        found = measure_fits(chosen, subject.lights, options, progress)
        errors.update((key, tuple(map(rounded, row))) for key, row in found.errors.items())
        reasons += found.reasons
    return GateMeasurement(
        dataset=dataset.name,
        protocol=f"{PROTOCOL} {PROTOCOL_VERSION}",
        content=subject.content,
        fingerprint=dataset.fingerprint(),
        commit=code_commit(),
        platform=numeric_platform(),
        errors=errors,
        reasons=tuple(dict.fromkeys(reasons)),
    )


def numeric_platform() -> dict[str, str]:
    """Return what the last digits of a number may depend on: processor, libraries, versions.

    Returns
    -------
    dict of str

    Examples
    --------
    >>> sorted(numeric_platform())[:3]
    ['c library', 'linear algebra', 'mitsuba']
    """
    found: list[dict[str, Any]] = threadpool_info()
    kernels = {
        f"{library['internal_api']} {library.get('architecture', '')}".strip()
        for library in found
        if library["user_api"] == "blas"
    }
    packages = (*NUMERIC_PACKAGES, "mitsuba")
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "c library": " ".join(platform.libc_ver()),
        "linear algebra": ", ".join(sorted(kernels)),
        **{name: version(name) for name in packages},
    }


def _errors(table: Table1) -> Iterator[tuple[str, tuple[float | None, ...]]]:
    for setting in table.settings():
        for source, rule in variants():
            rows = table.errors(setting, source, rule)
            for name, row in zip(table.objects, rows, strict=True):
                yield f"{setting} {name} {source} {rule}", tuple(map(rounded, row.tolist()))
    for found in table.intrinsic_rows():
        for residual in INTRINSIC:
            key = f"{found['setting']} {found['object']} {residual}"
            yield key, (rounded(float(found[residual])),)


def variants() -> tuple[tuple[str, str], ...]:
    """Return every pair of a detail source and a weight rule; a flat shape has no details.

    Returns
    -------
    tuple of pairs of str

    Examples
    --------
    >>> len(variants()), variants()[-1]
    (11, ('flat', 'coarse'))
    """
    pairs = [(source, rule) for source in QUICK_SOURCES for rule in WEIGHT_RULES]
    return (*pairs, (BASELINE, "coarse"))


def rounded(value: float) -> float | None:
    """Return a number as it is kept, None for one that is not finite.

    Parameters
    ----------
    value : float

    Examples
    --------
    >>> rounded(0.123456789123)
    0.12345679
    """
    return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None


def checked_set(name: str) -> str:
    """Return the name of a set that the gate measures.

    Parameters
    ----------
    name : str

    Raises
    ------
    RelightlabError
        If it does not measure it.

    Examples
    --------
    >>> checked_set("synthetic")
    'synthetic'
    """
    if name not in SETS:
        raise unknown_name("dataset", name, SETS)
    return name
