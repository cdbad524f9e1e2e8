"""Patterns on the picture plane: smooth noise, cells and grooves, for relief and for paint.

Coordinates run from -1 to 1 over the picture; randomness comes from the generator passed in.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from shading_model.arrays import Float, Map, Mask

_WAVES = 24


def smooth_noise(x: Map, y: Map, frequency: float, generator: np.random.Generator) -> Map:
    """Return a sum of random plane waves of about one wavelength, with unit variance.

    Parameters
    ----------
    x, y : (h, w) arrays
        Coordinates.
    frequency : float
        Periods per unit length.
    generator : numpy.random.Generator
        Advanced by a fixed number of draws.

    Returns
    -------
    (h, w) array

    Examples
    --------
    >>> y, x = np.mgrid[-1:1:50j, -1:1:50j]
    >>> noise = smooth_noise(x, y, 3.0, np.random.default_rng(0))
    >>> bool(0.5 < noise.std() < 1.5)
    True
    """
    angles = generator.uniform(0.0, 2.0 * np.pi, _WAVES)
    lengths = 2.0 * np.pi * frequency * generator.uniform(0.6, 1.4, _WAVES)
    phases = generator.uniform(0.0, 2.0 * np.pi, _WAVES)
    total = np.zeros(np.shape(x))
    for angle, length, phase in zip(angles, lengths, phases, strict=True):
        total += np.cos(length * (np.cos(angle) * x + np.sin(angle) * y) + phase)
    noise: Map = total * np.sqrt(2.0 / _WAVES)
    return noise


def cells(
    x: Map, y: Map, count: int, generator: np.random.Generator, wobble: float = 0.05
) -> tuple[Map, Map]:
    """Return the index of the nearest of `count` random centres, and the distance to the border.

    Parameters
    ----------
    x, y : (h, w) arrays
        Coordinates from -1 to 1.
    count : int
        Number of centres.
    generator : numpy.random.Generator
        Places the centres and bends the borders.
    wobble : float
        How far the borders are bent.

    Returns
    -------
    index : (h, w) array of whole numbers
    border : (h, w) array
        Half the difference between the distances to the two nearest centres.

    Examples
    --------
    >>> y, x = np.mgrid[-1:1:20j, -1:1:20j]
    >>> index, border = cells(x, y, 5, np.random.default_rng(1))
    >>> sorted(set(index.ravel().tolist())) == [0.0, 1.0, 2.0, 3.0, 4.0]
    True
    """
    centres = generator.uniform(-1.0, 1.0, (count, 2))
    bent_x = x + wobble * smooth_noise(x, y, 1.5, generator)
    bent_y = y + wobble * smooth_noise(x, y, 1.5, generator)
    found = cKDTree(centres).query(np.stack([bent_x, bent_y], axis=-1), k=2)
    distances, indices = np.asarray(found[0]), np.asarray(found[1])
    border: Map = 0.5 * (distances[..., 1] - distances[..., 0])
    return indices[..., 0].astype(np.float64), border


def grooves(phase: Map, sharpness: float = 3.0) -> Map:
    """Return narrow valleys of depth 1 at whole numbers of `phase`, flat at 0 between.

    Examples
    --------
    >>> (grooves(np.array([0.0, 0.5, 1.0])).round(3) + 0.0).tolist()
    [-1.0, -0.05, -1.0]
    """
    return -np.exp(sharpness * (np.cos(2.0 * np.pi * phase) - 1.0) / 2.0)


def smooth_step(values: Float, width: float) -> Float:
    """Return 0 below zero, 1 above `width`, and a smooth rise between.

    Examples
    --------
    >>> smooth_step(np.array([-1.0, 0.5, 2.0]), 1.0)
    array([0. , 0.5, 1. ])
    """
    share = np.clip(values / width, 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)


def bump(x: Map, y: Map, centre: tuple[float, float], radii: tuple[float, float]) -> Map:
    """Return a Gaussian bump of height 1.

    Examples
    --------
    >>> bump(np.array([[0.0]]), np.array([[0.0]]), (0.0, 0.0), (1.0, 1.0))
    array([[1.]])
    """
    return np.exp(-(((x - centre[0]) / radii[0]) ** 2 + ((y - centre[1]) / radii[1]) ** 2))


def turned(x: Map, y: Map, degrees: float) -> tuple[Map, Map]:
    """Return coordinates along axes turned anticlockwise.

    Examples
    --------
    >>> along, across = turned(np.array([[0.0]]), np.array([[1.0]]), 90.0)
    >>> along.round(6), across.round(6)
    (array([[1.]]), array([[0.]]))
    """
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return cosine * x + sine * y, cosine * y - sine * x


def on_object(inside: Mask, height: Map) -> Map:
    """Return the height inside, NaN elsewhere.

    Examples
    --------
    >>> on_object(np.array([[True, False]]), np.array([[1.0, 2.0]]))
    array([[ 1., nan]])
    """
    return np.where(inside, height, np.nan)
