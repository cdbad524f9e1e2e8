"""The pictures that a study shows: there, whole, and of the kind their name says."""

from __future__ import annotations

import hashlib
from io import BytesIO
from pathlib import Path

from PIL import Image

from shading_model.errors import RelightlabError
from studies.study_records import Study

FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".webp": "WEBP"}
LARGEST_PICTURE = 20_000_000
"""Bytes; a subject waits for every picture before the first trial."""


def stimulus_digests(study: Study) -> dict[str, str]:
    """Return the SHA-256 of every picture of a study, having looked into each.

    Parameters
    ----------
    study : Study

    Returns
    -------
    dict of str to str
        For each of `study.stimuli()`, 64 hexadecimal digits.

    Raises
    ------
    RelightlabError
        If a picture is missing, damaged, too large or not what its name says, or the two of a
        pair are the same.

    Examples
    --------
    >>> import tempfile
    >>> from studies.bare_study import bare_study
    >>> stimulus_digests(bare_study(folder=Path(tempfile.mkdtemp())))
    Traceback (most recent call last):
        ...
    shading_model.errors.RelightlabError: expected the picture .../closing/perspective-a.png, ...
    """
    digests = {one: _digest(study.stimulus_path(one)) for one in study.stimuli()}
    for pair in study.all_pairs():
        if digests[pair.target] == digests[pair.other]:
            raise RelightlabError(
                f"pair {pair.name!r}: {pair.target} and {pair.other} are the same picture"
            )
    return digests


def _digest(path: Path) -> str:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise RelightlabError(
            f"expected the picture {path}, which a pair names, got: {error.strerror or error}"
        ) from error
    if len(content) > LARGEST_PICTURE:
        raise RelightlabError(
            f"{path}: expected at most {LARGEST_PICTURE // 10**6} MB, as subjects wait for every"
            f" picture, got {len(content) / 1e6:.0f} MB"
        )
    _check_picture(content, path)
    return hashlib.sha256(content).hexdigest()


def _check_picture(content: bytes, path: Path) -> None:
    """Raise unless the bytes are a whole picture of the format that the suffix names."""
    wanted = FORMATS[path.suffix.lower()]
    try:
        with Image.open(BytesIO(content)) as picture:
            found = picture.format
            if found == "PNG":
                picture.verify()  # every chunk has a checksum, so nothing is decoded
            else:
                picture.draft("L", (1, 1))  # the least that shows whether it breaks off
                picture.load()
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise RelightlabError(f"{path}: expected a whole {wanted} picture, got: {error}") from error
    if found != wanted:
        raise RelightlabError(f"{path}: expected a {wanted} picture by its name, got {found}")
