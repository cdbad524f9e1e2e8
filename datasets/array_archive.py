"""Arrays in ZIP members whose bytes hold no clock, no machine and no version of Python."""

from __future__ import annotations

import io
import zipfile
from typing import Any

import numpy as np
from numpy.typing import NDArray


def npy_bytes(values: NDArray[Any]) -> bytes:
    r"""Return an array as the content of a ``.npy`` file, little-endian and C-contiguous.

    Parameters
    ----------
    values : array

    Examples
    --------
    >>> npy_bytes(np.zeros(2))[:6]
    b'\x93NUMPY'
    """
    stream = io.BytesIO()
    # Unlike ascontiguousarray, this leaves a single number without an axis.
    little_endian = np.asarray(values, dtype=values.dtype.newbyteorder("<"), order="C")
    np.lib.format.write_array(stream, little_endian, version=(1, 0), allow_pickle=False)
    return stream.getvalue()


def add_member(archive: zipfile.ZipFile, name: str, content: bytes, level: int = 6) -> None:
    """Add a compressed member; the same content gives the same bytes.

    ``numpy.savez`` would not do: it marks members as large or not by the version of Python.

    Parameters
    ----------
    archive : ZipFile
        Open for writing.
    name : str
    content : bytes
    level : int
        Of compression, 1 to 9.
    """
    # ZipInfo's own date is 1 January 1980, and its system is fixed here.
    entry = zipfile.ZipInfo(name)
    entry.create_system = 3
    entry.external_attr = 0o644 << 16
    archive.writestr(entry, content, zipfile.ZIP_DEFLATED, level)
