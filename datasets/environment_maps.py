"""Lights projected from environment maps, and the small table of them that ships.

`python -m datasets.environment_maps FOLDER` reads the folder's equirectangular maps and writes
`environment_lights.json` again. Each map gives one light per turn about the vertical.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
from collections.abc import Sequence
from importlib import resources
from pathlib import Path

import numpy as np

from datasets.atomic import atomic_path
from datasets.openexr_files import read_openexr
from shading_model.arrays import Float, Image
from shading_model.errors import RelightlabError
from shading_model.harmonic_conversion import (
    linear_to_log,
    rotate,
    rotation_about_vertical,
    visible_normals,
)
from shading_model.illumination import C4, LinearHarmonics, LogHarmonics

TURNS = 5
"""Lights made of each map, evenly spaced about the vertical."""

SOFTENING = 0.7
"""Factor on the log coefficients: high-dynamic-range maps with the sun in them light a sphere with
more contrast than the measured natural lights do. With it the pool's median contrast (standard
deviation over mean of the shading) is 0.32 and its median mean shading 0.46; measured: 0.34 and
0.49."""

TABLE_NAME = "environment_lights.json"
_FORMAT = "relightlab environment lights 1"
_DECIMALS = 6
_PROVENANCE = {
    "maps": "Poly Haven environment maps at 512x256, from the npm package @pmndrs/assets 1.7.0",
    "licence": "CC0-1.0",
    "made_by": "python -m datasets.environment_maps FOLDER",
    "convention": (
        "log[j][channel]: shading = exp(B(N) . log), normals x right, y up, z toward the viewer;"
        f" contrast softened by {SOFTENING};"
        " the brightest channel of the brightest visible normal is 1"
    ),
}

# Orthonormal real spherical harmonics up to degree 2, in the order of
# `shading_model.illumination.harmonics`.
_Y0 = 0.5 * math.sqrt(1.0 / math.pi)
_Y1 = 0.5 * math.sqrt(3.0 / math.pi)
_Y2 = 0.5 * math.sqrt(15.0 / math.pi)
_Y20 = 0.25 * math.sqrt(5.0 / math.pi)


def directions(height: int, width: int) -> Float:
    """Return the direction each pixel of an equirectangular map looks in.

    The top row is up (+y); the centre column lies behind the object, where the viewer looks
    (-z); columns to its right lie to the right (+x), as in a panorama seen from inside.

    Parameters
    ----------
    height, width : int
        Size of the map in pixels.

    Returns
    -------
    (height, width, 3) array
        Unit vectors (x right, y up, z toward the viewer).

    Examples
    --------
    >>> directions(2, 4)[0, 1].round(3)
    array([-0.5  ,  0.707, -0.5  ])
    """
    polar = (np.arange(height) + 0.5) * math.pi / height
    azimuth = (np.arange(width) + 0.5) * 2.0 * math.pi / width - math.pi
    polar, azimuth = np.meshgrid(polar, azimuth, indexing="ij")
    return np.stack(
        [np.sin(polar) * np.sin(azimuth), np.cos(polar), -np.sin(polar) * np.cos(azimuth)],
        axis=-1,
    )


def irradiance_harmonics(radiance: Image) -> LinearHarmonics:
    """Return the irradiance of an environment map in nine harmonics.

    The coefficients are those of the radiance; the constants of B(N) hold the cosine lobe, so
    that B(N) . L is the irradiance to a few per cent (Ramamoorthi and Hanrahan 2001, eq. 13).

    Parameters
    ----------
    radiance : (h, w, 3) array
        Equirectangular, linear; see `directions` for its orientation. Negative values, which
        lossy compression leaves beside bright lamps, count as zero.

    Returns
    -------
    LinearHarmonics
        Coefficients of shape (9, 3).

    Raises
    ------
    RelightlabError
        If the map is not twice as wide as high, or holds NaN or infinite values.

    Examples
    --------
    >>> white = irradiance_harmonics(np.ones((64, 128, 3)))
    >>> white.shade(np.array([[[0.0, 0.6, 0.8]]])).round(2)
    array([[[3.14, 3.14, 3.14]]])
    """
    checked = np.asarray(radiance, dtype=np.float64)
    if checked.ndim != 3 or checked.shape[-1] != 3 or checked.shape[1] != 2 * checked.shape[0]:
        raise RelightlabError(
            f"expected an equirectangular map of shape (h, 2 h, 3), got {checked.shape}"
        )
    if not np.isfinite(checked).all():
        raise RelightlabError("the environment map holds NaN or infinite radiance: repair it")
    height, width = checked.shape[:2]
    to_light = directions(height, width)
    # Rows are bands of the sphere, of area proportional to the difference of cos(polar angle).
    edges = np.cos(np.arange(height + 1) * math.pi / height)
    solid_angle = (edges[:-1] - edges[1:]) * 2.0 * math.pi / width
    weighted = _spherical_harmonics(to_light) * solid_angle[:, None, None]
    coefficients: Float = np.einsum("hwj,hwc->jc", weighted, np.maximum(checked, 0.0))
    return LinearHarmonics(coefficients)


def lights_of_map(radiance: Image, turns: int = TURNS) -> tuple[LogHarmonics, ...]:
    """Return one log-harmonic light per turn of the map about the vertical.

    Each is the log fit of the clamped irradiance over the visible hemisphere, its contrast softened
    by `SOFTENING`, and exposed so that the brightest channel of the brightest visible normal has
    shading 1. That is the exposure of the measured natural lights (nearly all peak between 0.97
    and 1).

    Parameters
    ----------
    radiance : (h, 2 h, 3) array
        Equirectangular, linear.
    turns : int
        Number of lights, evenly spaced about the vertical.

    Returns
    -------
    tuple of LogHarmonics
        Coefficients of shape (9, 3).

    Raises
    ------
    RelightlabError
        As `irradiance_harmonics`, or if the map is black where the object looks.
    """
    irradiance = irradiance_harmonics(radiance)
    angles = [2.0 * math.pi * turn / turns for turn in range(turns)]
    turned = (rotate(irradiance, rotation_about_vertical(angle)) for angle in angles)
    return tuple(_softened_and_exposed(linear_to_log(light)) for light in turned)


def make_table(maps: Sequence[Path]) -> str:
    """Return the JSON text of the table of lights of the given environment maps.

    Parameters
    ----------
    maps : sequence of Path
        OpenEXR files; the table is sorted by their names.

    Returns
    -------
    str
        Coefficients to six decimals.

    Raises
    ------
    RelightlabError
        If there is no map, or one cannot be read.
    """
    if not maps:
        raise RelightlabError("expected a folder with .exr environment maps, found none in it")
    rows: list[dict[str, object]] = []
    for path in sorted(maps, key=lambda path: path.name):
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        for turn, light in enumerate(lights_of_map(read_openexr(path))):
            rows.append(
                {
                    "map": path.stem,
                    "sha256": digest,
                    "degrees": 360 * turn // TURNS,
                    "log": (light.coefficients.round(_DECIMALS) + 0.0).tolist(),
                }
            )
    head = json.dumps({"format": _FORMAT, "provenance": _PROVENANCE}, indent=1)
    body = ",\n".join("  " + json.dumps(row) for row in rows)
    return f'{head[:-2]},\n "lights": [\n{body}\n ]\n}}\n'


def shipped_lights() -> tuple[LogHarmonics, ...]:
    """Return the lights of the table that ships with the project.

    Returns
    -------
    tuple of LogHarmonics
        90 lights, coefficients of shape (9, 3), in the table's order.

    Examples
    --------
    >>> lights = shipped_lights()
    >>> len(lights), lights[0].coefficients.shape
    (90, (9, 3))
    """
    text = resources.files("datasets").joinpath(TABLE_NAME).read_text(encoding="utf-8")
    return tuple(LogHarmonics(np.array(row["log"])) for row in json.loads(text)["lights"])


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the table of lights of a folder's environment maps."""
    parser = argparse.ArgumentParser(
        prog="python -m datasets.environment_maps", description=main.__doc__
    )
    parser.add_argument("folder", type=Path, help="folder of equirectangular .exr maps")
    parser.add_argument("--out", type=Path, default=Path(__file__).with_name(TABLE_NAME))
    given = parser.parse_args(arguments)
    text = make_table(sorted(given.folder.glob("*.exr")))
    with atomic_path(given.out) as path:
        path.write_text(text, encoding="utf-8")


def _softened_and_exposed(light: LogHarmonics) -> LogHarmonics:
    softened = SOFTENING * light.coefficients
    softened[0] -= math.log(LogHarmonics(softened).shade(visible_normals()).max()) / C4
    return LogHarmonics(softened)


def _spherical_harmonics(to_light: Float) -> Float:
    x, y, z = np.moveaxis(to_light, -1, 0)
    return np.stack(
        [
            np.full_like(x, _Y0),
            _Y1 * y,
            _Y1 * z,
            _Y1 * x,
            _Y2 * x * y,
            _Y2 * y * z,
            _Y20 * (3.0 * z * z - 1.0),
            _Y2 * x * z,
            0.5 * _Y2 * (x * x - y * y),
        ],
        axis=-1,
    )


if __name__ == "__main__":
    main()
