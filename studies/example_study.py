"""The example study: its file, which ships, and its pictures, which are computed."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from functools import cache, partial
from importlib.resources import files
from io import BytesIO
from pathlib import Path

from PIL.Image import Image

from datasets.atomic import atomic_path
from shading_model.errors import RelightlabError
from studies.example_pictures import (
    CLOSING_PICTURES,
    INSERTIONS,
    cartoon_picture,
    scene_picture,
)

FILE = "study.toml"
SCENES = 10
CARTOONS = 4


def write_example(folder: str | os.PathLike[str]) -> Path:
    """Write the example study and its pictures, and return its file.

    What is there already and the same is left as it is, so a second call changes nothing.

    Parameters
    ----------
    folder : path-like
        Made if it is not there.

    Returns
    -------
    Path
        The study's file, for `studies.study_file.load_study`.

    Raises
    ------
    RelightlabError
        If one of its files is there with another content; nothing is written then.

    Examples
    --------
    >>> import tempfile
    >>> path = write_example(tempfile.mkdtemp())
    >>> path.name, len(list(path.parent.rglob("*.png")))
    ('study.toml', 72)
    """
    target = Path(folder)
    contents = _contents()
    missing = [name for name in contents if not (target / name).exists()]
    for name in contents.keys() - set(missing):
        if (target / name).read_bytes() != contents[name]:
            raise RelightlabError(
                f"{target / name} is there and not that of the example study; choose another folder"
            )
    for name in missing:
        with atomic_path(target / name) as path:
            path.write_bytes(contents[name])
    return target / FILE


@cache
def _contents() -> dict[str, bytes]:
    """Return the bytes of each file, made once in a process."""
    study = files("studies").joinpath("example", FILE).read_bytes()
    return {FILE: study} | {name: _png(picture()) for name, picture in _pictures()}


def _pictures() -> Iterator[tuple[str, Callable[[], Image]]]:
    """Yield the path of each picture, and what makes it."""
    for number in range(1, SCENES + 1):
        scene = f"scene-{number:02d}"
        for condition, insertion in INSERTIONS.items():
            yield f"stimuli/{condition}/{scene}.png", partial(scene_picture, scene, insertion)
    for number in range(1, CARTOONS + 1):
        scene, place = f"qualification-{number:02d}", "stimuli/qualification"
        yield f"{place}/real-{number:02d}.png", partial(scene_picture, scene, INSERTIONS["real"])
        yield f"{place}/cartoon-{number:02d}.png", partial(cartoon_picture, scene)
    for name, make in CLOSING_PICTURES.items():
        yield f"stimuli/closing/{name}-plausible.png", partial(make, plausible=True)
        yield f"stimuli/closing/{name}-implausible.png", partial(make, plausible=False)


def _png(picture: Image) -> bytes:
    stream = BytesIO()
    picture.save(stream, "PNG", compress_level=1)
    return stream.getvalue()
