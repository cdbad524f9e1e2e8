"""How long each stage takes, in units that mean the same on every machine.

``python -m evaluation.benchmark [--data ROOT]`` builds the models of raccoon, sun and raccoon at
four times the pixels (synthetic objects where MIT-Berkeley is absent) on one BLAS thread, and
prints each stage's time in units of one SciPy ``splu`` factorisation plus solve of the same
object's grid Laplacian, timed in the same run; before that, the time and memory of the whole of
Table 1, and the efficiency of its workers: the time of one process over that of all workers
together, their start-up included.
"""

from __future__ import annotations

import argparse
import os
import resource
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import zoom
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

from datasets.illumination_pools import table1_lights
from datasets.locations import find_data_root, missing_data_sentence
from datasets.mit_berkeley import MitBerkeley
from datasets.model_parameters import shipped_parameters
from datasets.records import Dataset, Photograph
from datasets.synthetic import Synthetic, synthetic_root
from evaluation.grid_run import RunOptions
from evaluation.row_store import ROWS, RowStore
from evaluation.sirfs_benchmark import fit_times, report_fit
from evaluation.table1 import run_table1
from shading_model.geometric_detail import geometric_detail
from shading_model.illumination_fit import fit_point_lights
from shading_model.object_model import ModelParameters, build_model, contour_base
from shading_model.pixel_grid import PixelGrid
from shading_model.retinex import retinex

REPEATS = 3
LIMITS = {"contour": 4.0, "retinex": 1.6, "point lights": 1.2, "detail": 1.2, "whole build": 8.0}
"""What each stage may cost, in units."""
GROWTH_LIMIT = 5.0
"""How many times longer four times the pixels may take."""
TABLE_SECONDS = 60.0
TABLE_GIBIBYTES = 1.5
BUSY = 0.5
"""Load of the machine above which times say little."""
EFFICIENCY = 0.85
"""The least share of their time that workers should spend on what one process would do."""


@dataclass(frozen=True)
class StageTimes:
    """Median seconds of each stage for one object.

    Parameters
    ----------
    name : str
    pixels : int
    unit : float
        Seconds of one sparse factorisation plus solve.
    seconds : dict of float
    """

    name: str
    pixels: int
    unit: float
    seconds: dict[str, float]

    def units(self, stage: str) -> float:
        """Return a stage's time in units.

        Parameters
        ----------
        stage : str
        """
        return self.seconds[stage] / self.unit


def stage_times(photograph: Photograph, parameters: ModelParameters) -> StageTimes:
    """Time every stage of building one model, and the unit, in turn.

    Parameters
    ----------
    photograph : Photograph
    parameters : ModelParameters

    Returns
    -------
    StageTimes
        Medians over `REPEATS` rounds, so that a drift of the machine touches all alike.
    """
    image, mask = photograph.image, photograph.mask
    shape = contour_base(mask, parameters)
    shading = retinex(image, mask, parameters.thresholds).shading
    stages: dict[str, Callable[[], Any]] = {
        "unit": lambda: _factorise_and_solve(mask),
        "contour": lambda: contour_base(mask, parameters),
        "retinex": lambda: retinex(image, mask, parameters.thresholds),
        "point lights": lambda: fit_point_lights(shading, shape.normals, shape.height),
        "detail": lambda: geometric_detail(shading, mask, parameters.dictionary),
        "whole build": lambda: build_model(image, mask, parameters),
    }
    rounds = [{stage: _seconds(work) for stage, work in stages.items()} for _ in range(REPEATS)]
    seconds = {stage: float(np.median([r[stage] for r in rounds])) for stage in stages}
    return StageTimes(photograph.name, int(mask.sum()), seconds.pop("unit"), seconds)


def enlarged(photograph: Photograph, factor: int = 2) -> Photograph:
    """Return the photograph with factor x factor times the pixels, linearly interpolated.

    Parameters
    ----------
    photograph : Photograph
    factor : int

    Returns
    -------
    Photograph
    """
    image = zoom(photograph.image, (factor, factor, 1), order=1)
    mask = np.kron(photograph.mask, np.ones((factor, factor), dtype=bool))
    name = f"{photograph.name}, {factor * factor} times the pixels"
    return Photograph(np.clip(image, 0, None), mask, name, photograph.source)


