"""Retinex thresholds learned leave-one-object-out, and the command that learns them again.

``python -m evaluation.retinex_thresholds [--data ROOT]`` searches a grid of thresholds on
MIT-Berkeley for the least mean LMSE (`evaluation.intrinsic_metrics`) and writes the shipped table:
for each setting the thresholds learned on all objects, and for each object those learned on the
other nineteen. The defaults for ordinary photographs are those of the laboratory setting, whose
pictures are real photographs.
"""

from __future__ import annotations

import argparse
import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from threadpoolctl import threadpool_limits

from datasets.atomic import atomic_path
from datasets.locations import find_data_root, missing_data_sentence
from datasets.mit_berkeley import MitBerkeley
from datasets.records import Dataset
from evaluation.intrinsic_metrics import intrinsic_error
from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from shading_model.retinex import Retinex, RetinexThresholds

FILE = Path(__file__).with_name("retinex_thresholds.json")
GRAY = (0.1, 0.2, 0.3, 0.4, 0.55, 0.75, 1.0, 1.4, 2.0)
CHROMATICITY = (0.01, 0.02, 0.03, 0.04, 0.05, 0.065, 0.08, 0.1, 0.14, 0.2, 0.4)


@cache
def shipped_table() -> dict[str, Any]:
    """Return the shipped thresholds; see the module's docstring.

    Examples
    --------
    >>> sorted(shipped_table()["settings"])
    ['laboratory', 'natural']
    """
    table: dict[str, Any] = json.loads(FILE.read_text())
    return table


def thresholds_for(dataset: str, setting: str, name: str) -> RetinexThresholds | None:
    """Return the thresholds learned without this object, None where nothing was learned.

    Parameters
    ----------
    dataset, setting, name : str

    Examples
    --------
    >>> thresholds_for("mit-berkeley", "laboratory", "an object of one's own") is None
    True
    """
    table = shipped_table()
    if dataset != table["dataset"] or setting not in table["settings"]:
        return None
    pair = table["settings"][setting]["without"].get(name)
    return RetinexThresholds(*pair) if pair else None


def default_thresholds() -> RetinexThresholds:
    """Return the thresholds for ordinary photographs: laboratory setting, all objects.

    Examples
    --------
    >>> default_thresholds().gray > default_thresholds().chromaticity
    True
    """
    return RetinexThresholds(*shipped_table()["settings"]["laboratory"]["all"])


def error_grid(dataset: Dataset, name: str, setting: str) -> Float:
    """Return the LMSE of Retinex on one object for every pair of thresholds.

    Parameters
    ----------
    dataset : Dataset
    name, setting : str

    Returns
    -------
    (len(GRAY), len(CHROMATICITY)) array

    Raises
    ------
    RelightlabError
        If the true albedo or shading is not known.
    """
    capture = dataset.load(name, setting)
    photograph, truth = capture.photograph, capture.truth
    if truth.albedo is None or truth.shading is None:
        raise RelightlabError(f"learning needs the true albedo and shading of {name}")
    with threadpool_limits(limits=1):
        separator = Retinex(photograph.image, photograph.mask)
        errors = np.empty((len(GRAY), len(CHROMATICITY)))
        for row, gray in enumerate(GRAY):
            for column, chromaticity in enumerate(CHROMATICITY):
                parts = separator.separate(RetinexThresholds(gray, chromaticity))
                errors[row, column] = intrinsic_error(
                    parts.albedo, parts.shading, truth.albedo, truth.shading, photograph.mask
                )
    return errors


def leave_one_out(errors: Float) -> tuple[RetinexThresholds, list[RetinexThresholds]]:
    """Return the best thresholds over all objects, and for each object over the others.

    Parameters
    ----------
    errors : (objects, len(GRAY), len(CHROMATICITY)) array

    Examples
    --------
    >>> errors = np.ones((2, len(GRAY), len(CHROMATICITY)))
    >>> errors[1, 2, 4] = 0
    >>> leave_one_out(errors)[1][0]
    RetinexThresholds(gray=0.3, chromaticity=0.05)
    """

    def best(mean: Float) -> RetinexThresholds:
        gray, chromaticity = np.unravel_index(np.argmin(mean), mean.shape)
        return RetinexThresholds(GRAY[gray], CHROMATICITY[chromaticity])

    total = errors.sum(axis=0)
    return best(total), [best(total - own) for own in errors]


def learn(dataset: Dataset, workers: int = 2) -> dict[str, Any]:
    """Return the table of thresholds learned on a dataset, ready to be written as JSON.

    Parameters
    ----------
    dataset : Dataset
    workers : int

    Returns
    -------
    dict
    """
    settings = {}
    for setting in dataset.settings:
        grids = Parallel(n_jobs=workers)(
            delayed(error_grid)(dataset, name, setting) for name in dataset.objects
        )
        everything, without = leave_one_out(np.array(grids))
        settings[setting] = {
            "all": _pair(everything),
            "least_mean_lmse": round(float(np.mean(grids, axis=0).min()), 6),
            "without": {
                name: _pair(thresholds)
                for name, thresholds in zip(dataset.objects, without, strict=True)
            },
        }
    return {
        "made_by": "python -m evaluation.retinex_thresholds",
        "dataset": dataset.name,
        "fingerprint": dataset.fingerprint(),
        "thresholds": "[change of log brightness, change of chromaticity]",
        "settings": settings,
    }


def _pair(thresholds: RetinexThresholds) -> list[float]:
    return [thresholds.gray, thresholds.chromaticity]


def main() -> None:
    """Learn the thresholds on MIT-Berkeley and write the shipped table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--data", type=Path, help="folder that holds mit-berkeley/")
    root = find_data_root(parser.parse_args().data)
    if root is None:
        raise SystemExit(missing_data_sentence("mit-berkeley"))
    table = learn(MitBerkeley(root / "mit-berkeley"))
    with atomic_path(FILE) as path:
        path.write_text(json.dumps(table, indent=1) + "\n")


if __name__ == "__main__":
    main()
