"""From measured lights to those a prior is learned from.

Natural lights are made milder in colour, stronger and mirrored; laboratory lights are mirrored and
their colours exchanged. Both are kept only where they are valid (`are_valid`).
"""

from __future__ import annotations

from itertools import permutations
from pathlib import Path

import numpy as np

from datasets.mit_berkeley import OBJECTS, TRAINING_OBJECTS
from datasets.training_lights import (
    RELEASED_NAMES,
    environment_lights,
    fitted_lights,
    photographed_lights,
    released_gaussian,
)
from evaluation.sirfs.light_prior import LightPrior, light_prior
from shading_model.arrays import Float, Mask
from shading_model.illumination import C4, harmonics
from shading_model.seeds import generator_for

CHROMA_FACTORS = (2.0**-1, 2.0**-1.5, 2.0**-2)
GAINS = (2.5, 3.0, 3.5)
NEAR = 2.0
"""Squared distance of log renderings on a 32x32 disk below which lights are near duplicates."""
_COARSE, _MEDIUM, _FINE = 32, 64, 256  # pixels along a disk
_DARKEST_CENTRE = -2.0
_TURNED_BY_MIRROR = (3, 4, 7)  # x, xy, xz


def light_priors(root: Path) -> dict[tuple[str, str], LightPrior]:
    """Return the priors of natural and laboratory light, in colour and gray.

    Parameters
    ----------
    root : Path
        The folder of the MIT-Berkeley set.

    Returns
    -------
    dict
        By ``(light, channels)``, such as ``("natural", "gray")``.

    Raises
    ------
    RelightlabError
        If a file of the set is missing or damaged.

    Examples
    --------
    >>> light_priors(Path("nowhere"))
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: no such file: ...
    """
    known = photographed_lights(root, OBJECTS)
    kinds = {
        "natural": natural_training_lights(environment_lights(root), known),
        "laboratory": laboratory_training_lights(
            np.concatenate([fitted_lights(root, name) for name in TRAINING_OBJECTS])
        ),
    }
    in_color = {(kind, "color"): light_prior(lights) for kind, lights in kinds.items()}
    return in_color | {
        (kind, "gray"): light_prior(lights.mean(axis=2)) for kind, lights in kinds.items()
    }


def released_light_priors(data_root: Path) -> dict[tuple[str, str], LightPrior]:
    """Return the Gaussians of coloured lights that boundary-cues ships, as priors.

    Parameters
    ----------
    data_root : Path
        Folder that holds ``boundary-cues/``.

    Returns
    -------
    dict
        By ``(light, "color")``.

    Raises
    ------
    RelightlabError
        If the file is missing or damaged.

    Examples
    --------
    >>> released_light_priors(Path("nowhere"))
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: no such file: ...
    """
    priors: dict[tuple[str, str], LightPrior] = {}
    for kind in RELEASED_NAMES:
        released = released_gaussian(data_root, kind)
        count = len(released.lights)
        priors[kind, "color"] = LightPrior(released.mean, released.covariance, count)
    return priors


