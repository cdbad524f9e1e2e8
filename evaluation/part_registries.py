"""Parts that can be replaced, by name: methods, base shapes, detail layers and weight rules.

A part is found by its name in a registry here, by its name in an entry-point group of an installed
package, or as ``module:callable``; a module in the current folder is found too.
"""

from __future__ import annotations

import hashlib
import importlib
import inspect
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

import numpy as np

from datasets.file_tree import file_sha256
from datasets.model_parameters import shipped_parameters
from evaluation.weight_rules import WEIGHT_RULES
from shading_model.arrays import Float, Image, Map, Mask
from shading_model.contour_shape import shape_from_contour
from shading_model.errors import RelightlabError, unknown_name
from shading_model.geometric_detail import geometric_detail
from shading_model.illumination import LogHarmonics
from shading_model.object_model import ObjectModel, build_model


def paper_model(image: Image, mask: Mask) -> ObjectModel:
    """Return the paper's own model at weights (1, 1): a method as any other, for comparison.

    Parameters
    ----------
    image : (h, w, 3) array
    mask : (h, w) bool array

    Returns
    -------
    ObjectModel
    """
    return build_model(image, mask, shipped_parameters())


def contour_height(mask: Mask, image: Image) -> Map:  # noqa: ARG001
    """Return the height of the paper's shape from contour; `image` plays no part.

    Parameters
    ----------
    mask : (h, w) bool array
    image : (h, w, 3) array

    Returns
    -------
    (h, w) array
    """
    return shape_from_contour(mask).height


def flat_height(mask: Mask, image: Image) -> Map:  # noqa: ARG001
    """Return height zero on the mask; `image` plays no part.

    Parameters
    ----------
    mask : (h, w) bool array
    image : (h, w, 3) array

    Returns
    -------
    (h, w) array

    Examples
    --------
    >>> flat_height(np.array([[True, False]]), np.ones((1, 2, 3)))
    array([[ 0., nan]])
    """
    return np.where(mask, 0.0, np.nan)


def sparse_detail(shading: Map, mask: Mask) -> Map:
    """Return the paper's geometric detail, with the shipped dictionary.

    Parameters
    ----------
    shading : (h, w) array
    mask : (h, w) bool array

    Returns
    -------
    (h, w) array
    """
    return geometric_detail(shading, mask, shipped_parameters().dictionary)


def no_detail(shading: Map, mask: Mask) -> Map:  # noqa: ARG001
    """Return a detail layer of zeros; `shading` plays no part.

    Parameters
    ----------
    shading : (h, w) array
    mask : (h, w) bool array

    Returns
    -------
    (h, w) array
    """
    return np.where(mask, 0.0, np.nan)


METHODS: dict[str, Callable[..., Any]] = {"paper-model": paper_model}
"""(image, mask) -> something with ``relight(illumination) -> (h, w, 3)``."""
SHAPES: dict[str, Callable[..., Any]] = {"contour": contour_height, "flat": flat_height}
"""(mask, image) -> height in pixels."""
DETAIL_LAYERS: dict[str, Callable[..., Any]] = {"sparse": sparse_detail, "none": no_detail}
"""(shading, mask) -> what takes the place of S_g."""


@dataclass(frozen=True)
class PartKind:
    """A kind of part: what it is called, its entry-point group, and what is shipped."""

    words: str
    group: str
    registry: Mapping[str, Callable[..., Any]]


KINDS: dict[str, PartKind] = {
    "method": PartKind("method", "relightlab.methods", METHODS),
    "shape": PartKind("base shape", "relightlab.shapes", SHAPES),
    "detail-layer": PartKind("detail layer", "relightlab.detail_layers", DETAIL_LAYERS),
    "weight-rule": PartKind("weight rule", "relightlab.weight_rules", WEIGHT_RULES),
}


@dataclass(frozen=True)
class Part:
    """A part that was found; it can be sent to another process, which finds it again.

    Parameters
    ----------
    kind : str
        A key of `KINDS`.
    word : str
        What the user wrote.
    name : str
        The callable's attribute ``name`` if it has one, else the word.
    identity : str
        Changes with the name, the attribute ``version`` or the source file: what results depend on.
    """

    kind: str
    word: str
    name: str
    identity: str

    def load(self) -> Callable[..., Any]:
        """Return the callable."""
        return _loaded(self.kind, self.word)

    def relit(
        self, image: Image, mask: Mask, lights: Mapping[str, LogHarmonics]
    ) -> Mapping[str, Float]:
        """Return what a method makes of a photograph under each light, by the light's name."""
        built = self.load()(image.copy(), mask.copy())
        return {name: np.asarray(built.relight(light)) for name, light in lights.items()}


def find_part(kind: str, word: str) -> Part:
    """Return a part by its name or as ``module:callable``.

    Parameters
    ----------
    kind : str
        A key of `KINDS`.
    word : str

    Returns
    -------
    Part

    Raises
    ------
    RelightlabError
        If the name is unknown, or the module or callable cannot be found.

    Examples
    --------
    >>> find_part("shape", "flat").name
    'flat'
    >>> find_part("shape", "contuor")
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: Unknown base shape 'contuor'. Did you mean 'contour'? ...
    """
    found = _loaded(kind, word)
    name = getattr(found, "name", None)
    name = name if isinstance(name, str) and name else word
    return Part(kind, word, name, _identity(found, name))


@cache
def _loaded(kind: str, word: str) -> Callable[..., Any]:
    known = KINDS[kind]
    if ":" in word:
        return _imported(known.words, word)
    if word in known.registry:
        return known.registry[word]
    installed = {point.name: point for point in entry_points(group=known.group)}
    if word in installed:
        return _imported(known.words, _value(installed[word]))
    raise unknown_name(known.words, word, [*known.registry, *sorted(installed)])


def _value(point: EntryPoint) -> str:
    return f"{point.module}:{point.attr}"


def _imported(words: str, word: str) -> Callable[..., Any]:
    module_name, _, path = word.partition(":")
    here = str(Path.cwd())
    if here not in sys.path:
        # Last, so that it hides no installed package.
        sys.path.append(here)
    try:
        found: Any = importlib.import_module(module_name)
    except Exception as error:  # a module of the user's may raise anything
        raise RelightlabError(
            f"cannot import the {words} {word!r}: {type(error).__name__}: {error}"
        ) from error
    for part in path.split("."):
        if not hasattr(found, part):
            public = [name for name in vars(found) if not name.startswith("_")]
            raise unknown_name(f"attribute of {module_name}", part, public)
        found = getattr(found, part)
    if not callable(found):
        raise RelightlabError(f"expected {word!r} to be callable, got {type(found).__name__}")
    made: Callable[..., Any] = found
    return made


def _identity(found: Callable[..., Any], name: str) -> str:
    module = sys.modules.get(getattr(found, "__module__", None) or type(found).__module__)
    source = inspect.getsourcefile(module) if module is not None else None
    content = file_sha256(Path(source)) if source else ""
    document = "\0".join([name, str(getattr(found, "version", "")), content])
    return hashlib.sha256(document.encode()).hexdigest()