def _factorise_and_solve(mask: np.ndarray[Any, Any]) -> None:
    grid = PixelGrid(mask)
    inside = np.flatnonzero(~grid.boundary)
    rows: Any = grid.laplacian[inside]
    matrix = rows[:, inside].tocsc()
    right = np.ones(len(inside))
    splu(matrix).solve(right)


def _seconds(work: Callable[[], Any]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def report(times: StageTimes) -> list[str]:
    """Return the lines that show one object's stages.

    Parameters
    ----------
    times : StageTimes
    """
    lines = [f"{times.name}: {times.pixels} pixels, one unit is {times.unit:.3f} s"]
    for stage, limit in LIMITS.items():
        units = times.units(stage)
        verdict = "ok" if units <= limit else "SLOWER THAN THE LIMIT"
        lines.append(
            f"  {stage:<13}{times.seconds[stage]:8.3f} s {units:7.2f} units"
            f"  (limit {limit:.1f}) {verdict}"
        )
    return lines


def _dataset(root: Path | None) -> Dataset:
    if root is not None and (root / "mit-berkeley").is_dir():
        return MitBerkeley(root / "mit-berkeley")
    print(missing_data_sentence("mit-berkeley"))
    return Synthetic(synthetic_root())


def main() -> None:
    """Print the whole of Table 1, the stages of three objects, fits of SIRFS, and the growth."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("--data", type=Path, help="folder that holds mit-berkeley/")
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    root = find_data_root(options.data)
    dataset, parameters = _dataset(root), shipped_parameters()
    names = [n for n in ("raccoon", "sun") if n in dataset.objects] or dataset.objects[:2]
    photographs = [dataset.load(name, "laboratory").photograph for name in names]
    # First, because the peak memory of the process that prints never falls again.
    _time_table(dataset, root, parameters, options.workers)
    with threadpool_limits(limits=1):
        timed = [stage_times(p, parameters) for p in (*photographs, enlarged(photographs[0]))]
    for times in timed:
        print("\n".join(report(times)))
    with threadpool_limits(limits=1):
        for name in names:
            print("\n".join(report_fit(fit_times(dataset, name))))
    growth = timed[-1].seconds["whole build"] / timed[0].seconds["whole build"]
    print(f"four times the pixels: {growth:.2f} times the time (limit {GROWTH_LIMIT:.0f})")


def _time_table(
    dataset: Dataset, root: Path | None, parameters: ModelParameters, workers: int
) -> None:
    # What is read once is read here, so that the first run does not pay for the second.
    dataset.fingerprint()
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    busy = os.getloadavg()[0]
    alone = _table_seconds(dataset, root, parameters, 1)
    seconds = _table_seconds(dataset, root, parameters, workers)
    kibibytes = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    memory = (kibibytes * workers + own) / 2**20
    print(
        f"Table 1 of {dataset.name}, complete: {seconds:.1f} s on {workers} workers"
        f" (limit {TABLE_SECONDS:.0f}), at most {memory:.2f} GiB (limit {TABLE_GIBIBYTES})"
    )
    print(efficiency_line(alone, seconds, workers))
    if busy > BUSY:
        print(f"  the machine was busy before (load {busy:.1f}): measure again when it is quiet")


def efficiency_line(alone: float, together: float, workers: int) -> str:
    """Return the line that shows how well workers share Table 1.

    Parameters
    ----------
    alone : float
        Seconds of one process.
    together : float
        Seconds of all workers, from their start to the last row.
    workers : int

    Examples
    --------
    >>> efficiency_line(30.0, 16.0, 2)
    '  efficiency 0.94 = 30.0 s by one process / (2 x 16.0 s) (at least 0.85) ok'
    """
    efficiency = alone / (workers * together)
    verdict = "ok" if efficiency >= EFFICIENCY else "BELOW THE LIMIT"
    return (
        f"  efficiency {efficiency:.2f} = {alone:.1f} s by one process / ({workers} x"
        f" {together:.1f} s) (at least {EFFICIENCY}) {verdict}"
    )


def _table_seconds(
    dataset: Dataset, root: Path | None, parameters: ModelParameters, workers: int
) -> float:
    """Return the seconds of Table 1 with a fresh store, by workers started for it."""
    with tempfile.TemporaryDirectory() as folder:
        store = RowStore(Path(folder) / ROWS)
        start = time.perf_counter()
        run_table1(
            dataset,
            table1_lights(root),
            parameters,
            store=store,
            quick=True,
            options=RunOptions(workers=workers),
        )
        return time.perf_counter() - start


if __name__ == "__main__":
    main()
