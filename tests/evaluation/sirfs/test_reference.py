"""SIRFS against what the original program made of three objects.

The oracles are in ``sirfs-octave/`` of the data root: release 1.5 run under GNU Octave 7.3 with
priors retrained by its own scripts (SOURCE.md there). ``final_loss`` and ``errors`` are its own.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from datasets.mit_axes import harmonics_from_mit_axes
from datasets.mit_berkeley import MitBerkeley
from evaluation.sirfs.fit import FitOptions, fit_sirfs
from evaluation.sirfs.framing import checked_photograph
from evaluation.sirfs.metrics import sirfs_errors
from evaluation.sirfs.objective import Evaluation, Objective
from evaluation.sirfs.prior_files import shipped_priors
from evaluation.sirfs.problem import Observation, problem_of
from evaluation.sirfs.result import SirfsFit
from evaluation.sirfs.settings import term_weights
from evaluation.sirfs_fits import object_outline

pytestmark = pytest.mark.real_data

OBJECTS = ("paper2", "raccoon", "turtle")
KINDS = (
    ("laboratory", "gray"), ("laboratory", "color"), ("natural", "gray"), ("natural", "color"),
)  # fmt: skip
CASES = [(setting, channels, name) for setting, channels in KINDS for name in OBJECTS]
PAIR_OFFSET = 0.56
"""What a pair of neighbours costs more by our colour prior than by the original's, whatever it is.

Costs count from the density at a difference of exactly zero, which hangs on how many of 300000
drawn pairs happen to be equal: three of ours. A constant moves no minimum."""
ALLOWED = {("natural", "color", "turtle"): 1.45, ("natural", "color", "paper2"): 1.20}
"""Where our retrained colour prior leads to a worse minimum; elsewhere the bound is 1.10."""


def reference(root: Path, setting: str, channels: str, name: str) -> dict[str, Any]:
    """What the original made of an object, in the project's axes."""
    folder = {"laboratory": "lab", "natural": "natural"}[setting] + f"_{channels}"
    path = root / "sirfs-octave" / folder / f"{name}.npz"
    if not path.is_file():
        pytest.skip(f"{path.parent.parent} is not there")
    with np.load(path) as stored:
        light = harmonics_from_mit_axes(stored["light"])
        return {
            "height": stored["height"].astype(np.float64),
            "light": np.ascontiguousarray(light.T).ravel(),
            "loss": float(stored["final_loss"]),
            "mean": json.loads(str(stored["errors"]))["avg"],
        }


def loss_there(root: Path, setting: str, channels: str, name: str) -> tuple[Evaluation, float]:
    """Our loss at the original's solution, and what the constant of the prior comes to."""
    dataset = MitBerkeley(root / "mit-berkeley")
    outline = object_outline(dataset, name, setting)
    photograph = dataset.load(name, setting).photograph
    image, valid = checked_photograph(photograph.image, photograph.mask, channels)
    weights = term_weights(setting, channels)
    seen = Observation((image,), (valid,), outline)
    problem = problem_of(seen, shipped_priors(), weights, setting, channels)
    theirs = reference(root, setting, channels, name)
    away = theirs["light"] - problem.whitening.mean
    white = np.linalg.solve(problem.whitening.inverse, away)
    pairs = problem.views[0].pairs
    offset = problem.views[0].smoothness * PAIR_OFFSET * float((pairs[:, 2] - pairs[:, 1]).sum())
    return Objective(problem)(theirs["height"], white[None]), offset


@cache
def fitted(root: Path, setting: str, channels: str, name: str) -> tuple[SirfsFit, float]:
    """Our fit of an object, and the geometric mean of its errors."""
    dataset = MitBerkeley(root / "mit-berkeley")
    capture = dataset.load(name, setting)
    fit = fit_sirfs(
        capture.photograph.image,
        capture.photograph.mask,
        shipped_priors(),
        FitOptions(light=setting, channels=channels),
        outline=object_outline(dataset, name, setting),
    )
    return fit, sirfs_errors(fit, capture.truth).mean


@pytest.mark.parametrize(("setting", "channels", "name"), CASES)
def test_loss_at_the_original_solution(
    data_root: Path, setting: str, channels: str, name: str
) -> None:
    """At its solution our loss is within 1 % of its own; in colour, but for one constant."""
    found, offset = loss_there(data_root, setting, channels, name)
    theirs = reference(data_root, setting, channels, name)["loss"]
    ours = found.loss - (offset if channels == "color" else 0.0)
    assert ours == pytest.approx(theirs, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(("setting", "channels", "name"), CASES)
def test_final_loss_is_no_higher(data_root: Path, setting: str, channels: str, name: str) -> None:
    """Our final loss is at most 1.02 times that of the original's solution, by the same priors."""
    fit, _ = fitted(data_root, setting, channels, name)
    there, _ = loss_there(data_root, setting, channels, name)
    assert fit.final_loss <= 1.02 * there.loss
    if channels == "gray":
        assert fit.final_loss <= 1.02 * reference(data_root, setting, channels, name)["loss"]


@pytest.mark.slow
@pytest.mark.parametrize(("setting", "channels", "name"), CASES)
def test_errors_are_those_of_the_original(
    data_root: Path, setting: str, channels: str, name: str
) -> None:
    """The geometric mean of our errors is at most 1.1 times its, but for two cases with reasons."""
    _, mean = fitted(data_root, setting, channels, name)
    theirs = reference(data_root, setting, channels, name)["mean"]
    assert mean <= ALLOWED.get((setting, channels, name), 1.10) * theirs
