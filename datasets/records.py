"""The records every source of pictures yields, whatever its files look like.

Arrays are (row, column); normals (x right, y up, z toward the viewer); heights in pixels, larger
is nearer; intensities linear; NaN outside the mask in every map but the photograph itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from shading_model.arrays import Image, Map, Mask, Normals
from shading_model.illumination import LogHarmonics


@dataclass(frozen=True, eq=False)
class Photograph:
    """A linear RGB photograph of one object.

    Parameters
    ----------
    image : (h, w, 3) float64 array
        Linear intensities in [0, 1]; the background may hold anything finite.
    mask : (h, w) bool array
        True on the object.
    name : str
        The object's name.
    source : str
        Where it came from: a file, or the generator that made it.
    """

    image: Image
    mask: Mask
    name: str
    source: str


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """What is known of a photograph; a part that is not known is None.

    Parameters
    ----------
    height : (h, w) array
        Pixels, NaN where unknown.
    normals : (h, w, 3) array
        Unit normals of `height`, NaN where unknown (also on the ring where a derivative is).
    albedo : (h, w, 3) array
        Up to scale.
    shading : (h, w, 3) array
        Scale consistent with ``image = albedo * shading``.
    illumination : LogHarmonics
        Coefficients of shape (9, 3): the generator of `shading`, or fitted to it.
    """

    height: Map | None = None
    normals: Normals | None = None
    albedo: Image | None = None
    shading: Image | None = None
    illumination: LogHarmonics | None = None


@dataclass(frozen=True, eq=False)
class LitPhotograph:
    """A photograph and the calibrated light it was taken under."""

    photograph: Photograph
    illumination: LogHarmonics


@dataclass(frozen=True, eq=False)
class Capture:
    """One object in one setting: the photograph models are built from, and its truth."""

    photograph: Photograph
    truth: GroundTruth
    setting: str


class Dataset(Protocol):
    """A set of objects in one or more settings.

    ``objects`` and ``settings`` list what `load` accepts; `lit_photographs` gives the same object
    under other lights (empty where there are none); `fingerprint` is a SHA-256 over the content.
    """

    @property
    def name(self) -> str:
        """Name used in tables and on the command line."""
        ...

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the objects."""
        ...

    @property
    def settings(self) -> tuple[str, ...]:
        """Settings, such as ``natural`` and ``laboratory``."""
        ...

    def load(self, name: str, setting: str) -> Capture:
        """Return one object in one setting."""
        ...

    def lit_photographs(self, name: str) -> tuple[LitPhotograph, ...]:
        """Return the object's photographs under other lights, all of one size and mask."""
        ...

    def fingerprint(self) -> str:
        """Return a SHA-256, in hexadecimal, over the content the records come from."""
        ...
