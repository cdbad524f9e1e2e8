"""One distant light, fitted to the shading of a diffuse sphere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shading_model.arrays import Float, Normals

_LIT = 0.1
_MOST_ROUNDS = 30


@dataclass(frozen=True, eq=False)
class DistantLight:
    """One distant light fitted to a diffuse sphere: ``shading = intensity * max(0, N . d)``.

    Parameters
    ----------
    direction : (3,) array
        Unit vector d toward the light (x right, y up, z toward the viewer).
    intensity : float
        Shading of a surface that faces the light, mean over the colours.
    residual : float
        Root mean square difference from the picture, relative to that of the picture.
    """

    direction: Float
    intensity: float
    residual: float


def fit_distant_light(normals: Normals, shading: Float) -> DistantLight | None:
    """Return the distant light whose ``intensity * max(0, N . d)`` is nearest to a shading.

    Least squares over the normals that face the light, found anew until they stay the same.

    Parameters
    ----------
    normals : (n, 3) array
        Unit normals, finite.
    shading : (n,) array
        At least zero, somewhere above it.

    Returns
    -------
    DistantLight or None
        None if the nearest light has no intensity.

    Examples
    --------
    >>> from shading_model.harmonic_conversion import visible_normals
    >>> normals = visible_normals()
    >>> light = fit_distant_light(normals, np.maximum(0, normals @ [1.2, 0.0, 1.6]))
    >>> light.direction.round(6) + 0.0, round(light.intensity, 6)
    (array([0.6, 0. , 0.8]), 2.0)
    """
    lit = shading > _LIT * shading.max()
    toward = np.zeros(3)
    for _ in range(_MOST_ROUNDS):
        facing = normals[lit]
        toward = np.linalg.pinv(facing.T @ facing, hermitian=True) @ (facing.T @ shading[lit])
        faces = normals @ toward > 0
        if not faces.any() or (faces == lit).all():
            break
        lit = faces
    intensity = float(np.linalg.norm(toward))
    if intensity == 0:
        return None
    residual = relative_difference(np.maximum(normals @ toward, 0.0), shading)
    return DistantLight(toward / intensity, intensity, residual)


def relative_difference(found: Float, picture: Float) -> float:
    """Return the root mean square of ``found - picture`` over that of the picture.

    Parameters
    ----------
    found, picture : arrays of one shape
        Finite; the picture is not zero all over.

    Returns
    -------
    float

    Examples
    --------
    >>> relative_difference(np.array([1.0, 1.0]), np.array([1.0, 0.0]))
    1.0
    """
    return float(np.sqrt(np.mean((found - picture) ** 2) / np.mean(picture**2)))
