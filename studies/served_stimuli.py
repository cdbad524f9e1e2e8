"""The stimuli as subjects get them: under names, and in files, that tell nothing."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image, ImageCms, ImageOps

from shading_model.errors import RelightlabError
from studies.secret_key import SecretKey
from studies.study_records import Study

_PLAIN_MODES = {"1": "L", "L": "L", "RGB": "RGB", "RGBA": "RGBA", "P": "RGBA", "LA": "RGBA"}


class ServedStimuli:
    """The pictures of a study under opaque names, each read when it is first asked for.

    Parameters
    ----------
    study : Study
    key : SecretKey
        What names are made with; without it they cannot be traced to files.

    Examples
    --------
    >>> from studies.bare_study import bare_study
    >>> stimuli = ServedStimuli(bare_study(), SecretKey(bytes(32)))
    >>> stimuli.address("task-1/pair-1-a.png")
    'stimuli/....png'
    """

    def __init__(self, study: Study, key: SecretKey) -> None:
        self._names: Mapping[str, str] = {
            path: key.digest("stimulus", study.hash, path)[:32] + ".png" for path in study.stimuli()
        }
        self._files = {name: study.stimulus_path(path) for path, name in self._names.items()}
        self._content: dict[str, bytes] = {}
        self._line = threading.Lock()

    def address(self, stimulus: str) -> str:
        """Return where a stimulus is served, relative to the page."""
        return f"stimuli/{self._names[stimulus]}"

    def content(self, name: str) -> bytes | None:
        """Return the PNG under an opaque name, or None if there is none."""
        if name not in self._files:
            return None
        with self._line:
            if name not in self._content:
                self._content[name] = plain_png(self._files[name])
        return self._content[name]


def plain_png(path: Path) -> bytes:
    """Return a picture as a PNG of 8-bit sRGB with no metadata: nothing but the pixels.

    Parameters
    ----------
    path : Path
        A picture that Pillow reads; turned upright if its metadata says so, and brought to sRGB
        from a colour profile.

    Raises
    ------
    RelightlabError
        If it cannot be read.
    """
    try:
        with Image.open(path) as opened:
            upright = ImageOps.exif_transpose(opened)
            profile = upright.info.get("icc_profile")
            if upright.mode.startswith("I"):
                upright = _eight_bits(upright)
            picture = upright.convert(_PLAIN_MODES.get(upright.mode, "RGB"))
            if profile and picture.mode in {"RGB", "RGBA"}:
                picture = _to_srgb(picture, profile)
    except (OSError, SyntaxError, ValueError) as error:
        raise RelightlabError(f"the stimulus {path} cannot be read: {error}") from error
    picture.info = {}
    stream = BytesIO()
    picture.save(stream, "PNG")
    return stream.getvalue()


def _eight_bits(picture: Image.Image) -> Image.Image:
    # Pillow would cut off all above 255 as white.
    return Image.fromarray(np.rint(np.asarray(picture) / 257.0).astype(np.uint8))


def _to_srgb(picture: Image.Image, profile: bytes) -> Image.Image:
    try:
        source = ImageCms.ImageCmsProfile(BytesIO(profile))
        target = ImageCms.createProfile("sRGB")
        converted = ImageCms.profileToProfile(picture.convert("RGB"), source, target)
    except ImageCms.PyCMSError:
        return picture  # a browser, too, ignores a profile that does not fit
    if converted and picture.mode == "RGBA":
        converted.putalpha(picture.getchannel("A"))
    return converted or picture
