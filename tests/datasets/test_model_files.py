"""Tests of model files."""

from __future__ import annotations

import dataclasses
import io
import json
import re
import zipfile
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from datasets.model_files import HEADER, MAPS, load_model, read_model_header, save_model
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics, PointLights
from shading_model.object_model import ObjectModel, Weights
from tests.example_objects import disk_model


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return a model file that has just been written."""
    path = tmp_path / "model.npz"
    save_model(path, disk_model(), name="disk", source="a test")
    return path


def rewritten(path: Path, **members: bytes) -> Path:
    """Replace members of an archive, keeping the others."""
    with zipfile.ZipFile(path) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    contents |= {name.replace("_json", ".json"): content for name, content in members.items()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in contents.items():
            archive.writestr(name, content)
    return path


def with_header(path: Path, **changes: object) -> Path:
    """Change keys of a model file's header."""
    header = json.dumps(read_model_header(path) | changes).encode()
    return rewritten(path, header_json=header)


def assert_same(first: ObjectModel, second: ObjectModel) -> None:
    """Assert that two models are equal to the last bit."""
    for name in MAPS:
        one, other = getattr(first, name), getattr(second, name)
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other, strict=True)
    np.testing.assert_array_equal(first.illumination.positions, second.illumination.positions)
    np.testing.assert_array_equal(first.illumination.intensities, second.illumination.intensities)


def test_a_loaded_model_is_the_saved_one(file: Path) -> None:
    """Saving and loading changes no bit, so the model relights to the same bits."""
    loaded = load_model(file)
    assert_same(loaded, disk_model())
    light, weights = LogHarmonics(np.linspace(-1, 1, 9)), Weights(0.7, 1.3)
    np.testing.assert_array_equal(
        loaded.relight(light, weights), disk_model().relight(light, weights)
    )


def test_the_same_model_gives_the_same_bytes(file: Path, tmp_path: Path) -> None:
    """A file holds no clock: written again, from the loaded model too, it has the same bytes."""
    save_model(tmp_path / "again.npz", load_model(file), name="disk", source="a test")
    assert (tmp_path / "again.npz").read_bytes() == file.read_bytes()


def test_numpy_reads_the_arrays(file: Path) -> None:
    """The file is an ordinary archive of arrays, none of them pickled."""
    with np.load(file, allow_pickle=False) as arrays:
        assert set(arrays.files) == {*MAPS, HEADER}
        for name in MAPS:
            np.testing.assert_array_equal(arrays[name], getattr(disk_model(), name))


def test_the_header_describes_the_file(file: Path) -> None:
    """The header gives format, version, origin, arrays and light."""
    header = read_model_header(file)
    assert (header["format"], header["version"]) == ("relightlab object model", 1)
    assert (header["name"], header["source"]) == ("disk", "a test")
    assert header["written_by"] == version("relightlab")
    assert header["arrays"]["albedo"] == {"shape": [40, 40, 3], "dtype": "float64"}
    assert header["light"]["intensities"] == disk_model().illumination.intensities.tolist()


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.9, 0.999])
def test_a_truncated_file_is_refused(file: Path, share: float) -> None:
    """Wherever it breaks off, a file is called damaged, by its name."""
    content = file.read_bytes()
    file.write_bytes(content[: int(share * len(content))])
    with pytest.raises(RelightlabError, match=re.escape(f"{file} is damaged")):
        load_model(file)


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.floats(0, 1, exclude_max=True), flipped=st.integers(1, 255))
def test_a_changed_byte_is_found(file: Path, place: float, flipped: int) -> None:
    """Any changed byte leads to an error, or to the same model (a date in the archive)."""
    content = bytearray(file.read_bytes())
    whole = bytes(content)
    content[int(place * len(content))] ^= flipped
    file.write_bytes(content)
    try:
        assert_same(load_model(file), disk_model())
    except RelightlabError as error:
        assert str(file) in str(error)  # noqa: PT017  either outcome is right
    finally:
        file.write_bytes(whole)


