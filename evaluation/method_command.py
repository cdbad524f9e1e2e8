"""A method that lives in another environment: a command from a folder of inputs to one of images.

The inputs are ``photograph.npy`` (float64, linear) and ``photograph.png`` (16 bits, linear),
``mask.png``, ``lights.json`` (nine coefficients of every light, with their convention), and for
every light a picture of a white sphere under it, ``sphere_<light>.npy`` and ``.png``. The command
leaves ``light_<light>.npy``, ``.png`` (16 bits, linear) or ``.exr`` for every light.
"""

from __future__ import annotations

import hashlib
import json
import os
import shlex
import signal
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from datasets.atomic import atomic_path
from datasets.file_tree import file_sha256
from datasets.image_files import read_linear_png
from datasets.openexr_files import read_openexr
from shading_model.arrays import Float, Image, Mask
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics

SPHERE_SIDE = 128
TAIL = 3
"""Last lines of a command's standard error that are told."""
FOLDERS = ("{inputs}", "{outputs}")


@dataclass(frozen=True)
class CommandMethod:
    """A method that is run as a command, without a shell.

    Parameters
    ----------
    command : str
        Its words; ``{inputs}`` and ``{outputs}`` are replaced by two folders.
    seconds : float
        Time limit for one object under all lights.

    Raises
    ------
    RelightlabError
        If the command does not name both folders, or the limit is not above zero.

    Examples
    --------
    >>> CommandMethod("relight-net {inputs} {outputs}").name
    'relight-net'
    """

    command: str
    seconds: float = 600.0

    def __post_init__(self) -> None:
        if not all(folder in self.command for folder in FOLDERS):
            raise RelightlabError(
                f"expected {{inputs}} and {{outputs}} in the method command, got {self.command!r}"
            )
        if not self.seconds > 0:
            raise RelightlabError(f"expected a time limit above zero, got {self.seconds:g}")
        self.words()

    @property
    def name(self) -> str:
        """The command without its folders, for tables."""
        kept = [word for word in self.words() if word not in FOLDERS]
        return " ".join([Path(kept[0]).name, *(Path(word).name for word in kept[1:])])

    @property
    def identity(self) -> str:
        """Changes with the command and the content of the files it names."""
        files = {word: file_sha256(Path(word)) for word in self.words() if Path(word).is_file()}
        document = json.dumps([self.command, files], sort_keys=True)
        return hashlib.sha256(document.encode()).hexdigest()

    def words(self) -> list[str]:
        """Return the words of the command.

        Raises
        ------
        RelightlabError
            If a quotation mark is not closed, or there is no word.
        """
        try:
            words = shlex.split(self.command)
        except ValueError as error:
            raise RelightlabError(f"cannot read the command {self.command!r}: {error}") from error
        if not words or words[0] in FOLDERS:
            raise RelightlabError(f"expected a program to run first in {self.command!r}")
        return words

    def relit(
        self, image: Image, mask: Mask, lights: Mapping[str, LogHarmonics]
    ) -> Mapping[str, Float]:
        """Return what the command makes of a photograph under each light, by the light's name.

        Raises
        ------
        RelightlabError
            If the command fails, takes too long, or leaves an image out or of another size.
        """
        with tempfile.TemporaryDirectory(prefix="relightlab-") as folder:
            inputs, outputs = Path(folder) / "inputs", Path(folder) / "outputs"
            inputs.mkdir()
            outputs.mkdir()
            write_inputs(inputs, image, mask, lights)
            words = [
                word.replace("{inputs}", str(inputs)).replace("{outputs}", str(outputs))
                for word in self.words()
            ]
            said = _run(words, self.seconds)
            return {name: read_output(outputs, name, mask, said) for name in lights}


