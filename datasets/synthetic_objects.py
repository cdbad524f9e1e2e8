"""One object of the synthetic set: made from names, kept in one file, turned into records.

The file is an ``.npz`` without pickles holding

==============  =========  =====================================================================
array           type       content
==============  =========  =====================================================================
height          float32    (h, w) pixels, larger is nearer, NaN off the object
albedo          float32    (h, w, 3), 0 off the object
photographs     uint16     (11, h, w, 3) linear, 65535 is 1, 0 off the object: the laboratory's
                           photograph models are built from, then ten others
lights          float64    (11, 9, 3) log harmonics fitted to each photograph
natural_light   float64    (9, 3) log harmonics of the natural setting
==============  =========  =====================================================================

The natural photograph is not kept: it is the exact forward model of the height, the albedo and
the light.
"""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets.array_archive import add_member, npy_bytes
from datasets.atomic import atomic_path
from datasets.environment_maps import shipped_lights
from datasets.mit_berkeley import normals_of_depth
from datasets.records import Capture, GroundTruth, LitPhotograph, Photograph
from datasets.synthetic_albedo import painted_albedo
from datasets.synthetic_laboratory import extended, render_laboratory
from datasets.synthetic_shapes import SHAPES, shape_height
from shading_model.arrays import Float, Image, Map, Mask, Normals
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics, harmonics
from shading_model.seeds import generator_for

FULL = 65535
_MARGIN = 20 / 300  # background kept around an object, as a share of the picture
# Shading below this share of the median counts as that in a light fit: shadow and noise, not light.
_FIT_FLOOR = 0.05
# Weight of the pull toward zero in a light fit, in pixels: only flat objects feel it.
_FIT_RIDGE = 1.0


@dataclass(frozen=True, eq=False)
class SyntheticObject:
    """What the file of one object holds; see the module for shapes and units."""

    name: str
    height: Map
    albedo: Image
    photographs: NDArray[np.uint16]
    lights: Float
    natural_light: Float

    @property
    def mask(self) -> Mask:
        """True on the object."""
        return np.isfinite(self.height)

    @property
    def normals(self) -> Normals:
        """Normals of the height by the MIT-Berkeley rule: NaN also on the outermost ring."""
        return normals_of_depth(self.height)

    def natural(self) -> Capture:
        """Return the natural setting: albedo times exp(B(N) . L), clipped at 1.

        On the outermost ring, where `normals` is NaN, the shading is that of the height extended
        over the border, so that the photograph is positive on the whole mask.
        """
        light = LogHarmonics(self.natural_light)
        all_normals = normals_of_depth(extended(self.height, self.mask))
        shading = self._on_mask(np.minimum(light.shade(all_normals), 1.0))
        image = np.where(self.mask[..., None], self.albedo * shading, 0.0)
        return self._capture("natural", image, shading, light)

    def laboratory(self) -> Capture:
        """Return the laboratory setting: path traced; its shading is photograph / albedo."""
        image = self.photographs[0] / FULL
        with np.errstate(invalid="ignore", divide="ignore"):
            shading = self._on_mask(image / self.albedo)
        return self._capture("laboratory", image, shading, LogHarmonics(self.lights[0]))

    def lit_photographs(self) -> tuple[LitPhotograph, ...]:
        """Return the ten other laboratory photographs with the lights fitted to them."""
        return tuple(
            LitPhotograph(self._photograph(pixels / FULL), LogHarmonics(light))
            for pixels, light in zip(self.photographs[1:], self.lights[1:], strict=True)
        )

    def _capture(
        self, setting: str, image: Image, shading: Image, illumination: LogHarmonics
    ) -> Capture:
        albedo = self._on_mask(self.albedo)
        truth = GroundTruth(self.height, self.normals, albedo, shading, illumination)
        return Capture(self._photograph(image), truth, setting)

    def _photograph(self, image: Image) -> Photograph:
        return Photograph(image, self.mask, self.name, "synthetic")

    def _on_mask(self, values: Float) -> Float:
        return np.where(self.mask[..., None], values, np.nan)


