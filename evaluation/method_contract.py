"""What every method and part has to keep to, tried on a small ball before anything is measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from datasets.model_parameters import shipped_parameters
from evaluation.model_parts import ModelParts
from evaluation.part_registries import Part
from evaluation.rerendering import RerenderingCell
from evaluation.weight_rules import CellGrid, checked_weights
from shading_model.arrays import Float, Image, Mask
from shading_model.errors import RelightlabError
from shading_model.height_field import normals_of_height
from shading_model.illumination import LogHarmonics
from shading_model.retinex import IntrinsicImages

HEIGHT, WIDTH = 48, 64
LIGHTS = (
    LogHarmonics(np.array([0.2, 0.6, 0.3, 0.7, 0.1, 0.0, 0.1, -0.1, 0.2])),
    LogHarmonics(np.array([0.2, -0.5, 0.3, -0.8, 0.0, 0.1, 0.1, 0.2, -0.1])),
)
"""From above on the right, and from below on the left."""


def check_method(method: Part) -> None:
    """Try a method on a small object, whole and with a hole.

    Parameters
    ----------
    method : Part
        Of kind ``method``.

    Raises
    ------
    RelightlabError
        With all that the method got wrong.

    Examples
    --------
    >>> from evaluation.part_registries import find_part
    >>> check_method(find_part("method", "paper-model"))
    """
    build = method.load()
    faults = list(_faults(build, *contract_object()))
    if not faults:
        faults = [f"with a hole in the mask, {f}" for f in _faults(build, *contract_object(True))]
    if faults:
        raise RelightlabError(f"the method {method.name!r} cannot take part: {'; '.join(faults)}")


def check_parts(parts: ModelParts) -> None:
    """Try a base shape and a detail layer on the small object, whole and with a hole.

    Parameters
    ----------
    parts : ModelParts

    Raises
    ------
    RelightlabError
        With what one of them got wrong.

    Examples
    --------
    >>> from evaluation.part_registries import find_part
    >>> check_parts(ModelParts(find_part("shape", "flat"), find_part("detail-layer", "none")))
    """
    parameters = shipped_parameters()
    for hole in (False, True):
        image, mask = contract_object(hole)
        gray = np.where(mask, image.mean(axis=-1) + 0.1, np.nan)
        try:
            base = parts.base(mask, image, parameters)
            if parts.detail_layer is not None:
                images = IntrinsicImages(np.where(mask[..., None], image, np.nan), gray)
                parts.assemble(mask, base, images, parameters)
        except RelightlabError:
            raise
        except Exception as error:  # a part may raise anything
            names = " or ".join(p.name for p in (parts.shape, parts.detail_layer) if p is not None)
            raise RelightlabError(
                f"{names} cannot take part: it raised {type(error).__name__}: {error}"
            ) from error


def check_weight_rule(rule: Part) -> None:
    """Try a weight rule on a small grid of cells.

    Parameters
    ----------
    rule : Part
        Of kind ``weight-rule``.

    Raises
    ------
    RelightlabError
        If it raises, or its weights have another shape.

    Examples
    --------
    >>> from evaluation.part_registries import find_part
    >>> check_weight_rule(find_part("weight-rule", "regression"))
    """
    gram, cross = np.diag([1.0, 0.1, 0.01]), np.array([0.9, 0.05, 0.005])
    cells = tuple(
        tuple(RerenderingCell(gram, cross * (1 + 0.01 * (k + j)), 1.0) for j in range(len(LIGHTS)))
        for k in range(3)
    )
    grid = CellGrid(cells, np.stack([light.coefficients for light in LIGHTS]))
    try:
        checked_weights(grid, rule.name, rule.load())
    except RelightlabError:
        raise
    except Exception as error:  # a rule may raise anything
        raise RelightlabError(
            f"the weight rule {rule.name!r} cannot take part: it raised {type(error).__name__}:"
            f" {error}"
        ) from error


def contract_object(hole: bool = False) -> tuple[Image, Mask]:
    """Return a photograph of a painted ball that is not square, and its mask.

    Parameters
    ----------
    hole : bool
        Whether the mask has a hole in the middle.

    Returns
    -------
    (h, w, 3) array, (h, w) bool array

    Examples
    --------
    >>> image, mask = contract_object()
    >>> image.shape, int(mask.sum()) > int(contract_object(True)[1].sum())
    ((48, 64, 3), True)
    """
    rows, columns = np.mgrid[:HEIGHT, :WIDTH] - np.array([HEIGHT, WIDTH])[:, None, None] / 2 + 0.5
    squared = rows**2 + columns**2
    mask: Mask = (squared < 20**2) & ~(hole & (squared < 5**2))
    height = np.sqrt(np.maximum(20.5**2 - squared, 0.0))
    height[~mask] = np.nan
    shading = LogHarmonics(0.5 * LIGHTS[0].coefficients).shade(normals_of_height(height))
    paint = np.where((rows > 0)[..., None], [0.5, 0.3, 0.2], [0.1, 0.2, 0.4])
    image = np.clip(paint * np.nan_to_num(shading)[..., None], 0.0, 1.0)
    return image, mask


def _faults(build: Callable[..., Any], image: Image, mask: Mask) -> Iterator[str]:
    given_image, given_mask = image.copy(), mask.copy()
    try:
        results = [_relit(build, given_image, given_mask) for _ in range(2)]
    except _ContractError as fault:
        yield str(fault)
        return
    if not (np.array_equal(given_image, image) and np.array_equal(given_mask, mask)):
        yield "it changed the image or the mask it was given: work on a copy"
    first, second = ([image[mask] for image in images] for images in results)
    if not all(np.array_equal(a, b) for a, b in zip(first, second, strict=True)):
        yield "the same photograph gave another result the second time: seed what is random"
    if np.array_equal(first[0], first[1]):
        yield "relight returned the same image under two different lights"


class _ContractError(Exception):
    """A fault after which nothing else can be tried."""


def _relit(build: Callable[..., Any], image: Image, mask: Mask) -> list[Float]:
    model = _called("build", build, image, mask)
    relight = getattr(model, "relight", None)
    if not callable(relight):
        raise _ContractError(f"build returned {type(model).__name__}, which has no relight")
    return [_checked(_called("relight", relight, light), mask) for light in LIGHTS]


def _called(words: str, function: Callable[..., Any], *arguments: Any) -> Any:
    try:
        return function(*arguments)
    except Exception as error:  # a method may raise anything
        raise _ContractError(f"{words} raised {type(error).__name__}: {error}") from error


def _checked(image: Any, mask: Mask) -> Float:
    expected = (*mask.shape, 3)
    if np.shape(image) != expected:
        raise _ContractError(f"relight returned shape {np.shape(image)}, expected {expected}")
    values = np.asarray(image)
    if values.dtype.kind not in "fiu":
        raise _ContractError(f"relight returned values of type {values.dtype}, expected numbers")
    wrong = int((~np.isfinite(values[mask])).any(axis=-1).sum())
    if wrong:
        raise _ContractError(f"relight returned {wrong} pixels in the mask that are not finite")
    return np.array(values, dtype=np.float64)
