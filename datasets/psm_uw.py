"""The photometric-stereo set of the University of Washington's vision course.

Three objects and two spheres (one gray, one chrome) photographed from one place under the same
twelve distant lights. The eight-bit values are linear: on the gray sphere they grow with the cosine
to the light. ``lights.txt`` holds unit directions (x right, y up, z toward the viewer), the
project's own axes; a test regresses the gray sphere on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from datasets.file_tree import folder_fingerprint
from datasets.picture_series import PictureSeries, box_of, numbered, read_series
from datasets.records import Capture, GroundTruth, LitPhotograph, Photograph
from shading_model.arrays import Float
from shading_model.diffuse_probe import fit_diffuse_probe
from shading_model.errors import RelightlabError, unknown_name
from shading_model.illumination import LinearHarmonics, LogHarmonics
from shading_model.light_probe import light_of_probe
from shading_model.normal_integration import height_of_normals
from shading_model.photometric_stereo import PhotometricStereo, photometric_stereo

OBJECTS = ("cat", "horse", "owl")
PROBES = ("chrome", "gray")
SETTING = "laboratory"
LIGHTS = "lights.txt"
UNIT_TOLERANCE = 1e-3


@dataclass(frozen=True)
class PsmUw:
    """The set in a data root that holds ``psm-uw/``; a `datasets.records.Dataset`.

    Its shapes are a **reference, not a truth**: photometric stereo under the twelve given lights
    (`shading_model.photometric_stereo`), which takes the surface for Lambertian. On the gray sphere
    its normals are 4.3 degrees off on average, and half as much again toward the outline. Albedo,
    shading and the light of the mean picture are not known.

    Parameters
    ----------
    root : Path
        The folder that holds ``lights.txt`` and a folder for each object and sphere.

    Raises
    ------
    RelightlabError
        If a file is missing or damaged when it is needed, pictures and lights differ in number, or
        a name is unknown.
    """

    root: Path
    name: str = "psm-uw"
    objects: tuple[str, ...] = OBJECTS
    settings: tuple[str, ...] = (SETTING,)
    has_diffuse_photograph: ClassVar[bool] = False

    def load(self, name: str, setting: str) -> Capture:
        """Return the mean of an object's twelve pictures, cropped, and its reference shape.

        The mean has no strong directional light. The normals are those of photometric stereo,
        NaN where fewer than three lights reach; the heights are integrated from them, each part of
        the mask about its own mean, so a step between parts or inside one is not measured.

        Raises
        ------
        RelightlabError
            If the name or setting is unknown, or as the class says.
        """
        if setting not in self.settings:
            raise unknown_name("setting", setting, self.settings)
        series = self._object(name)
        stereo = photometric_stereo(series.images, self.light_directions(), series.mask)
        height = height_of_normals(stereo.normals, series.mask)
        photograph = Photograph(
            series.mean, series.mask, name, f"{self.name}/{name}: mean of {len(series.names)}"
        )
        return Capture(photograph, GroundTruth(height=height, normals=stereo.normals), setting)

    def lit_photographs(self, name: str) -> tuple[LitPhotograph, ...]:
        """Return the twelve pictures, each with the light that the gray sphere shows.

        Nine log harmonics a colour, fitted to the sphere's picture under the same light with its
        albedo taken for one (`shading_model.light_probe`).
        """
        photographs = _photographs(self._object(name), name, self.name)
        pairs = zip(photographs, self.log_lights(), strict=True)
        return tuple(LitPhotograph(photograph, light) for photograph, light in pairs)

    def photometric_stereo(self, name: str) -> PhotometricStereo:
        """Return what twelve lights tell of an object or sphere, on the crop of its pictures.

        Its albedo takes in whatever is not Lambertian: highlights left over, light from one part
        of the object on another.

        Raises
        ------
        RelightlabError
            If the name or setting is unknown, or as the class says.
        """
        known = (*self.objects, *PROBES)
        if name not in known:
            raise unknown_name("object", name, known)
        series = self._series(name).cropped()
        return photometric_stereo(series.images, self.light_directions(), series.mask)

    def probe_photographs(self, probe: str) -> tuple[Photograph, ...]:
        """Return the twelve pictures of the ``gray`` or ``chrome`` sphere, cropped.

        Raises
        ------
        RelightlabError
            If there is no such sphere, or as the class says.
        """
        if probe not in PROBES:
            raise unknown_name("light probe", probe, PROBES)
        return _photographs(self._series(probe).cropped(), probe, self.name)

    def light_directions(self) -> Float:
        """Return the twelve unit directions to the lights, (12, 3): x right, y up, z to the viewer.

        Raises
        ------
        RelightlabError
            If ``lights.txt`` is missing, damaged, not of unit length, or has another number of
            directions than it says.
        """
        path = self.root / LIGHTS
        try:
            count, *values = path.read_text(encoding="utf-8").split()
            directions = np.array(values, dtype=np.float64).reshape(-1, 3)
            expected = int(count)
        except (OSError, ValueError) as error:
            raise RelightlabError(
                f"cannot read {path}: {error}; expected a number of lights, then x y z of each"
            ) from error
        if len(directions) != expected:
            raise RelightlabError(
                f"{path} promises {expected} lights but holds {len(directions)}: fetch it again"
            )
        if not (np.abs(np.linalg.norm(directions, axis=1) - 1) < UNIT_TOLERANCE).all():
            raise RelightlabError(f"{path} holds directions that are not of unit length")
        return directions

    def log_lights(self) -> tuple[LogHarmonics, ...]:
        """Return the light of each picture of the gray sphere, in nine log harmonics a colour."""
        series = self._series("gray")
        rows, columns = box_of(series.mask)
        return tuple(light_of_probe(image[rows, columns]) for image in series.images)

    def linear_lights(self) -> tuple[LinearHarmonics, ...]:
        """Return the same lights in nine linear harmonics a colour."""
        probes = self.probe_photographs("gray")
        return tuple(fit_diffuse_probe(probe.image, probe.mask).linear for probe in probes)

    def fingerprint(self) -> str:
        """Return a SHA-256 over the relative names and contents of the files of the set."""
        folders = [self.root / name for name in (*self.objects, *PROBES)]
        pictures = [path for folder in folders for path in folder.glob("*.png")]
        return folder_fingerprint(self.root, [self.root / LIGHTS, *pictures])

    def _object(self, name: str) -> PictureSeries:
        if name not in self.objects:
            raise unknown_name("object", name, self.objects)
        return self._series(name).cropped()

    def _series(self, name: str) -> PictureSeries:
        folder = self.root / name
        mask = folder / f"{name}.mask.png"
        return read_series(numbered(folder, f"{name}."), mask, len(self.light_directions()))


def _photographs(series: PictureSeries, name: str, dataset: str) -> tuple[Photograph, ...]:
    return tuple(
        Photograph(image, series.mask, name, f"{dataset}/{name}/{file}")
        for image, file in zip(series.images, series.names, strict=True)
    )
