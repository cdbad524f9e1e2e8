"""Lights that priors are learned from: measured environments, and those fitted to photographs.

All are coefficients of log shading (`shading_model.illumination.LogHarmonics`) in the project's
axes, one (9, 3) array for each light.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from datasets.illumination_pools import MEASURED_FILE
from datasets.mit_axes import harmonics_from_mit_axes
from datasets.mit_berkeley import load_mat
from shading_model.arrays import Float
from shading_model.errors import RelightlabError, unknown_name

ENVIRONMENTS_FILE = "natural_lights.mat"
RELEASED_NAMES = {"natural": "natural_color", "laboratory": "lab_color"}


@dataclass(frozen=True, eq=False)
class ReleasedGaussian:
    """The Gaussian of coloured lights of one kind as boundary-cues ships it.

    Vectors hold the nine coefficients of the first colour, then of the next, in the project's axes.

    Parameters
    ----------
    mean : (27,) array
    covariance : (27, 27) array
    whitening : (27, 27) array
        Map, to be applied to row vectors with the mean subtracted.
    lights : (n, 27) array
        That it was estimated from.
    """

    mean: Float
    covariance: Float
    whitening: Float
    lights: Float


def environment_lights(root: Path) -> Float:
    """Return the lights projected from 228 measured environments.

    Parameters
    ----------
    root : Path
        The folder of the MIT-Berkeley set.

    Returns
    -------
    (228, 9, 3) array

    Raises
    ------
    RelightlabError
        If the file is missing, damaged or holds something else.

    Examples
    --------
    >>> environment_lights(Path("nowhere"))
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: no such file: nowhere/natural_lights.mat; get it with ...
    """
    path = Path(root) / ENVIRONMENTS_FILE
    stored = np.asarray(load_mat(path, "Ls")["Ls"], dtype=np.float64)
    if stored.ndim != 3 or stored.shape[:2] != (9, 3) or not np.isfinite(stored).all():
        raise RelightlabError(
            f"expected finite lights Ls of shape (9, 3, n) in {path}, got shape {stored.shape}"
        )
    return _each_in_project_axes(stored)


def fitted_lights(root: Path, name: str) -> Float:
    """Return the twelve lights fitted to laboratory photographs of an object.

    Those of its ten photographs under single lamps, of the photograph that models are built from
    and of the shading that was published first.

    Parameters
    ----------
    root : Path
        The folder of the MIT-Berkeley set.
    name : str
        Object.

    Returns
    -------
    (12, 9, 3) array

    Raises
    ------
    RelightlabError
        If the file is missing, damaged or holds something else.

    Examples
    --------
    >>> fitted_lights(Path("nowhere"), "apple")
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: no such file: nowhere/MIT-Berkeley-Laboratory/apple/...
    """
    path = Path(root) / "MIT-Berkeley-Laboratory" / name / "L.mat"
    lights = load_mat(path, "color_lights")["color_lights"]
    try:
        each = [*lights.light, lights.diffuse, lights.shading]
        stacked = np.stack([np.asarray(light, dtype=np.float64) for light in each], axis=-1)
    except (AttributeError, TypeError, ValueError) as error:
        raise RelightlabError(
            f"expected color_lights with light, diffuse and shading in {path}: fetch it again"
        ) from error
    if stacked.shape != (9, 3, 12) or not np.isfinite(stacked).all():
        raise RelightlabError(
            f"expected twelve finite lights of shape (9, 3) in {path}, got shape {stacked.shape}"
        )
    return _each_in_project_axes(stacked)


def photographed_lights(root: Path, names: tuple[str, ...]) -> Float:
    """Return the natural lights that photographs of the set are lit by.

    Parameters
    ----------
    root : Path
        The folder of the MIT-Berkeley set.
    names : tuple of str
        Objects.

    Returns
    -------
    (n, 9, 3) array

    Raises
    ------
    RelightlabError
        If a file is missing, damaged or holds something else.

    Examples
    --------
    >>> photographed_lights(Path("nowhere"), ()).shape
    (0, 9, 3)
    """
    paths = [Path(root) / "MIT-Berkeley-Natural" / name / "L.mat" for name in names]
    lights = [np.asarray(load_mat(path, "L")["L"], dtype=np.float64) for path in paths]
    converted = [harmonics_from_mit_axes(light) for light in lights]
    return np.stack(converted) if converted else np.empty((0, 9, 3))


def released_gaussian(data_root: Path, light: str) -> ReleasedGaussian:
    """Return the Gaussian of coloured lights as boundary-cues ships it.

    Parameters
    ----------
    data_root : Path
        Folder that holds ``boundary-cues/``.
    light : {"natural", "laboratory"}

    Returns
    -------
    ReleasedGaussian

    Raises
    ------
    RelightlabError
        If the kind of light is unknown, or the file is missing, damaged or holds something else.

    Examples
    --------
    >>> released_gaussian(Path("nowhere"), "natural")
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: no such file: nowhere/boundary-cues/Ldata.mat; get it ...
    """
    if light not in RELEASED_NAMES:
        raise unknown_name("kind of light", light, RELEASED_NAMES)
    path = Path(data_root) / MEASURED_FILE
    stored, name = load_mat(path, "Ldata", of="boundary-cues")["Ldata"], RELEASED_NAMES[light]
    turn = _axes_matrix()
    try:
        gaussian = getattr(stored.gaussian, name)
        mean, lights = _of_27(gaussian.mu, 1), _of_27(getattr(stored.X, name), 2)
        covariance = _of_27(gaussian.Sigma, 2)
        whitening = _of_27(getattr(stored.whiten, name).map, 2)
    except (AttributeError, TypeError, ValueError) as error:
        raise RelightlabError(
            f"{path} does not hold the Gaussian {name} of 27 coefficients: fetch it again ({error})"
        ) from error
    return ReleasedGaussian(
        turn @ mean, turn @ covariance @ turn.T, turn @ whitening @ turn.T, lights @ turn.T
    )


def _of_27(values: Any, dimensions: int) -> Float:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != dimensions or array.shape[-1] != 27 or not np.isfinite(array).all():
        raise ValueError(f"an array of shape {array.shape}")
    return array


def _axes_matrix() -> Float:
    """Return the orthogonal matrix that takes 27 coefficients to the project's axes."""
    turn = np.kron(np.eye(3), harmonics_from_mit_axes(np.eye(9)))
    return np.asarray(turn, dtype=np.float64)


def _each_in_project_axes(stored: Float) -> Float:
    """Return (9, 3, n) coefficients of the files as (n, 9, 3) ones in the project's axes."""
    converted = harmonics_from_mit_axes(stored.reshape(9, -1)).reshape(stored.shape)
    return np.ascontiguousarray(np.moveaxis(converted, -1, 0))
