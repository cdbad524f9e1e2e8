"""Files that are either whole or absent under their final name."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from shading_model.errors import RelightlabError


@contextmanager
def atomic_path(target: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path in the target's folder, moved onto `target` when the block ends well.

    The temporary file keeps the target's suffix, is flushed to disk before the move, and is
    removed if the block raises.

    Raises
    ------
    RelightlabError
        If the folder cannot be written to.

    Examples
    --------
    >>> folder = tempfile.mkdtemp()
    >>> with atomic_path(Path(folder) / "a.txt") as path:
    ...     _ = path.write_text("whole")
    >>> (Path(folder) / "a.txt").read_text()
    'whole'
    """
    final = Path(target)
    try:
        final.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            dir=final.parent, prefix=f".{final.stem}-", suffix=final.suffix
        )
        os.close(handle)
    except OSError as error:
        raise RelightlabError(
            f"cannot write {final}: {error.strerror or error}; choose another output"
        ) from error
    temporary = Path(name)
    try:
        yield temporary
        _flush(temporary)
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(final)
    except OSError as error:
        if error.filename not in {None, str(temporary)}:
            raise  # another file's trouble, which the block met while it made the content
        raise RelightlabError(
            f"cannot write {final}: {error.strerror or error}; choose another output"
        ) from error
    finally:
        temporary.unlink(missing_ok=True)


def _flush(path: Path) -> None:
    with path.open("rb+") as stream:
        os.fsync(stream.fileno())


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