def write_inputs(
    folder: Path, image: Image, mask: Mask, lights: Mapping[str, LogHarmonics]
) -> None:
    """Write what a command is given; see the module's docstring.

    Parameters
    ----------
    folder : Path
    image : (h, w, 3) array
    mask : (h, w) bool array
    lights : mapping of str to LogHarmonics
        Of one colour.
    """
    _write_array(folder / "photograph.npy", image)
    _write_png(folder / "photograph.png", image)
    with atomic_path(folder / "mask.png") as path:
        cv2.imwrite(str(path), np.uint8(255) * mask.astype(np.uint8))
    spheres = {name: _sphere(light) for name, light in lights.items()}
    exposure = 1.0 / max(float(sphere.max()) for sphere in spheres.values())
    for name, sphere in spheres.items():
        _write_array(folder / f"sphere_{name}.npy", sphere)
        _write_png(folder / f"sphere_{name}.png", exposure * sphere)
    document = {
        "convention": "log",
        "formula": "shading = exp(sum of coefficients * [c4, 2 c2 y, 2 c2 z, 2 c2 x, 2 c1 x y,"
        " 2 c1 y z, c3 z^2 - c5, 2 c1 x z, c1 (x^2 - y^2)])",
        "constants": {"c1": 0.429043, "c2": 0.511664, "c3": 0.743125, "c4": 0.886227,
                      "c5": 0.247708},
        "axes": "normals (x right, y up, z toward the viewer)",
        "sphere_png_exposure": exposure,
        "lights": {name: light.coefficients.tolist() for name, light in lights.items()},
    }  # fmt: skip
    with atomic_path(folder / "lights.json") as path:
        path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def read_output(folder: Path, name: str, mask: Mask, said: str = "") -> Float:
    """Return the image that a command left for a light.

    Parameters
    ----------
    folder : Path
    name : str
        Of the light.
    mask : (h, w) bool array
    said : str
        What the command said last, told with a fault.

    Returns
    -------
    (h, w, 3) array

    Raises
    ------
    RelightlabError
        If it is not there, cannot be read, or has another size or NaN in the mask.
    """
    found = [path for suffix in _READERS if (path := folder / f"light_{name}{suffix}").is_file()]
    if not found:
        raise RelightlabError(f"the command left no light_{name}.npy, .png or .exr{said}")
    try:
        image = np.asarray(_READERS[found[0].suffix](found[0]), dtype=np.float64)
    except (OSError, ValueError, EOFError, TypeError, RelightlabError) as error:
        sentence = str(error).replace(str(found[0]), found[0].name)
        raise RelightlabError(f"cannot use the command's image: {sentence}{said}") from error
    if image.shape != (*mask.shape, 3):
        raise RelightlabError(
            f"{found[0].name} is of shape {image.shape}, expected {(*mask.shape, 3)}{said}"
        )
    wrong = int((~np.isfinite(image[mask])).any(axis=-1).sum())
    if wrong:
        raise RelightlabError(f"{found[0].name} has {wrong} pixels that are not finite{said}")
    return image


def _load_array(path: Path) -> Any:
    return np.load(path, allow_pickle=False)


_READERS: dict[str, Any] = {".npy": _load_array, ".png": read_linear_png, ".exr": read_openexr}


def _run(words: list[str], seconds: float) -> str:
    """Run a command to its end; return what it said last, as a clause."""
    try:
        process = subprocess.Popen(
            words,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
    except OSError as error:
        raise RelightlabError(f"cannot run {words[0]!r}: {error.strerror or error}") from error
    with process:
        try:
            _, errors = process.communicate(timeout=seconds)
        except BaseException as error:
            # Whatever stops this run stops the command and all that it started.
            os.killpg(process.pid, signal.SIGKILL)
            if not isinstance(error, subprocess.TimeoutExpired):
                raise
            said = _tail(process.communicate()[1])
            raise RelightlabError(f"the command took longer than {seconds:g} s{said}") from error
    said = _tail(errors)
    if process.returncode:
        raise RelightlabError(f"the command ended with exit code {process.returncode}{said}")
    return said


def _tail(errors: bytes) -> str:
    lines = [line.strip() for line in errors.decode(errors="replace").splitlines() if line.strip()]
    return f"; it said last: {' | '.join(lines[-TAIL:])}" if lines else ""


def _sphere(light: LogHarmonics) -> Image:
    """Return a white sphere that fills a square picture; black outside."""
    across = (np.arange(SPHERE_SIDE) + 0.5) * 2 / SPHERE_SIDE - 1
    x, y = np.meshgrid(across, -across)
    inside = x**2 + y**2 < 1
    z = np.sqrt(np.where(inside, 1 - x**2 - y**2, 0.0))
    shading = light.shade(np.stack([x, y, z], axis=-1))
    return np.repeat(np.where(inside, shading, 0.0)[..., None], 3, axis=-1)


def _write_array(path: Path, values: Float) -> None:
    with atomic_path(path) as temporary:
        np.save(temporary, values)


def _write_png(path: Path, linear: Image) -> None:
    """Write a linear image as a 16-bit PNG; OpenCV wants blue first."""
    levels = np.round(65535 * np.clip(np.nan_to_num(linear), 0.0, 1.0)).astype(np.uint16)
    with atomic_path(path) as temporary:
        cv2.imwrite(str(temporary), np.ascontiguousarray(levels[..., ::-1]))