def test_changed_arrays_do_not_match_the_hash(file: Path) -> None:
    """An array replaced by a valid one is found by the SHA-256."""
    stream = io.BytesIO()
    np.save(stream, disk_model().height + 1)
    rewritten(file, **{"height.npy": stream.getvalue()})
    with pytest.raises(RelightlabError, match="do not match the SHA-256"):
        load_model(file)


def test_pickled_arrays_are_refused(file: Path, tmp_path: Path) -> None:
    """A pickle in place of an array is not read, even when the hash is its own."""
    trace = tmp_path / "executed"
    stream = io.BytesIO()
    np.save(stream, np.array([_Touch(trace)], dtype=object), allow_pickle=True)
    rewritten(file, **{"height.npy": stream.getvalue()})
    with zipfile.ZipFile(file) as archive:
        import hashlib

        digest = hashlib.sha256()
        for name in MAPS:
            digest.update(name.encode() + archive.read(f"{name}.npy"))
    with_header(file, sha256=digest.hexdigest())
    with pytest.raises(RelightlabError, match="is damaged"):
        load_model(file)
    assert not trace.exists()


class _Touch:
    """An object whose pickle makes a file when it is read."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[object, tuple[Path]]:
        return Path.touch, (self.path,)


def test_other_versions_are_refused(file: Path) -> None:
    """A file of another version of the format says which one, and who wrote it."""
    with_header(file, version=2, written_by="9.9")
    with pytest.raises(RelightlabError, match=r"version 2, and .* reads version 1: .*\(9\.9\)"):
        load_model(file)


@pytest.mark.parametrize("header", [b"[]", b"{}", b"not json", b"\xff", b'{"format": 3}'])
def test_other_headers_are_refused(file: Path, header: bytes) -> None:
    """A header that is not ours is refused."""
    with pytest.raises(RelightlabError, match=r"is not a model file|is damaged"):
        load_model(rewritten(file, header_json=header))


@pytest.mark.parametrize("light", [None, {}, {"positions": [[1, 2]], "intensities": [1]}])
def test_other_lights_are_refused(file: Path, light: object) -> None:
    """A header without a usable light is refused."""
    with pytest.raises(RelightlabError, match="is damaged"):
        load_model(with_header(file, light=light))


def test_what_is_no_model_file_is_refused(tmp_path: Path) -> None:
    """A missing file, another suffix and an archive of other arrays each get a sentence."""
    with pytest.raises(RelightlabError, match="no such file"):
        load_model(tmp_path / "none.npz")
    with pytest.raises(RelightlabError, match="expected a model file"):
        load_model(tmp_path / "model.zip")
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with pytest.raises(RelightlabError, match=r"is not a model file: it has no header\.json"):
        load_model(tmp_path / "other.npz")
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(RelightlabError, match="cannot read"):
        load_model(tmp_path / "folder.npz")


def test_what_cannot_be_saved_is_refused(tmp_path: Path) -> None:
    """Another suffix, a light that is not finite, and a file for a folder: nothing is written."""
    with pytest.raises(RelightlabError, match=r"end in \.npz"):
        save_model(tmp_path / "model.zip", disk_model())
    dark = PointLights(np.array([[np.nan, 0, 1]]), np.array([1.0]))
    with pytest.raises(RelightlabError, match="NaN or infinite"):
        save_model(tmp_path / "model.npz", dataclasses.replace(disk_model(), illumination=dark))
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "file").touch()
    with pytest.raises(RelightlabError, match="cannot write"):
        save_model(tmp_path / "file" / "model.npz", disk_model())


def test_an_interrupted_write_leaves_the_old_file(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C half-way leaves the file as it was, and no other behind."""
    before = file.read_bytes()
    write = zipfile.ZipFile.writestr

    def interrupted(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, *rest: object) -> None:
        if entry.filename == "height.npy":
            raise KeyboardInterrupt
        write(archive, entry, *rest)

    monkeypatch.setattr(zipfile.ZipFile, "writestr", interrupted)
    with pytest.raises(KeyboardInterrupt):
        save_model(file, disk_model(), name="another")
    assert file.read_bytes() == before
    assert list(file.parent.iterdir()) == [file]
