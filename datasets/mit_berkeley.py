"""The MIT-Berkeley intrinsic images set: its files become the project's records here.

Twenty objects of Grosse et al. (2009), augmented with depth and spherical-harmonic lights by
Barron and Malik. Everything is cropped to the object with the set's own crops, and its axes (row
down, column right, toward the viewer) are turned into (x right, y up, z toward the viewer).
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from datasets.file_tree import folder_fingerprint
from datasets.image_files import read_linear_png
from datasets.mit_axes import harmonics_from_mit_axes
from datasets.records import Capture, GroundTruth, LitPhotograph, Photograph
from shading_model.arrays import Float, Image, Map, Mask, Normals
from shading_model.errors import RelightlabError, unknown_name
from shading_model.height_field import normals_of_slopes, slopes
from shading_model.illumination import LogHarmonics

TRAINING_OBJECTS = (
    *("apple", "box", "cup1", "dinosaur", "frog1"),
    *("panther", "paper1", "phone", "squirrel", "teabag2"),
)
TEST_OBJECTS = (
    *("cup2", "deer", "frog2", "paper2", "pear"),
    *("potato", "raccoon", "sun", "teabag1", "turtle"),
)
OBJECTS = tuple(sorted(TRAINING_OBJECTS + TEST_OBJECTS))
SETTINGS = ("natural", "laboratory")
_FOLDERS = {"natural": "MIT-Berkeley-Natural", "laboratory": "MIT-Berkeley-Laboratory"}


@dataclass(frozen=True)
class MitBerkeley:
    """The set in a data root that holds ``mit-berkeley/``; a `datasets.records.Dataset`.

    Parameters
    ----------
    root : Path
        The folder that holds ``MIT-Berkeley-Laboratory/`` and ``MIT-Berkeley-Natural/``.

    Raises
    ------
    RelightlabError
        If a file is missing or damaged when it is needed, or a name is unknown.
    """

    root: Path
    name: str = "mit-berkeley"
    objects: tuple[str, ...] = OBJECTS
    settings: tuple[str, ...] = SETTINGS

    def load(self, name: str, setting: str) -> Capture:
        """Return the photograph without its specular part, and its truth, cropped.

        In the ``natural`` setting the mask is where the photograph is above zero (where the depth
        is known); in the ``laboratory`` setting it is the set's own mask.
        """
        files = self._files(name, setting)
        return Capture(files.photograph(), files.truth(), setting)

    def lit_photographs(self, name: str) -> tuple[LitPhotograph, ...]:
        """Return the ten laboratory photographs with their calibrated log-shading lights."""
        return self._files(name, "laboratory").lit_photographs()

    def fingerprint(self) -> str:
        """Return a SHA-256 over the relative names and contents of all files of the set."""
        folders = [self.root / folder for folder in sorted(_FOLDERS.values())]
        return folder_fingerprint(
            self.root, [path for f in folders for path in f.rglob("*") if path.is_file()]
        )

    def _files(self, name: str, setting: str) -> _ObjectFiles:
        if name not in self.objects:
            raise unknown_name("object", name, self.objects)
        if setting not in self.settings:
            raise unknown_name("setting", setting, self.settings)
        return _ObjectFiles(self.root, name, setting)


@dataclass(frozen=True)
class _ObjectFiles:
    root: Path
    name: str
    setting: str

    @property
    def laboratory(self) -> Path:
        return self.root / _FOLDERS["laboratory"] / self.name

    @property
    def folder(self) -> Path:
        return self.root / _FOLDERS[self.setting] / self.name

    @cached_property
    def crop(self) -> tuple[slice, slice]:
        indices = load_mat(self.laboratory / "crop_idx.mat", "crop_idx1", "crop_idx2")
        # Stored as small unsigned integers, one-based and contiguous.
        rows, columns = (
            np.asarray(indices[key]).ravel().astype(int) for key in ("crop_idx1", "crop_idx2")
        )
        return slice(rows[0] - 1, rows[-1]), slice(columns[0] - 1, columns[-1])

    @cached_property
    def mask(self) -> Mask:
        inside: Mask = self._png(self.laboratory / "mask.png") > 0
        if self.setting == "natural":
            inside &= (self._png(self.folder / "diffuse.png") > 0).all(axis=-1)
        return inside

    def photograph(self, file_name: str = "diffuse.png") -> Photograph:
        path = self.folder / file_name
        image = self._png(path)
        return Photograph(image, self.mask, self.name, f"mit-berkeley/{self.setting}/{file_name}")

    def truth(self) -> GroundTruth:
        height = self._height()
        return GroundTruth(
            height=height,
            normals=self._masked(normals_of_depth(height)),
            albedo=self._masked(self._png(self.laboratory / "reflectance.png")),
            shading=self._masked(self._shading()),
            illumination=LogHarmonics(harmonics_from_mit_axes(self._coefficients())),
        )

    def lit_photographs(self) -> tuple[LitPhotograph, ...]:
        lights = load_mat(self.laboratory / "L.mat", "color_lights")["color_lights"].light
        return tuple(
            LitPhotograph(
                self.photograph(f"light{k:02d}.png"),
                LogHarmonics(harmonics_from_mit_axes(np.asarray(light, dtype=np.float64))),
            )
            for k, light in enumerate(lights, start=1)
        )

    def _height(self) -> Map:
        stored = load_mat(self.laboratory / "Z.mat", "depth")["depth"]
        return self._masked(np.asarray(stored, dtype=np.float64)[self.crop])

    def _shading(self) -> Image:
        if self.setting == "natural":
            return self._png(self.folder / "shading_color.png")
        path = self.laboratory / "shading_corrected_color.mat"
        stored = load_mat(path, "shading_correct")["shading_correct"]
        return np.asarray(stored, dtype=np.float64)[self.crop]

    def _coefficients(self) -> Float:
        if self.setting == "natural":
            light = load_mat(self.folder / "L.mat", "L")["L"]
        else:
            light = load_mat(self.folder / "L.mat", "color_lights")["color_lights"].diffuse
        return np.asarray(light, dtype=np.float64)

    def _png(self, path: Path) -> Float:
        return read_linear_png(path)[self.crop]

    def _masked(self, values: Float) -> Float:
        masked = np.array(values, dtype=np.float64)
        masked[~self.mask] = np.nan
        return masked


def normals_of_depth(height: Map) -> Normals:
    """Return the set's own normals of a depth map: 3x3 Sobel over 8, borders replicated.

    Parameters
    ----------
    height : (h, w) array
        Pixels, larger is nearer; NaN where unknown.

    Returns
    -------
    (h, w, 3) array
        Unit normals (x right, y up, z toward the viewer); NaN wherever the 3x3 window meets a NaN.

    Examples
    --------
    >>> plane = np.tile(np.arange(5.0), (4, 1))
    >>> normals_of_depth(plane)[2, 2].round(3) + 0.0
    array([-0.707,  0.   ,  0.707])
    """
    return normals_of_slopes(*slopes(height))


# What SciPy raises on files that are cut short or hold something else, found by cutting them.
_UNREADABLE = (
    *(OSError, EOFError, ValueError, TypeError, IndexError, KeyError, NotImplementedError),
    *(zlib.error, scipy.io.matlab.MatReadError),
)


def load_mat(path: Path, *variables: str, of: str = "mit-berkeley") -> dict[str, Any]:
    """Return variables of a MATLAB file; structs become objects, unit dimensions go.

    Parameters
    ----------
    path : Path
    *variables : str
    of : str
        The set that the file belongs to.

    Returns
    -------
    dict

    Raises
    ------
    RelightlabError
        If the file is missing or damaged, or has no such variable.

    Examples
    --------
    >>> load_mat(Path("Z.mat"), "depth")
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: no such file: Z.mat; get it with 'relightlab data fetch...
    """
    if not path.is_file():
        raise RelightlabError(f"no such file: {path}; get it with 'relightlab data fetch {of}'")
    try:
        loaded: dict[str, Any] = scipy.io.loadmat(path, squeeze_me=True, struct_as_record=False)
        return {name: loaded[name] for name in variables}
    except _UNREADABLE as error:
        raise RelightlabError(
            f"cannot read {path}: {error}; the file is damaged, fetch it again"
        ) from error
