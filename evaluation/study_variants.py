"""The ways in which Table 2 is measured: what models are built from, and what is changed.

`mean` is the table; the others show how far its order hangs on a choice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from datasets.records import Capture, LitPhotograph
from datasets.time_of_flight import KINECT_II, TimeOfFlightSensor
from shading_model.arrays import Image
from shading_model.errors import RelightlabError
from shading_model.harmonic_conversion import log_to_linear
from shading_model.illumination import Illumination, LogHarmonics


@dataclass(frozen=True, eq=False)
class BuildImages:
    """What the models for some of the lights are built from.

    Parameters
    ----------
    image : (h, w, 3) array
        The diffusely lit image.
    photographs : tuple of (h, w, 3) arrays
        What a shape from several photographs may use.
    lights : tuple of int
        The lights that these models are tested under.
    """

    image: Image
    photographs: tuple[Image, ...]
    lights: tuple[int, ...]


Build = Callable[[Capture, Sequence[LitPhotograph]], Iterator[BuildImages]]


@dataclass(frozen=True)
class Variant:
    """One way of measuring.

    Parameters
    ----------
    words : str
        What a table calls it.
    build : callable
        Capture and photographs to one or more `BuildImages` that cover every light once.
    height : float
        Times the height of every shape.
    light : callable
        The light of a photograph as the model is lit.
    match_exposure : bool
        See `evaluation.photograph_cells.photograph_cell`.
    needs_diffuse : bool
        Whether it needs a diffusely lit photograph that is not the mean of the others.
    sensor : TimeOfFlightSensor
        What is simulated where a set has no depth sensor of its own.
    """

    words: str
    build: Build
    height: float = 1.0
    light: Callable[[LogHarmonics], Illumination] = lambda light: light
    match_exposure: bool = True
    needs_diffuse: bool = False
    sensor: TimeOfFlightSensor = KINECT_II


def mean_of_photographs(_: Capture, lit: Sequence[LitPhotograph]) -> Iterator[BuildImages]:
    """Yield the mean of all photographs, for all lights.

    Parameters
    ----------
    _ : Capture
    lit : sequence of LitPhotograph

    Yields
    ------
    BuildImages
    """
    images = _images(lit)
    yield BuildImages(np.mean(images, axis=0), images, tuple(range(len(images))))


def diffuse_photograph(capture: Capture, lit: Sequence[LitPhotograph]) -> Iterator[BuildImages]:
    """Yield the diffusely lit photograph, for all lights.

    Parameters
    ----------
    capture : Capture
    lit : sequence of LitPhotograph

    Yields
    ------
    BuildImages
    """
    images = _images(lit)
    yield BuildImages(capture.photograph.image, images, tuple(range(len(images))))


def leave_one_out(_: Capture, lit: Sequence[LitPhotograph]) -> Iterator[BuildImages]:
    """Yield, for each light, the mean of the other photographs.

    A shape from several photographs may use those of the other parity of number: half of them,
    and never the one under test, so that two fits serve all lights.

    Parameters
    ----------
    _ : Capture
    lit : sequence of LitPhotograph

    Yields
    ------
    BuildImages

    Raises
    ------
    RelightlabError
        For fewer than two photographs.
    """
    images = _images(lit)
    if len(images) < 2:
        raise RelightlabError("leaving one photograph out needs at least two, got one")
    total = np.sum(images, axis=0)
    for index, image in enumerate(images):
        others = np.maximum(total - image, 0.0) / (len(images) - 1)
        yield BuildImages(others, images[1 - index % 2 :: 2], (index,))


TABLE = "mean"
SMALL_OBJECT = replace(KINECT_II, object_mm=100.0)
"""How large an object is to a sensor is not recorded: `KINECT_II` takes 200 mm at one metre, as
the paper's bears and bags may be; those of MIT-Berkeley are smaller toys."""
VARIANTS: dict[str, Variant] = {
    TABLE: Variant("mean of the photographs", mean_of_photographs),
    "leave-one-out": Variant("mean of the other photographs", leave_one_out),
    "diffuse": Variant("the diffuse photograph", diffuse_photograph, needs_diffuse=True),
    "half-height": Variant("half the height", mean_of_photographs, height=0.5),
    "double-height": Variant("twice the height", mean_of_photographs, height=2.0),
    "linear-light": Variant("linear harmonics", mean_of_photographs, light=log_to_linear),
    "own-exposure": Variant("lights at their own scale", mean_of_photographs, match_exposure=False),
    "small-object": Variant(
        "an object of 100 mm before the simulated sensor", mean_of_photographs, sensor=SMALL_OBJECT
    ),
}
"""Every variant; a new one is a line here."""


def _images(lit: Sequence[LitPhotograph]) -> tuple[Image, ...]:
    images = tuple(one.photograph.image for one in lit)
    if not images:
        raise RelightlabError("the object has no photographs under known lights")
    return images
