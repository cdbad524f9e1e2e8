"""Archives of arrays with the same bytes everywhere."""

from __future__ import annotations

import io
import zipfile

import numpy as np

from datasets.array_archive import add_member, npy_bytes


def archive_of(values: np.ndarray) -> bytes:
    """Return a ZIP file with one array."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        add_member(archive, "values.npy", npy_bytes(values))
    return stream.getvalue()


def test_arrays_come_back() -> None:
    """NumPy reads what was written, whatever the strides and byte order."""
    values = np.arange(12.0).reshape(3, 4).T[::-1].astype(">f8")
    with np.load(io.BytesIO(archive_of(values))) as arrays:
        assert np.array_equal(arrays["values"], values)


def test_a_single_number_stays_one() -> None:
    """An array without axes comes back without axes."""
    with np.load(io.BytesIO(archive_of(np.array(2.5)))) as arrays:
        assert arrays["values"].shape == ()


def test_members_carry_no_clock_machine_or_python() -> None:
    """Date, system and the version needed to read are fixed, and no member is marked as large."""
    with zipfile.ZipFile(io.BytesIO(archive_of(np.zeros(1000)))) as archive:
        (member,) = archive.infolist()
    assert member.date_time == (1980, 1, 1, 0, 0, 0)
    assert (member.create_system, member.create_version, member.extract_version) == (3, 20, 20)
    assert member.extra == b""
