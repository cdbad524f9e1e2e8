"""What the figures of a page are about: a result, the set it was measured on, and its models."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from datasets.records import Capture, Dataset
from evaluation.retinex_thresholds import thresholds_for
from evaluation.sirfs.result import SirfsFit
from reports.base_shape_run import BaseShapeStudy
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics
from shading_model.object_model import (
    ModelParameters,
    ObjectModel,
    assemble_model,
    contour_base,
)
from shading_model.retinex import IntrinsicImages, retinex


@dataclass(frozen=True, eq=False)
class BuiltObject:
    """An object of a dataset with the model built from its photograph.

    Parameters
    ----------
    capture : Capture
    parts : IntrinsicImages
        Albedo and shading by Retinex.
    model : ObjectModel
        The detail source ``default`` of Table 1.
    """

    capture: Capture
    parts: IntrinsicImages
    model: ObjectModel


class Fits(Protocol):
    """Where fits of SIRFS are kept, see `evaluation.sirfs_fits.SirfsFits`."""

    def fit(self, dataset: Dataset, name: str, setting: str) -> SirfsFit:
        """Return the fit to an object's photograph in one setting."""
        ...


@dataclass(frozen=True, eq=False)
class Subject:
    """A result as `evaluation.table1_results.table1_document` has it, and where it came from.

    Parameters
    ----------
    document : dict
    dataset : Dataset
    lights : tuple of LogHarmonics
        The lights of the result, one colour each.
    parameters : ModelParameters
        As the result was measured with.
    fits : Fits, optional
        Those of the result, to be shown; without them no fit is.
    studies : tuple of BaseShapeStudy
        Studies of base shapes to stand in the same report, on this dataset or others.
    """

    document: dict[str, Any]
    dataset: Dataset
    lights: tuple[LogHarmonics, ...]
    parameters: ModelParameters
    fits: Fits | None = None
    studies: tuple[BaseShapeStudy, ...] = ()
    _built: dict[tuple[str, str], BuiltObject] = field(default_factory=dict, repr=False)

    @property
    def objects(self) -> tuple[str, ...]:
        """The objects reported, in the result's order."""
        return tuple(dict.fromkeys(str(row["object"]) for row in self.document["intrinsic"]))

    @property
    def settings(self) -> tuple[str, ...]:
        """The settings reported, in the result's order."""
        return tuple(dict.fromkeys(str(row["setting"]) for row in self.document["intrinsic"]))

    @property
    def photographed_setting(self) -> str:
        """The setting of real photographs where there is one, else the first."""
        return "laboratory" if "laboratory" in self.settings else self.settings[0]

    def preferred(self, names: Sequence[str], count: int) -> tuple[str, ...]:
        """Return `count` reported objects, those of `names` first.

        Parameters
        ----------
        names : sequence of str
            Names that need not be in this dataset.
        count : int
        """
        known = [name for name in names if name in self.objects]
        return tuple(dict.fromkeys([*known, *self.objects]))[:count]

    def built(self, name: str, setting: str) -> BuiltObject:
        """Return an object's model as the protocol of Table 1 builds it; each is built once.

        Parameters
        ----------
        name, setting : str
        """
        key = (name, setting)
        if key not in self._built:
            self._built[key] = build_object(self.dataset, name, setting, self.parameters)
        return self._built[key]

    def fitted(self, name: str, setting: str) -> SirfsFit | None:
        """Return the fit of SIRFS to an object's photograph; None if there is none, or it failed.

        Parameters
        ----------
        name, setting : str
        """
        if self.fits is not None:
            with suppress(RelightlabError):  # the table says which fits failed, and why
                return self.fits.fit(self.dataset, name, setting)
        return None


def build_object(
    dataset: Dataset, name: str, setting: str, parameters: ModelParameters
) -> BuiltObject:
    """Return an object of a dataset with its model, built as the protocol of Table 1 says.

    Parameters
    ----------
    dataset : Dataset
    name, setting : str
    parameters : ModelParameters
        Their Retinex thresholds are used where none were learned for the dataset.

    Returns
    -------
    BuiltObject
    """
    capture = dataset.load(name, setting)
    photograph = capture.photograph
    thresholds = thresholds_for(dataset.name, setting, name) or parameters.thresholds
    parts = retinex(photograph.image, photograph.mask, thresholds)
    shape = contour_base(photograph.mask, parameters)
    return BuiltObject(capture, parts, assemble_model(photograph.mask, shape, parts, parameters))


def varied_lights(lights: Sequence[LogHarmonics], count: int) -> tuple[int, ...]:
    """Return the numbers of `count` lights that differ much: each farthest from those before.

    Lights are compared without their overall brightness (the first coefficient). The first
    chosen is the one farthest from the mean light.

    Parameters
    ----------
    lights : sequence of LogHarmonics
    count : int

    Returns
    -------
    tuple of int
        At most as many as there are lights.

    Examples
    --------
    >>> near, far = np.eye(9)[2], 5 * np.eye(9)[3]
    >>> varied_lights([LogHarmonics(near), LogHarmonics(near), LogHarmonics(far)], 2)
    (2, 0)
    """
    shapes = np.stack([light.coefficients[1:] for light in lights])
    distance = np.linalg.norm(shapes - shapes.mean(axis=0), axis=-1)
    chosen: list[int] = []
    for _ in range(min(count, len(lights))):
        chosen.append(int(np.argmax(distance)))
        away = np.linalg.norm(shapes - shapes[chosen[-1]], axis=-1)
        distance = away if len(chosen) == 1 else np.minimum(distance, away)
    return tuple(chosen)
