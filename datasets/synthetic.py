"""The synthetic set: made once from a seed, checked by its manifest, read as a dataset.

Twenty procedural objects in the two settings of MIT-Berkeley. A folder holds one file per object
(see `datasets.synthetic_objects`) and ``manifest.json``, written last: without it, or with a file
that does not match it, a set is unfinished or damaged and `synthetic_root` makes it again.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import joblib

from datasets.atomic import atomic_path
from datasets.locations import user_cache
from datasets.records import Capture, LitPhotograph
from datasets.synthetic_manifest import (
    FORMAT,
    GENERATOR_VERSION,
    MANIFEST,
    digest_of,
    is_whole,
    parameters_of,
    read_manifest,
)
from datasets.synthetic_objects import SyntheticObject, load_object, make_object, save_object
from datasets.synthetic_shapes import SHAPES
from datasets.worker_processes import leave_interrupts_to_the_parent
from shading_model.errors import RelightlabError, unknown_name

DEFAULT_SIZE, DEFAULT_SEED, DEFAULT_SAMPLES = 300, 0, 16
SMALLEST_SIZE = 32

Progress = Callable[[int, int, str], None]
"""Called with how many objects are done, how many there are, and the name just done."""


def synthesize(
    out_dir: str | os.PathLike[str],
    *,
    size: int = DEFAULT_SIZE,
    seed: int = DEFAULT_SEED,
    objects: Sequence[str] | None = None,
    samples: int = DEFAULT_SAMPLES,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Synthetic:
    """Make the synthetic set in a folder.

    The same size, seed, objects and samples give the same bytes, whatever the number of workers;
    an object is the same whichever others are made with it.

    Parameters
    ----------
    out_dir : path
        Created if needed; files of an earlier set in it are replaced.
    size : int
        Side in pixels of the square picture an object is made in, at least 32.
    seed : int
        Whole number, at least 0.
    objects : sequence of str, optional
        Which of `datasets.synthetic_shapes.SHAPES`; all twenty by default.
    samples : int
        Light paths per pixel of a laboratory photograph.
    workers : int, optional
        Processes, each with one thread; as many as there are processors by default.
    progress : callable, optional
        See `Progress`.

    Returns
    -------
    Synthetic
        The set just made.

    Raises
    ------
    RelightlabError
        If a parameter is out of range, a name unknown, or the folder cannot be written to.
    """
    names = _checked_names(objects)
    _check_numbers(size, seed, samples, workers)
    folder = Path(out_dir)
    manifest = parameters_of(size, seed, samples)
    # A manifest of an earlier set must not vouch for the files that are about to change.
    _remove(folder / MANIFEST)
    tasks = [(folder / f"{name}.npz", name, size, seed, samples) for name in names]
    digests = dict.fromkeys(names, "")
    for done, (name, digest) in enumerate(_made(tasks, workers), start=1):
        digests[name] = digest
        if progress is not None:
            progress(done, len(names), name)
    manifest["files"] = {f"{name}.npz": digest for name, digest in digests.items()}
    with atomic_path(folder / MANIFEST) as path:
        path.write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")
    return Synthetic(folder)


def synthetic_root(
    cache: str | os.PathLike[str] | None = None,
    *,
    size: int = DEFAULT_SIZE,
    seed: int = DEFAULT_SEED,
    objects: Sequence[str] | None = None,
    samples: int = DEFAULT_SAMPLES,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Path:
    """Return the folder of the synthetic set, making the set first where it is not whole.

    Parameters
    ----------
    cache : path, optional
        Folder that keeps generated sets; the user's cache by default.
    size, seed, objects, samples, workers, progress
        As for `synthesize`.

    Returns
    -------
    Path
        ``synthetic-<version>-<size>-<seed>`` under the cache.

    Raises
    ------
    RelightlabError
        As `synthesize`.
    """
    base = user_cache() if cache is None else Path(cache)
    folder = base / f"synthetic-{GENERATOR_VERSION}-{size}-{seed}"
    wanted = parameters_of(size, seed, samples)
    if not is_whole(folder, wanted, _checked_names(objects)):
        synthesize(
            folder,
            size=size,
            seed=seed,
            objects=objects,
            samples=samples,
            workers=workers,
            progress=progress,
        )
    return folder


class Synthetic:
    """The synthetic set of a folder, as a `datasets.records.Dataset`.

    Parameters
    ----------
    root : path
        A folder made by `synthesize`.

    Raises
    ------
    RelightlabError
        If the folder holds no finished set; on loading, if a file is missing or damaged.
    """

    def __init__(self, root: str | os.PathLike[str]) -> None:
        self.root = Path(root)
        self._files: dict[str, str] = dict(read_manifest(self.root)["files"])

    @property
    def name(self) -> str:
        """Name used in tables and on the command line."""
        return "synthetic"

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the objects that were made."""
        return tuple(file.removesuffix(".npz") for file in self._files)

    @property
    def settings(self) -> tuple[str, ...]:
        """``natural`` and ``laboratory``."""
        return ("natural", "laboratory")

    def load(self, name: str, setting: str) -> Capture:
        """Return one object in one setting.

        Raises
        ------
        RelightlabError
            If the name or the setting is unknown, or the file is missing or damaged.
        """
        if setting not in self.settings:
            raise unknown_name("setting", setting, self.settings)
        loaded = self._object(name)
        return loaded.natural() if setting == "natural" else loaded.laboratory()

    def lit_photographs(self, name: str) -> tuple[LitPhotograph, ...]:
        """Return the object's ten photographs under other laboratory lamps.

        Raises
        ------
        RelightlabError
            If the name is unknown, or the file is missing or damaged.
        """
        return self._object(name).lit_photographs()

    def fingerprint(self) -> str:
        """Return a SHA-256, in hexadecimal, over the names and hashes of the set's files."""
        listing = "".join(f"{digest}  {file}\n" for file, digest in sorted(self._files.items()))
        return hashlib.sha256(f"{FORMAT}\n{listing}".encode()).hexdigest()

    def _object(self, name: str) -> SyntheticObject:
        if name not in self.objects:
            raise unknown_name("object", name, self.objects)
        path = self.root / f"{name}.npz"
        if digest_of(path) != self._files[path.name]:
            raise RelightlabError(
                f"{path} is missing or damaged: make the synthetic set again"
                " (relightlab data synthesize)"
            )
        return load_object(path)


