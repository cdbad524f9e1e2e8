"""A dataset of one's own: a folder with a folder for each object.

::

    my-set/mug/photograph.png   or .jpg, .exr: 8 bits are sRGB, 16 bits and .exr linear
               mask.png         above zero on the object
               depth.npy        heights in pixels, larger is nearer, NaN where unknown;
                                or depth.png, 16 bits, with depth.json {"scale": pixels per level}
               albedo.png       or .exr, .npy: linear, up to scale
               shading.png      or .exr, .npy; photograph / albedo where it is left out
               lit_01.png ...   the same view under other lights
               lights.json      {"convention": "log" or "linear", "lights": {"lit_01": [9 numbers]}}
               probe_01.png ... white spheres under those lights, for what lights.json leaves out

Only the photograph and its mask have to be there. Re-rendering needs depth and albedo.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from datasets.file_tree import folder_fingerprint
from datasets.image_files import read_image, read_linear_png, read_mask
from datasets.openexr_files import read_openexr
from datasets.records import Capture, GroundTruth, LitPhotograph, Photograph
from shading_model.arrays import Float, Image, Map, Mask, check_image, check_mask
from shading_model.errors import RelightlabError, unknown_name
from shading_model.harmonic_conversion import linear_to_log
from shading_model.height_field import normals_of_slopes, slopes
from shading_model.illumination import LinearHarmonics, LogHarmonics
from shading_model.light_probe import light_of_probe

SETTING = "photograph"
DARKEST_ALBEDO = 1e-3
"""An albedo is not taken below this when the photograph is divided by it."""
CONVENTIONS: dict[str, Callable[[Float], LogHarmonics]] = {
    "log": LogHarmonics,
    "linear": lambda coefficients: linear_to_log(LinearHarmonics(coefficients)),
}
_PICTURES = (".png", ".jpg", ".jpeg", ".exr")
_MAPS = (".npy", ".exr", ".png")


@dataclass(frozen=True)
class OwnFolder:
    """The set in a folder; a `datasets.records.Dataset` with the one setting ``photograph``.

    Parameters
    ----------
    root : Path

    Raises
    ------
    RelightlabError
        If no folder in it holds a photograph; later, if a file is at fault when it is needed.
    """

    root: Path
    settings: tuple[str, ...] = (SETTING,)

    def __post_init__(self) -> None:
        if not self.root.is_dir():
            raise RelightlabError(f"no such folder: {self.root}")
        if not self.objects:
            raise RelightlabError(
                f"{self.root} is no dataset: expected folders that hold photograph.png, .jpg or"
                " .exr, and mask.png"
            )

    @property
    def name(self) -> str:
        """The folder's name, marked as one's own."""
        return f"own:{self.root.resolve().name}"

    @cached_property
    def objects(self) -> tuple[str, ...]:
        """Names of the folders with a photograph or a mask."""
        if not self.root.is_dir():
            return ()
        folders = (f for f in sorted(self.root.iterdir()) if not f.name.startswith("."))
        return tuple(
            folder.name
            for folder in folders
            if _first(folder, "photograph", _PICTURES) or (folder / "mask.png").is_file()
        )

    def load(self, name: str, setting: str = SETTING) -> Capture:
        """Return an object's photograph and what is known of it.

        Raises
        ------
        RelightlabError
            If a name is unknown, or a file is missing or at fault.
        """
        if setting not in self.settings:
            raise unknown_name("setting", setting, self.settings)
        files = self.files(name)
        return Capture(files.photograph, files.truth(), setting)

    def lit_photographs(self, name: str) -> tuple[LitPhotograph, ...]:
        """Return the photographs under other lights; linear coefficients are converted."""
        return self.files(name).lit_photographs()

    def fingerprint(self) -> str:
        """Return a SHA-256 over the relative names and contents of all files."""
        return folder_fingerprint(self.root)

    def files(self, name: str) -> ObjectFiles:
        """Return the files of an object.

        Raises
        ------
        RelightlabError
            If there is no such object.
        """
        if name not in self.objects:
            raise unknown_name("object", name, self.objects)
        return ObjectFiles(self.root / name)


@dataclass(frozen=True)
class ObjectFiles:
    """The files of one object; each is read when it is asked for.

    Parameters
    ----------
    folder : Path
    """

    folder: Path

    @cached_property
    def mask(self) -> Mask:
        """The object's pixels."""
        return check_mask(read_mask(self.folder / "mask.png"))

    @cached_property
    def photograph(self) -> Photograph:
        """The photograph that models are built from.

        Raises
        ------
        RelightlabError
            If it is missing, unreadable or of another size than its mask.
        """
        path = _first(self.folder, "photograph", _PICTURES)
        if path is None:
            raise RelightlabError(f"{self.folder} lacks photograph.png, .jpg or .exr")
        return self._photograph(path)

    def truth(self) -> GroundTruth:
        """Return what is known: whichever of depth, albedo, shading and light have files."""
        height, albedo = self.height(), self.image("albedo")
        shading = self.image("shading")
        if shading is None and albedo is not None:
            shading = self.photograph.image / np.maximum(albedo, DARKEST_ALBEDO)
        return GroundTruth(
            height=height,
            normals=None if height is None else normals_of_slopes(*slopes(height)),
            albedo=albedo,
            shading=shading,
            illumination=self.lights().get("photograph"),
        )

    def height(self) -> Map | None:
        """Return the heights in pixels, NaN outside the mask and where unknown."""
        path = _first(self.folder, "depth", (".npy", ".png"))
        if path is None:
            return None
        if path.suffix == ".png":
            levels = read_linear_png(path) * 65535.0
            return self._masked(np.where(levels > 0, self._scale() * levels, np.nan), path, ())
        return self._masked(_array(path), path, ())

    def image(self, stem: str) -> Image | None:
        """Return the albedo or the shading, NaN outside the mask.

        Raises
        ------
        RelightlabError
            If it is unreadable, of another size, negative or not finite.
        """
        path = _first(self.folder, stem, _MAPS)
        if path is None:
            return None
        values = self._masked(_linear(path), path, (3,))
        inside = values[self.mask]
        if not (np.isfinite(inside).all() and (inside >= 0).all()):
            raise RelightlabError(f"{path} is negative or not finite somewhere on the mask")
        return values

    def lights(self) -> dict[str, LogHarmonics]:
        """Return the lights of ``lights.json`` by the name of the picture taken under them.

        Raises
        ------
        RelightlabError
            If the file is not as documented.
        """
        path = self.folder / "lights.json"
        if not path.is_file():
            return {}
        try:
            document = json.loads(path.read_text(encoding="utf-8"))
            convention = document.get("convention", "")
            listed = {k: np.asarray(v, dtype=np.float64) for k, v in document["lights"].items()}
        except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
            raise RelightlabError(
                f"cannot read {path}: expected"
                ' {"convention": "log", "lights": {"lit_01": [9 numbers]}}'
            ) from error
        if convention not in CONVENTIONS:
            raise unknown_name(f"convention in {path}", str(convention), CONVENTIONS)
        try:
            return {name: CONVENTIONS[convention](values) for name, values in listed.items()}
        except RelightlabError as error:
            raise RelightlabError(f"{path}: {error}") from error

    def probe_lights(self) -> dict[str, LogHarmonics]:
        """Return the lights fitted to the probe pictures, by the name of the lit photograph.

        Raises
        ------
        RelightlabError
            If a probe cannot be used.
        """
        lights = {}
        for path in self.pictures("probe"):
            try:
                lights[f"lit{path.stem.removeprefix('probe')}"] = light_of_probe(_linear(path))
            except RelightlabError as error:
                raise RelightlabError(f"{path}: {error}") from error
        return lights

    def pictures(self, prefix: str) -> tuple[Path, ...]:
        """Return the pictures ``prefix_*``, in order of their names."""
        found = self.folder.glob(f"{prefix}_*")
        return tuple(sorted(path for path in found if path.suffix.lower() in _PICTURES))

    def lit_photographs(self) -> tuple[LitPhotograph, ...]:
        """Return the photographs under other lights, each with its light.

        Raises
        ------
        RelightlabError
            If one has neither coefficients nor a probe, or a probe cannot be used.
        """
        pictures = self.pictures("lit")
        lights = {**self.probe_lights(), **self.lights()}
        without = [path.stem for path in pictures if path.stem not in lights]
        if without:
            raise RelightlabError(f"{self.folder} lacks the lights of {', '.join(without)}")
        return tuple(LitPhotograph(self._photograph(p), lights[p.stem]) for p in pictures)

    def _photograph(self, path: Path) -> Photograph:
        image = check_image(_linear(path), self.mask)
        return Photograph(image, self.mask, self.folder.name, f"{self.folder.name}/{path.name}")

    def _scale(self) -> float:
        path = self.folder / "depth.json"
        try:
            scale = float(json.loads(path.read_text(encoding="utf-8"))["scale"])
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise RelightlabError(
                f'depth.png needs {path} with {{"scale": pixels of height for each level}}'
            ) from error
        if not 0 < scale < float("inf"):
            raise RelightlabError(f"expected a scale above zero in {path}, got {scale:g}")
        return scale

    def _masked(self, values: Float, path: Path, channels: tuple[int, ...]) -> Float:
        if values.shape != (*self.mask.shape, *channels):
            raise RelightlabError(
                f"{path} is of shape {values.shape}, expected {(*self.mask.shape, *channels)} as"
                " its mask"
            )
        masked = np.array(values, dtype=np.float64)
        masked[~self.mask] = np.nan
        return masked


def _first(folder: Path, stem: str, suffixes: tuple[str, ...]) -> Path | None:
    paths = (folder / f"{stem}{suffix}" for suffix in suffixes)
    return next((path for path in paths if path.is_file()), None)


def _linear(path: Path) -> Image:
    if path.suffix.lower() == ".exr":
        return read_openexr(path)
    if path.suffix == ".npy":
        values = _array(path)
        return values if values.ndim == 3 else np.repeat(values[..., None], 3, axis=-1)
    return read_image(path)


def _array(path: Path) -> Float:
    try:
        values: Any = np.load(path, allow_pickle=False)
        return np.asarray(values, dtype=np.float64)
    except (OSError, ValueError, EOFError, TypeError) as error:
        raise RelightlabError(f"cannot read {path}: expected an array of numbers") from error
