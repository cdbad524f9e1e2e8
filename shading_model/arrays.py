"""Array types and the checks every public function makes on them."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from shading_model.errors import RelightlabError

Float: TypeAlias = NDArray[np.float64]
"""Any float64 array."""
Map: TypeAlias = NDArray[np.float64]
"""Scalar map of shape (h, w), NaN outside the mask."""
Normals: TypeAlias = NDArray[np.float64]
"""Unit normals of shape (h, w, 3) as (x right, y up, z toward the viewer), NaN outside the mask."""
Image: TypeAlias = NDArray[np.float64]
"""Linear RGB image of shape (h, w, 3)."""
Mask: TypeAlias = NDArray[np.bool_]
"""Boolean map of shape (h, w), True on the object."""


def check_mask(mask: Mask) -> Mask:
    """Return `mask` as a boolean (h, w) array with at least one pixel.

    Raises
    ------
    RelightlabError
        If the mask is not two-dimensional or selects no pixel.

    Examples
    --------
    >>> int(check_mask(np.eye(3)).sum())
    3
    """
    checked = np.asarray(mask)
    if checked.ndim != 2:
        raise RelightlabError(f"expected a mask of shape (h, w), got shape {checked.shape}")
    checked = checked.astype(bool)
    if not checked.any():
        raise RelightlabError("the mask is empty: mark the object's pixels with values above zero")
    return checked


def check_image(image: Image, mask: Mask) -> Image:
    """Return `image` as float64 (h, w, 3), checked inside `mask`.

    A gray (h, w) image is repeated over three channels. Pixels outside the mask may hold anything.

    Raises
    ------
    RelightlabError
        If the sizes differ, or a pixel inside the mask is NaN, infinite or negative, or the
        image is black all over the mask.

    Examples
    --------
    >>> check_image(np.ones((2, 2)), np.ones((2, 2), bool)).shape
    (2, 2, 3)
    """
    checked = np.asarray(image, dtype=np.float64)
    if checked.ndim == 2:
        checked = np.repeat(checked[..., None], 3, axis=-1)
    if checked.ndim != 3 or checked.shape[-1] != 3:
        raise RelightlabError(
            f"expected an image of shape (h, w, 3) or (h, w), got {np.shape(image)}"
        )
    if checked.shape[:2] != mask.shape:
        raise RelightlabError(
            f"the photograph is {_size(checked.shape)} but its mask is {_size(mask.shape)}:"
            " give a mask of the photograph's size"
        )
    inside = checked[mask]
    if not np.isfinite(inside).all():
        count = int((~np.isfinite(inside)).any(axis=-1).sum())
        raise RelightlabError(f"the photograph has {count} NaN or infinite pixels inside the mask")
    if (inside < 0).any():
        count = int((inside < 0).any(axis=-1).sum())
        raise RelightlabError(f"the photograph has {count} negative pixels inside the mask")
    if not (inside > 0).any():
        raise RelightlabError(
            "the photograph is black all over the mask: there is nothing to relight"
        )
    return checked


def check_map(values: Float, mask: Mask, name: str, channels: int | None = None) -> Float:
    """Return `values` as a float64 map over `mask`, with NaN outside.

    Parameters
    ----------
    values : (h, w) or (h, w, c) array
    mask : (h, w) bool array
    name : str
        How the error message calls the map, in the plural ("normals").
    channels : int, optional
        Expected size c of the last axis; None for a scalar map.

    Raises
    ------
    RelightlabError
        If the shape differs from (h, w) or (h, w, c).

    Examples
    --------
    >>> check_map(np.ones((1, 2)), np.array([[True, False]]), "heights")
    array([[ 1., nan]])
    """
    expected = mask.shape if channels is None else (*mask.shape, channels)
    checked = np.array(values, dtype=np.float64)
    if checked.shape != expected:
        symbolic = "(h, w)" if channels is None else f"(h, w, {channels})"
        raise RelightlabError(
            f"expected {name} of shape {symbolic} = {expected}, got {checked.shape}"
        )
    checked[~mask] = np.nan
    return checked


def _size(shape: tuple[int, ...]) -> str:
    return f"{shape[1]}x{shape[0]} pixels"
