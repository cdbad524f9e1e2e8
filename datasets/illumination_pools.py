"""Pools of natural illuminations, and the draws of Table 1 from them."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from scipy.io import loadmat
from scipy.io.matlab import MatReadError

from datasets.environment_maps import shipped_lights
from datasets.mit_axes import harmonics_from_mit_axes
from shading_model.arrays import Float
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics
from shading_model.seeds import generator_for

MEASURED_FILE = Path("boundary-cues") / "Ldata.mat"
"""Where the measured pool lies under a data root."""

TABLE1_COUNT = 20
TABLE1_SEED = "table 1 lights"


def from_mit_axes(coefficients: Float) -> LogHarmonics:
    """Return the light whose nine coefficients are stored in the MIT-Berkeley axes.

    Parameters
    ----------
    coefficients : (9,) or (9, 3) array
        Log-shading, for normals (row down, column right, toward the viewer).

    Returns
    -------
    LogHarmonics
        For normals (x right, y up, z toward the viewer).

    Raises
    ------
    RelightlabError
        If the shape is another, or a value is not finite.

    Examples
    --------
    >>> from_mit_axes(np.eye(9)[3]).shade(np.array([[[0.0, 1.0, 0.0]]])).round(3)  # from below
    array([[0.359]])
    """
    return LogHarmonics(harmonics_from_mit_axes(coefficients))


def natural_lights(root: str | os.PathLike[str] | None) -> tuple[LogHarmonics, ...]:
    """Return the pool of natural lights.

    Under a data root with ``boundary-cues/Ldata.mat`` these are its 776 ``natural_test_color``
    lights, projected from measured environments (the Natural photographs of MIT-Berkeley are lit
    by twenty of them); elsewhere the 90 lights of `datasets.environment_maps.shipped_lights`.

    Parameters
    ----------
    root : path or None
        Folder that holds ``boundary-cues/``; None where there are no data.

    Returns
    -------
    tuple of LogHarmonics
        Coefficients of shape (9, 3), x right, y up, z toward the viewer.

    Raises
    ------
    RelightlabError
        If the file is there but cannot be read, or holds something else.

    Examples
    --------
    >>> len(natural_lights(None))
    90
    """
    path = None if root is None else Path(root) / MEASURED_FILE
    if path is None or not path.exists():
        return shipped_lights()
    stored = _measured_coefficients(path)
    return tuple(from_mit_axes(stored[:, :, index]) for index in range(stored.shape[2]))


def pool_name(root: str | os.PathLike[str] | None) -> str:
    """Return in words which pool `natural_lights` takes for a data root.

    Parameters
    ----------
    root : path or None

    Examples
    --------
    >>> pool_name(None)
    'the 90 shipped lights'
    """
    count = len(natural_lights(root))
    measured = root is not None and (Path(root) / MEASURED_FILE).exists()
    return (
        f"the {count} measured lights of boundary-cues"
        if measured
        else f"the {count} shipped lights"
    )


def table1_lights(
    root: str | os.PathLike[str] | None,
    count: int = TABLE1_COUNT,
    seed: str = TABLE1_SEED,
) -> tuple[LogHarmonics, ...]:
    """Return the monochrome lights an object is relit by in Table 1.

    Drawn without replacement from `natural_lights`; a longer draw begins with the shorter one.

    Parameters
    ----------
    root : path or None
        As for `natural_lights`.
    count : int
        Number of lights, at least 1.
    seed : str
        Name of the draw.

    Returns
    -------
    tuple of LogHarmonics
        Coefficients of shape (9,): the mean over the colour channels of the log coefficients.

    Raises
    ------
    RelightlabError
        If `count` is not between 1 and the size of the pool, or the pool cannot be read.

    Examples
    --------
    >>> lights = table1_lights(None, count=3)
    >>> len(lights), lights[0].coefficients.shape
    (3, (9,))
    """
    pool = natural_lights(root)
    if not 1 <= count <= len(pool):
        raise RelightlabError(f"expected between 1 and {len(pool)} lights, got {count}")
    order = generator_for("lights", seed).permutation(len(pool))
    return tuple(pool[index].monochrome() for index in order[:count])


def _measured_coefficients(path: Path) -> Float:
    try:
        # Only this variable is wanted, and it is nested: ``Ldata.natural_test_color``.
        stored = loadmat(path)["Ldata"][0, 0]["natural_test_color"]
    except OSError as error:
        raise RelightlabError(f"cannot read {path}: {error.strerror or error}") from error
    except (MatReadError, ValueError, TypeError, KeyError, IndexError, EOFError) as error:
        raise RelightlabError(
            f"{path} does not hold Ldata.natural_test_color: fetch it again ({error})"
        ) from error
    if stored.ndim != 3 or stored.shape[:2] != (9, 3):
        raise RelightlabError(
            f"expected natural_test_color of shape (9, 3, n) in {path}, got {stored.shape}"
        )
    coefficients: Float = stored.astype(np.float64)
    return coefficients