def natural_training_lights(environments: Float, known: Float) -> Float:
    """Return the random half of the natural lights that priors are learned from.

    Environments and their mirror images, milder in colour (three factors) and stronger (three
    factors); valid ones only, scaled so that the brightest frontal log shading is zero, without
    near duplicates of earlier ones, nor of lights that photographs of the set are lit by.

    Parameters
    ----------
    environments : (n, 9, 3) array
    known : (m, 9, 3) array
        Lights to stay away from.

    Returns
    -------
    (k, 9, 3) array

    Examples
    --------
    >>> lights = np.zeros((4, 9, 3))
    >>> lights[:, 2] = np.array([0.2, 0.4, 0.6, 0.8])[:, None]
    >>> natural_training_lights(lights, np.empty((0, 9, 3))).shape[1:]
    (9, 3)
    """
    both = np.concatenate([environments, mirrored(environments)])
    milder = np.concatenate([with_chroma(both, factor) for factor in CHROMA_FACTORS])
    stronger = np.concatenate([gain * milder for gain in GAINS])
    scaled = brightest_at_zero(stronger[are_valid(stronger)])
    distinct = without_near_duplicates(np.concatenate([brightest_at_zero(known), scaled]))
    kept = scaled[distinct[len(known) :]]
    order = generator_for("sirfs", "natural lights").permutation(len(kept))
    half: Float = kept[np.sort(order[: len(kept) // 2])]
    return half


def laboratory_training_lights(fitted: Float) -> Float:
    """Return the laboratory lights that priors are learned from.

    The valid ones, of these the likelier half under their own Gaussian, each with its colours in
    all six orders, each with its mirror image.

    Parameters
    ----------
    fitted : (n, 9, 3) array

    Returns
    -------
    (k, 9, 3) array

    Examples
    --------
    >>> lights = np.random.default_rng(0).normal(size=(40, 9, 3)) * 0.2
    >>> lights[:, 2] += 1
    >>> len(laboratory_training_lights(lights))
    240
    """
    valid = fitted[are_valid(fitted)]
    vectors = valid.reshape(len(valid), -1)
    centred = vectors - vectors.mean(axis=0)
    precision = np.linalg.pinv(np.cov(vectors, rowvar=False))
    distances = np.einsum("ni,ij,nj->n", centred, precision, centred)
    likelier = valid[distances < np.median(distances)]
    orders = [likelier[:, :, list(order)] for order in permutations(range(3))]
    colored = np.concatenate(orders)
    return np.concatenate([colored, mirrored(colored)])


def mirrored(lights: Float) -> Float:
    """Return lights with left and right exchanged.

    Parameters
    ----------
    lights : (n, 9, c) array

    Examples
    --------
    >>> mirrored(np.ones((1, 9, 1)))[0, :, 0]
    array([ 1.,  1.,  1., -1., -1.,  1.,  1., -1.,  1.])
    """
    turned = lights.copy()
    turned[:, _TURNED_BY_MIRROR] *= -1
    return turned


def with_chroma(lights: Float, factor: float) -> Float:
    """Return lights whose channels differ so many times as much from their mean.

    Parameters
    ----------
    lights : (n, 9, 3) array
    factor : float

    Examples
    --------
    >>> with_chroma(np.array([[[1.0, 2.0, 3.0]]]), 0.5)
    array([[[1.5, 2. , 2.5]]])
    """
    mean = lights.mean(axis=2, keepdims=True)
    changed: Float = mean + factor * (lights - mean)
    return changed


def are_valid(lights: Float) -> Mask:
    """Return which lights come from the front and do not leave the centre dark.

    Of their gray log shading: the largest over the frontal hemisphere is no less than that over
    the other, and that toward the viewer is above -2.

    Parameters
    ----------
    lights : (n, 9, 3) array

    Returns
    -------
    (n,) bool array

    Examples
    --------
    >>> front = np.zeros((2, 9, 3))
    >>> front[:, 2] = np.array([1.0, -1.0])[:, None]
    >>> are_valid(front)
    array([ True, False])
    """
    gray = lights.mean(axis=2).T
    front = disk_normals(_MEDIUM)
    frontal = (harmonics(front) @ gray).max(axis=0)
    behind = (harmonics(front * [1.0, 1.0, -1.0]) @ gray).max(axis=0)
    centre = harmonics(np.array([0.0, 0.0, 1.0])) @ gray
    valid: Mask = (frontal >= behind) & (centre > _DARKEST_CENTRE)
    return valid


def brightest_at_zero(lights: Float) -> Float:
    """Return lights whose largest log shading, over front and channels, is moved to zero.

    Parameters
    ----------
    lights : (n, 9, 3) array

    Examples
    --------
    >>> brightest_at_zero(np.ones((1, 9, 3)) * np.eye(9)[0][:, None])[0, 0].round(3) + 0.0
    array([0., 0., 0.])
    """
    shifted = lights.copy()
    basis = harmonics(disk_normals(_FINE))
    for light in shifted:
        light[0] -= (basis @ light).max() / C4
    return shifted


def without_near_duplicates(lights: Float) -> Mask:
    """Return which lights do not render nearly like an earlier one that is kept.

    Parameters
    ----------
    lights : (n, 9, 3) array
        Brightest at zero.

    Returns
    -------
    (n,) bool array

    Examples
    --------
    >>> without_near_duplicates(np.zeros((2, 9, 3)))
    array([ True, False])
    """
    basis = harmonics(disk_normals(_COARSE))
    rendered = np.einsum("pk,nkc->npc", basis, lights).reshape(len(lights), -1)
    squares = (rendered**2).sum(axis=1)
    distances = squares[:, None] + squares - 2 * rendered @ rendered.T
    kept = np.ones(len(lights), dtype=bool)
    for index in range(len(lights)):
        if kept[index]:
            kept[index + 1 :] &= distances[index, index + 1 :] >= NEAR
    return kept


def disk_normals(size: int) -> Float:
    """Return the normals of a frontal hemisphere seen in size x size pixels.

    Parameters
    ----------
    size : int
        Even: one pixel then looks straight at the viewer.

    Returns
    -------
    (n, 3) array

    Examples
    --------
    >>> disk_normals(4).shape
    (9, 3)
    """
    steps = (np.arange(1, size + 1) - size / 2) / (size / 2)
    right, up = np.meshgrid(steps, -steps)
    inside = right**2 + up**2 < 1
    x, y = right[inside], up[inside]
    return np.stack([x, y, np.sqrt(1 - x**2 - y**2)], axis=-1)