def make_object(name: str, size: int, seed: int, samples: int) -> SyntheticObject:
    """Return one object, decided by its arguments alone.

    Parameters
    ----------
    name : str
        A key of `datasets.synthetic_shapes.SHAPES`.
    size : int
        Side in pixels of the square picture, before it is cropped to the object.
    seed : int
        Of the whole set.
    samples : int
        Light paths per pixel of the laboratory photographs.

    Returns
    -------
    SyntheticObject
    """
    height = shape_height(name, size, generator_for("shape", name, str(seed)))
    albedo = painted_albedo(name, size, generator_for("albedo", name, str(seed)))
    crop = _crop(np.isfinite(height), round(_MARGIN * size))
    height = _rounded(height[crop])
    mask = np.isfinite(height)
    albedo = _rounded(np.where(mask[..., None], albedo[crop], 0.0))
    sampler = int(generator_for("laboratory", name, str(seed)).integers(2**30))
    rendered = render_laboratory(height, albedo, samples, sampler)
    photographs = _sixteen_bit(rendered, mask)
    normals = normals_of_depth(height)
    with np.errstate(invalid="ignore", divide="ignore"):
        shadings = photographs / FULL / albedo
    lights = np.stack([fitted_light(shading, normals).coefficients for shading in shadings])
    return SyntheticObject(name, height, albedo, photographs, lights, _natural_light(name, seed))


def fitted_light(shading: Image, normals: Normals) -> LogHarmonics:
    """Return the log harmonics nearest to a shading in log shading.

    Least squares over the pixels with a normal. Shading darker than a twentieth of the median
    counts as that; a ridge of one pixel's weight settles what a flat object leaves open.

    Parameters
    ----------
    shading : (h, w, 3) array
        Positive where `normals` is finite.
    normals : (h, w, 3) array
        NaN where unknown.

    Returns
    -------
    LogHarmonics
        Coefficients of shape (9, 3).

    Examples
    --------
    >>> normals = normals_of_depth(-0.1 * np.hypot(*np.mgrid[-9:9:19j, -9:9:19j]) ** 2)
    >>> light = LogHarmonics(np.full((9, 3), -0.1))
    >>> fitted = fitted_light(light.shade(normals), normals)
    >>> bool(np.allclose(fitted.shade(normals), light.shade(normals), atol=0.01))
    True
    """
    known = np.isfinite(normals).all(axis=-1)
    basis, values = harmonics(normals[known]), shading[known]
    target = np.log(np.maximum(values, _FIT_FLOOR * np.median(values)))
    gram = basis.T @ basis + _FIT_RIDGE * np.eye(9)
    return LogHarmonics(np.linalg.solve(gram, basis.T @ target).astype(np.float64))


def save_object(target: Path, made: SyntheticObject) -> None:
    """Write an object's file; the same object gives the same bytes.

    Raises
    ------
    RelightlabError
        If the file cannot be written.
    """
    arrays: dict[str, NDArray[Any]] = {
        "height": made.height.astype(np.float32),
        "albedo": made.albedo.astype(np.float32),
        "photographs": made.photographs,
        "lights": made.lights,
        "natural_light": made.natural_light,
    }
    with atomic_path(target) as path, zipfile.ZipFile(path, "w") as archive:
        for name, values in arrays.items():
            add_member(archive, f"{name}.npy", npy_bytes(values))


def load_object(source: Path) -> SyntheticObject:
    """Return the object of a file that `save_object` wrote.

    Raises
    ------
    RelightlabError
        If the file is missing or damaged.
    """
    try:
        with np.load(source, allow_pickle=False) as arrays:
            return SyntheticObject(
                source.stem,
                arrays["height"].astype(np.float64),
                arrays["albedo"].astype(np.float64),
                arrays["photographs"],
                arrays["lights"],
                arrays["natural_light"],
            )
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise RelightlabError(
            f"{source} is missing or damaged: make the synthetic set again ({error})"
        ) from error


def _natural_light(name: str, seed: int) -> Float:
    """Return the light of an object: no two objects of a set share one."""
    pool = shipped_lights()
    order = generator_for("natural lights", str(seed)).permutation(len(pool))
    return pool[int(order[list(SHAPES).index(name)])].coefficients


def _crop(mask: Mask, margin: int) -> tuple[slice, slice]:
    bounds = []
    for axis in (1, 0):
        inside = np.flatnonzero(mask.any(axis=axis))
        last = mask.shape[1 - axis]
        bounds.append(slice(max(inside[0] - margin, 0), min(inside[-1] + 1 + margin, last)))
    return bounds[0], bounds[1]


def _rounded(values: Float) -> Float:
    """Round to what the file holds, so that made and loaded objects are equal."""
    rounded: Float = values.astype(np.float32).astype(np.float64)
    return rounded


def _sixteen_bit(images: Float, mask: Mask) -> NDArray[np.uint16]:
    levels = np.clip(np.rint(images * FULL), 1, FULL)
    return np.where(mask[..., None], levels, 0).astype(np.uint16)
