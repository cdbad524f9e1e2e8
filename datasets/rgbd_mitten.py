"""A quilted oven mitt under twenty hand-held lights, with the readings of a depth sensor.

Pictures of Peng, Haefner, Queau and Cremers (2017). There is no light probe and no calibrated
light: what is given for a light here is estimated from the object itself.

The eight-bit values are taken for **linear**. Nothing beside the files says so, but a matt surface
under K lights is a matrix of low rank in linear values, and here it is: left over by ranks 3, 4 and
5 on samples between 20 and 248 are 5.3, 4.4 and 4.0 grey levels of red if the values are linear,
and 7.0, 5.3 and 4.5 if they are sRGB (each fit weighted to count errors in grey levels); green does
the same. No exponent from 1.3 to 2.6 does as well as 1. Those below 1 do a little better (4.8, 4.2
and 3.7 at 0.5), so the test tells linear values from sRGB, but not from a mild curve.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from datasets.file_tree import folder_fingerprint
from datasets.image_files import read_linear_png
from datasets.picture_series import PictureSeries, numbered, read_series
from datasets.records import Capture, GroundTruth, LitPhotograph, Photograph
from shading_model.arrays import Float, Mask
from shading_model.depth_map import DepthMap
from shading_model.errors import RelightlabError, unknown_name
from shading_model.object_model import CoarseShape
from shading_model.relative_light import RelativeLight, relative_light
from shading_model.sensor_shape import shape_from_depth

OBJECT = "mitten"
SETTING = "laboratory"
LIGHTS = 20
CALIBRATION, WINDOW, MASK = "K.txt", "crop.txt", "mask.png"


@dataclass(frozen=True)
class RgbdMitten:
    """The set in a data root that holds ``rgbd-mitten/``; a `datasets.records.Dataset`.

    Of its one object **no truth is known**: the record of `load` is empty. `sensor_shape` is what
    the depth sensor saw, a base shape to be tested and not a reference.

    Parameters
    ----------
    root : Path
        The folder that holds ``rgb_01.png`` to ``rgb_20.png``, ``depth_01.png`` to
        ``depth_20.png``, ``mask.png``, ``K.txt`` and ``crop.txt``.

    Raises
    ------
    RelightlabError
        If a file is missing or damaged when it is needed, pictures, readings and lights differ in
        number or size, or a name is unknown.
    """

    root: Path
    name: str = "rgbd-mitten"
    objects: tuple[str, ...] = (OBJECT,)
    settings: tuple[str, ...] = (SETTING,)
    has_diffuse_photograph: ClassVar[bool] = False
    has_true_shape: ClassVar[bool] = False

    def load(self, name: str, setting: str) -> Capture:
        """Return the mean of the twenty pictures, which has no strong directional light.

        Saturated samples are averaged with the others: leaving them out would average each pixel
        over other lights, and leaving out their pixels would riddle the mask, as a third of them
        is saturated in one picture or more. `saturated` tells where.

        Raises
        ------
        RelightlabError
            If the name or setting is unknown, or as the class says.
        """
        self._check(name)
        if setting not in self.settings:
            raise unknown_name("setting", setting, self.settings)
        series = self._series()
        source = f"{self.name}: mean of {len(series.names)}"
        return Capture(Photograph(series.mean, series.mask, name, source), GroundTruth(), setting)

    def lit_photographs(self, name: str) -> tuple[LitPhotograph, ...]:
        """Return the twenty pictures, each with a light **estimated from the object itself**.

        Nine log harmonics a colour are fitted to the picture over the mean picture, on the
        normals of the sensor's own shape (`shading_model.relative_light`): the mean picture is
        taken to be evenly lit, saturated samples are left out. So the lights are not independent
        of the pictures they are tested on, nor of the sensor's shape, and favour that shape. The
        lamps were near, so one light for the whole object does not explain all of a picture.
        """
        self._check(name)
        series = self._series()
        return tuple(
            LitPhotograph(
                Photograph(image, series.mask, name, f"{self.name}/{file}"), light.illumination
            )
            for image, file, light in zip(
                series.images, series.names, self._lights(series), strict=True
            )
        )

    def relative_lights(self) -> tuple[RelativeLight, ...]:
        """Return the lights of `lit_photographs` with what they leave unexplained."""
        return self._lights(self._series())

    def sensor_shape(self, name: str = OBJECT) -> CoarseShape:
        """Return the shape that the depth sensor gives: median of the frames, cleaned and filled.

        See `shading_model.sensor_shape`; heights in pixels of the pictures, known all over the
        mask.
        """
        self._check(name)
        return self._sensor_shape(self._series())

    def saturated(self) -> Mask:
        """Return where a channel of a picture is at the sensor's end, (20, h, w)."""
        return self._series().saturated

    def depth_frames(self) -> Float:
        """Return the sensor's readings, (20, h/2, w/2), in millimetres; 0 is no reading.

        Raises
        ------
        RelightlabError
            If a frame is missing, damaged or of another size.
        """
        paths = numbered(self.root, "depth_")
        if len(paths) != LIGHTS:
            raise RelightlabError(
                f"{self.root} holds {len(paths)} depth frames, expected {LIGHTS}, one beside each"
                " picture: fetch the set again"
            )
        farthest = self._calibration()[1]
        frames = [read_linear_png(path) for path in paths]
        if len({frame.shape for frame in frames}) > 1 or frames[0].ndim != 2:
            raise RelightlabError(f"the depth frames of {self.root} are not all of one (h, w)")
        return np.stack(frames) * farthest

    def intrinsics(self) -> Float:
        """Return the camera matrix (3, 3) of the pictures as they are cut, in their pixels.

        ``column = f x / z + matrix[0, 2]`` and ``row = f y / z + matrix[1, 2]``, y down.

        Raises
        ------
        RelightlabError
            If ``K.txt`` or ``crop.txt`` is missing or not as expected.
        """
        matrix = self._calibration()[0]
        row, column = self._corner()
        return matrix - np.array([[0, 0, column], [0, 0, row], [0, 0, 0]], dtype=np.float64)

    def fingerprint(self) -> str:
        """Return a SHA-256 over the relative names and contents of the files that are read."""
        files = [self.root / name for name in (MASK, CALIBRATION, WINDOW)]
        pictures = [*numbered(self.root, "rgb_"), *numbered(self.root, "depth_")]
        return folder_fingerprint(self.root, [*files, *pictures])

    def _check(self, name: str) -> None:
        if name not in self.objects:
            raise unknown_name("object", name, self.objects)

    def _series(self) -> PictureSeries:
        return read_series(numbered(self.root, "rgb_"), self.root / MASK, LIGHTS)

    def _sensor_shape(self, series: PictureSeries) -> CoarseShape:
        focal_length = float(self._calibration()[0][0, 0])
        return shape_from_depth(DepthMap(self.depth_frames(), focal_length), series.mask)

    def _lights(self, series: PictureSeries) -> tuple[RelativeLight, ...]:
        normals, mean = self._sensor_shape(series).normals, series.mean
        return tuple(
            relative_light(image, mean, normals, series.mask & ~full)
            for image, full in zip(series.images, series.saturated, strict=True)
        )

    def _calibration(self) -> tuple[Float, float]:
        """Return the camera matrix of the whole frame, and the depth of the largest value."""
        path = self.root / CALIBRATION
        try:
            rows = path.read_text(encoding="utf-8").split()
            values = np.array([row.split(",") for row in rows], dtype=np.float64)
        except (OSError, ValueError) as error:
            raise RelightlabError(f"cannot read {path}: {error}") from error
        if values.shape != (4, 3) or not (values[0, 0] > 0 and values[3, 2] > 0):
            raise RelightlabError(
                f"{path} is not as expected: three rows of the camera matrix, then the ratio of the"
                " resolutions, 0 and the depth in millimetres of the largest value"
            )
        return values[:3], float(values[3, 2])

    def _corner(self) -> tuple[int, int]:
        """Return the row and the column of the whole frame at which the pictures are cut."""
        path = self.root / WINDOW
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, ValueError) as error:
            raise RelightlabError(f"cannot read {path}: {error}") from error
        found = re.match(r"rows (\d+):\d+ cols (\d+):\d+", text)
        if found is None:
            raise RelightlabError(f"{path} is not as expected: 'rows 118:758 cols 366:848'")
        return int(found[1]), int(found[2])
