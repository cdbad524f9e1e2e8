"""Lights as they are given on the command line: by name, file, direction or coefficients."""

from __future__ import annotations

import json
import math
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from datasets.environment_maps import TABLE_NAME
from shading_model.arrays import Float
from shading_model.errors import RelightlabError, unknown_name
from shading_model.illumination import Illumination, LinearHarmonics, LogHarmonics, PointLights
from shading_model.object_model import ObjectModel

FITTED = "fitted"
"""Name of the light that was fitted to the model's own photograph."""
CONVENTIONS: dict[str, type[LogHarmonics | LinearHarmonics]] = {
    "log": LogHarmonics,
    "linear": LinearHarmonics,
}
DISTANCE = 1e4
"""A distant light is a point light this many times the picture's size away."""


def named_light(name: str, model: ObjectModel) -> Illumination:
    """Return a light by its name, or from a JSON file.

    Parameters
    ----------
    name : str
        `FITTED`, a light that ships (its environment map and turn in degrees, ``apartment-72``),
        or a file ending in ``.json`` (see `light_in`).
    model : ObjectModel
        Whose fitted light is meant.

    Returns
    -------
    Illumination

    Raises
    ------
    RelightlabError
        If the name is unknown, or the file cannot be read.
    """
    if name.endswith(".json"):
        return light_in(Path(name))
    if name == FITTED:
        return model.illumination
    shipped = _shipped()
    if name not in shipped:
        raise unknown_name("light", name, [FITTED, *shipped])
    return LogHarmonics(shipped[name])


def light_in(path: Path) -> Illumination:
    """Return the light in a JSON file.

    Parameters
    ----------
    path : Path
        Holds ``{"convention": "log" or "linear", "coefficients": 9 or 9 x 3 numbers}`` or
        ``{"positions": m x 3 numbers, "intensities": m numbers}`` (pixels; x is the column, y
        minus the row, z the height).

    Returns
    -------
    Illumination

    Raises
    ------
    RelightlabError
        If the file is missing or holds something else.
    """
    try:
        given = json.loads(path.read_text(encoding="utf-8"))
        if "positions" in given:
            return _finite_points(_numbers(given["positions"]), _numbers(given["intensities"]))
        return harmonic_light(_numbers(given["coefficients"]), given.get("convention", "log"))
    except OSError as error:
        raise RelightlabError(f"cannot read the light {path}: {error.strerror}") from error
    except (ValueError, TypeError, KeyError) as error:
        raise RelightlabError(
            f"expected a light in {path}, with 'coefficients' (9, or 9 of 3, and a 'convention')"
            " or 'positions' and 'intensities'"
        ) from error


def harmonic_light(coefficients: Float, convention: str) -> LogHarmonics | LinearHarmonics:
    """Return a spherical-harmonic light in one of the two conventions.

    Parameters
    ----------
    coefficients : (9,), (27,) or (9, 3) array
        One light colour, or three: of 27 numbers the first three are those of the first harmonic.
    convention : {"log", "linear"}

    Returns
    -------
    LogHarmonics or LinearHarmonics

    Raises
    ------
    RelightlabError
        If the convention is unknown, or the numbers are not finite or too few or many.

    Examples
    --------
    >>> harmonic_light(np.zeros(27), "log").coefficients.shape
    (9, 3)
    """
    if convention not in CONVENTIONS:
        raise unknown_name("convention", convention, CONVENTIONS)
    shaped = coefficients.reshape(9, 3) if coefficients.shape == (27,) else coefficients
    return CONVENTIONS[convention](shaped)


def distant_light(direction: Float, intensity: float, model: ObjectModel) -> PointLights:
    """Return a light whose shading is ``intensity * max(0, N . d)``.

    It is a point light so far away that its direction varies by a ten-thousandth over the object.

    Parameters
    ----------
    direction : (3,) array
        Toward the light: x right, y up, z toward the viewer; any length but zero.
    intensity : float
        Shading of a surface that faces the light; above zero.
    model : ObjectModel

    Returns
    -------
    PointLights

    Raises
    ------
    RelightlabError
        If the direction is zero or the intensity not above zero.
    """
    length = float(np.linalg.norm(direction))
    if length == 0:
        raise RelightlabError("expected a direction toward the light, got 0,0,0")
    if not 0 < intensity < math.inf:
        raise RelightlabError(f"expected an intensity above zero, got {intensity}")
    rows, columns = np.nonzero(model.mask)
    centre = np.array([columns.mean(), -rows.mean(), np.nanmean(model.height)])
    distance = DISTANCE * max(model.mask.shape)
    position = centre + distance * np.asarray(direction) / length
    return PointLights(position[None], np.array([intensity * distance**2]))


def _shipped() -> dict[str, Float]:
    text = resources.files("datasets").joinpath(TABLE_NAME).read_text(encoding="utf-8")
    rows = json.loads(text)["lights"]
    return {f"{row['map']}-{row['degrees']}": np.array(row["log"]) for row in rows}


def _numbers(values: Any) -> Float:
    return np.array(values, dtype=np.float64)


def _finite_points(positions: Float, intensities: Float) -> PointLights:
    if not (np.isfinite(positions).all() and np.isfinite(intensities).all()):
        raise RelightlabError("the positions or intensities of the light are not finite")
    return PointLights(positions, intensities)