def _made(
    tasks: list[tuple[Path, str, int, int, int]], workers: int | None
) -> Iterator[tuple[str, str]]:
    """Yield the name and SHA-256 of each object as it is finished."""
    count = min(len(tasks), workers or os.cpu_count() or 1)
    if count == 1:
        yield from (_make_file(*task) for task in tasks)
        return
    with joblib.parallel_config(
        backend="loky", inner_max_num_threads=1, initializer=leave_interrupts_to_the_parent
    ):
        run = joblib.Parallel(n_jobs=count, return_as="generator_unordered")
        yield from run(joblib.delayed(_make_file_on_one_thread)(*task) for task in tasks)


def _make_file(path: Path, name: str, size: int, seed: int, samples: int) -> tuple[str, str]:
    save_object(path, make_object(name, size, seed, samples))
    return name, digest_of(path)


def _make_file_on_one_thread(
    path: Path, name: str, size: int, seed: int, samples: int
) -> tuple[str, str]:
    import drjit  # noqa: PLC0415  only the workers hold the renderer to one thread

    drjit.set_thread_count(1)
    return _make_file(path, name, size, seed, samples)


def _remove(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise RelightlabError(
            f"cannot write {path.parent}: {error.strerror or error}; choose another output"
        ) from error


def _checked_names(objects: Sequence[str] | None) -> tuple[str, ...]:
    names = tuple(SHAPES) if objects is None else tuple(dict.fromkeys(objects))
    if not names:
        raise RelightlabError("expected at least one object to synthesize, got none")
    for name in names:
        if name not in SHAPES:
            raise unknown_name("object", name, SHAPES)
    return names


def _check_numbers(size: int, seed: int, samples: int, workers: int | None) -> None:
    for what, value, least in (
        ("a picture size", size, SMALLEST_SIZE),
        ("a seed", seed, 0),
        ("samples per pixel", samples, 1),
        ("a number of workers", 1 if workers is None else workers, 1),
    ):
        if value < least:
            raise RelightlabError(f"expected {what} of at least {least}, got {value}")
