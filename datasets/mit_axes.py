"""The axes of the MIT-Berkeley files, converted at the door to the project's.

Their first axis runs down the rows, the second right along the columns, the third toward the
viewer; the project's run x right, y up, z toward the viewer. So x = N2, y = -N1, z = N3.
"""

from __future__ import annotations

import numpy as np

from shading_model.arrays import Float, Normals
from shading_model.errors import RelightlabError

# Project coefficient j is SIGNS[j] times their coefficient ORDER[j]: put N1 = -y, N2 = x, N3 = z
# into their basis and read off which of our harmonics each of theirs became.
_ORDER = (0, 3, 2, 1, 4, 7, 6, 5, 8)
_SIGNS = (1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0, -1.0)


def harmonics_from_mit_axes(coefficients: Float) -> Float:
    """Return spherical-harmonic coefficients in the project's axes.

    Parameters
    ----------
    coefficients : (9,) or (9, c) array
        As stored in the MIT-Berkeley files: for normals (row down, column right, to the viewer).

    Returns
    -------
    array of the same shape
        Coefficients for `shading_model.illumination.harmonics`: the same shading of the same
        surface; only signs and order change.

    Raises
    ------
    RelightlabError
        If the first axis does not hold nine coefficients.

    Examples
    --------
    >>> harmonics_from_mit_axes(np.arange(9.0))
    array([ 0., -3.,  2.,  1., -4., -7.,  6.,  5., -8.])
    """
    given = np.asarray(coefficients, dtype=np.float64)
    if given.ndim == 0 or given.shape[0] != 9:
        raise RelightlabError(
            f"expected spherical-harmonic coefficients of shape (9,) or (9, c), got {given.shape}"
        )
    signs = np.reshape(_SIGNS, (9,) + (1,) * (given.ndim - 1))
    converted: Float = given[list(_ORDER)] * signs
    return converted


def normals_from_mit_axes(normals: Normals) -> Normals:
    """Return normals (N1 row down, N2 column right, N3 to the viewer) as (x, y, z).

    Parameters
    ----------
    normals : (..., 3) array
        NaN stays NaN.

    Raises
    ------
    RelightlabError
        If the last axis does not hold three components.

    Examples
    --------
    >>> normals_from_mit_axes(np.array([1.0, 0.0, 0.0]))
    array([ 0., -1.,  0.])
    """
    given = np.asarray(normals, dtype=np.float64)
    if given.ndim == 0 or given.shape[-1] != 3:
        raise RelightlabError(f"expected normals of shape (..., 3), got {given.shape}")
    # 0.0 - N1 rather than -N1: a zero stays +0.
    return np.stack([given[..., 1], 0.0 - given[..., 0], given[..., 2]], axis=-1)
