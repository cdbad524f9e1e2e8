"""Lights that priors are learned from, read into the project's axes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat

from datasets.mit_axes import harmonics_from_mit_axes
from datasets.mit_berkeley import TRAINING_OBJECTS, MitBerkeley
from datasets.training_lights import (
    environment_lights,
    fitted_lights,
    photographed_lights,
    released_gaussian,
)
from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics


def random(*shape: int) -> Float:
    """Numbers that differ."""
    return np.random.default_rng(0).normal(size=shape)


def write_fitted(root: Path, lights: dict[str, Any]) -> Path:
    """Write the file of the lights fitted to an apple."""
    folder = root / "MIT-Berkeley-Laboratory" / "apple"
    folder.mkdir(parents=True, exist_ok=True)
    savemat(folder / "L.mat", {"color_lights": lights})
    return folder / "L.mat"


def twelve() -> tuple[Float, dict[str, Any]]:
    """Twelve lights, and the struct that holds them."""
    lights = random(9, 3, 12)
    cells = np.empty((1, 10), dtype=object)
    cells[0] = [lights[:, :, k] for k in range(10)]
    return lights, {"light": cells, "diffuse": lights[:, :, 10], "shading": lights[:, :, 11]}


def write_released(root: Path, **changes: Any) -> tuple[Float, Path]:
    """Write a file like that of boundary-cues and return its lights as stored."""
    lights = random(40, 27)
    name = "natural_color"
    data: dict[str, Any] = {
        "gaussian": {name: {"mu": lights.mean(0)[:, None], "Sigma": np.cov(lights.T)}},
        "X": {name: lights},
        "whiten": {name: {"map": np.eye(27) + 0.1 * np.cov(lights.T)}},
    } | changes
    (root / "boundary-cues").mkdir(exist_ok=True)
    path = root / "boundary-cues" / "Ldata.mat"
    savemat(path, {"Ldata": data})
    return lights, path


def test_environments_come_one_by_one(tmp_path: Path) -> None:
    """Each is what was stored, in the project's axes."""
    stored = random(9, 3, 5)
    savemat(tmp_path / "natural_lights.mat", {"Ls": stored})
    lights = environment_lights(tmp_path)
    assert lights.shape == (5, 9, 3)
    assert np.array_equal(lights[3], harmonics_from_mit_axes(stored[:, :, 3]))


def test_fitted_lights_are_the_ten_and_two_more(tmp_path: Path) -> None:
    """In the order of the photographs, then those of the diffuse one and of the shading."""
    stored, struct = twelve()
    write_fitted(tmp_path, struct)
    lights = fitted_lights(tmp_path, "apple")
    assert lights.shape == (12, 9, 3)
    for k in (0, 9, 10, 11):
        assert np.array_equal(lights[k], harmonics_from_mit_axes(stored[:, :, k]))


def test_photographed_lights_are_in_the_projects_axes(tmp_path: Path) -> None:
    """As the natural photographs' truth has them."""
    folder = tmp_path / "MIT-Berkeley-Natural" / "pear"
    folder.mkdir(parents=True)
    savemat(folder / "L.mat", {"L": random(9, 3)})
    lights = photographed_lights(tmp_path, ("pear",))
    assert np.array_equal(lights, harmonics_from_mit_axes(random(9, 3))[None])


def test_released_gaussian_is_turned_whole(tmp_path: Path) -> None:
    """Mean and covariance are those of the turned lights, channel by channel."""
    stored, _ = write_released(tmp_path)
    released = released_gaussian(tmp_path, "natural")
    assert np.allclose(released.lights.mean(axis=0), released.mean)
    assert np.allclose(np.cov(released.lights.T), released.covariance)
    assert np.allclose(released.whitening, np.eye(27) + 0.1 * released.covariance)
    second = released.lights[7, 9:18]
    assert np.allclose(second, harmonics_from_mit_axes(stored[7, 9:18]))


@pytest.mark.parametrize(
    ("write", "read", "sentence"),
    [
        (
            lambda root: savemat(root / "natural_lights.mat", {"Ls": random(3, 9, 5)}),
            environment_lights,
            r"shape \(9, 3, n\) in .*got shape \(3, 9, 5\)",
        ),
        (
            lambda root: write_fitted(root, {"light": 1.0, "diffuse": 2.0}),
            lambda root: fitted_lights(root, "apple"),
            "expected color_lights with light, diffuse and shading",
        ),
        (
            lambda root: write_fitted(root, twelve()[1] | {"shading": random(9)}),
            lambda root: fitted_lights(root, "apple"),
            "expected color_lights with light, diffuse and shading",
        ),
        (
            lambda root: write_fitted(root, twelve()[1] | {"shading": np.full((9, 3), np.nan)}),
            lambda root: fitted_lights(root, "apple"),
            "expected twelve finite lights",
        ),
        (
            lambda root: write_released(root, gaussian={"other": 1.0}),
            lambda root: released_gaussian(root, "natural"),
            "does not hold the Gaussian natural_color",
        ),
        (
            lambda root: write_released(root, X={"natural_color": random(40, 9)}),
            lambda root: released_gaussian(root, "natural"),
            r"does not hold the Gaussian natural_color .*shape \(40, 9\)",
        ),
        (
            write_released,
            lambda root: released_gaussian(root, "moon"),
            "Unknown kind of light 'moon'",
        ),
    ],
)
def test_other_content_is_one_sentence(
    tmp_path: Path,
    write: Callable[[Path], object],
    read: Callable[[Path], object],
    sentence: str,
) -> None:
    """A file of another shape is named, with what was expected of it."""
    write(tmp_path)
    with pytest.raises(RelightlabError, match=sentence):
        read(tmp_path)


def test_missing_files_name_the_set_to_fetch(tmp_path: Path) -> None:
    """Each set's own command is named."""
    with pytest.raises(RelightlabError, match="data fetch mit-berkeley"):
        environment_lights(tmp_path)
    with pytest.raises(RelightlabError, match="data fetch boundary-cues"):
        released_gaussian(tmp_path, "natural")


@pytest.mark.real_data
def test_measured_lights(mit_berkeley_root: Path) -> None:
    """228 environments; the fitted lights are those of the photographs' own records."""
    assert environment_lights(mit_berkeley_root).shape == (228, 9, 3)
    dataset = MitBerkeley(mit_berkeley_root)
    fitted = fitted_lights(mit_berkeley_root, TRAINING_OBJECTS[0])
    for lit, light in zip(dataset.lit_photographs(TRAINING_OBJECTS[0]), fitted, strict=False):
        assert np.array_equal(lit.illumination.coefficients, light)
    truth = dataset.load(TRAINING_OBJECTS[0], "laboratory").truth.illumination
    assert isinstance(truth, LogHarmonics)
    assert np.array_equal(truth.coefficients, fitted[10])
