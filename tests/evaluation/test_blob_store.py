"""Tests of the blob store: nothing damaged is read, nothing good is made twice."""

from __future__ import annotations

import hashlib
import logging
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from evaluation.blob_store import BlobStore, blob_fault, blob_files, blob_key, copy_blob
from shading_model.errors import RelightlabError

KEY = blob_key({"photograph": "ab"}, {"slope": "0.1"}, "1")


class Maker:
    """Makes a text and counts how often."""

    def __init__(self) -> None:
        self.count = 0

    def __call__(self) -> str:
        """Return the text."""
        self.count += 1
        return "costly"

    def get(self, store: BlobStore) -> str:
        """Return the text of the key through a store."""
        return store.get_or_make(KEY, self, Path.read_text, Path.write_text)


@pytest.fixture
def store(tmp_path: Path) -> BlobStore:
    """A store that is not there yet."""
    return BlobStore(tmp_path / "blobs", ".txt")


def damage_content(path: Path) -> None:
    """Change one byte and keep the length."""
    path.write_text("Costly")


def delete_content(path: Path) -> None:
    """Delete the content and leave the side file."""
    path.unlink()


def delete_side(path: Path) -> None:
    """Delete the side file, as a crash between the two moves would."""
    path.with_name(path.name + ".sha256").unlink()


def damage_side(path: Path) -> None:
    """Cut the side file."""
    path.with_name(path.name + ".sha256").write_text("0")


def test_a_blob_is_made_once(store: BlobStore) -> None:
    """The second time it is read; it lies under its key, with its SHA-256 beside it."""
    maker = Maker()
    assert [maker.get(store), maker.get(store), maker.count] == ["costly", "costly", 1]
    path = store.folder / KEY[:2] / f"{KEY[2:]}.txt"
    digest = hashlib.sha256(b"costly").hexdigest()
    assert path.with_name(path.name + ".sha256").read_text() == f"{digest}  {path.name}\n"
    assert list(blob_files(store.folder)) == [path]
    assert len(list(path.parent.iterdir())) == 2


@pytest.mark.parametrize(
    ("harm", "words"),
    [
        (damage_content, "does not fit its SHA-256"),
        (delete_content, "its content was deleted"),
        (delete_side, "its SHA-256 was not written"),
        (damage_side, "does not fit its SHA-256"),
    ],
)
def test_what_is_not_good_is_reported_and_made_again(
    store: BlobStore,
    harm: Callable[[Path], None],
    words: str,
    caplog: pytest.LogCaptureFixture,
) -> None:
    """A damaged or deleted blob is told, made again, and good from then on."""
    maker = Maker()
    maker.get(store)
    harm(store.path(KEY))
    with caplog.at_level(logging.WARNING):
        assert maker.get(store) == "costly"
    assert [record.getMessage().count(words) for record in caplog.records] == [1]
    assert maker.count == 2
    assert blob_fault(store.path(KEY)) is None


def test_a_blob_that_cannot_be_read_is_made_again(store: BlobStore) -> None:
    """Whole bytes that the reader refuses, of an older format perhaps, are made again."""
    Maker().get(store)

    def refuse(_path: Path) -> str:
        raise RelightlabError("a file of another version")

    assert store.get_or_make(KEY, lambda: "new", refuse, Path.write_text) == "new"


def test_a_fault_in_making_leaves_nothing(store: BlobStore) -> None:
    """Failures are never cached: neither a blob nor a temporary file stays."""

    def fail(path: Path, _value: str) -> None:
        path.write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(ZeroDivisionError):
        store.get_or_make(KEY, lambda: str(1 // 0), Path.read_text, Path.write_text)
    with pytest.raises(RelightlabError, match="No space left"):
        store.get_or_make(KEY, Maker(), Path.read_text, fail)
    assert list(store.path(KEY).parent.iterdir()) == []


def test_a_folder_that_cannot_be_written(tmp_path: Path) -> None:
    """A store below a file is told in one sentence."""
    (tmp_path / "file").touch()
    with pytest.raises(RelightlabError, match=r"cannot write .*choose another output"):
        Maker().get(BlobStore(tmp_path / "file" / "blobs"))


def test_many_makers_at_once(store: BlobStore) -> None:
    """Makers of one key at once, each with bytes of its own, leave one whole blob."""

    def make(number: int) -> str:
        text = str(number) * 10_000
        return store.get_or_make(KEY, lambda: text, Path.read_text, Path.write_text)

    with ThreadPoolExecutor(8) as pool:
        got = list(pool.map(make, range(40)))
    assert blob_fault(store.path(KEY)) is None
    assert store.path(KEY).read_text() in got
    assert all(len(set(text)) in {1, 2} for text in got)


def test_keys_depend_on_everything() -> None:
    """Another input, parameter or version of the code is another key; order plays no part."""
    keys = {
        blob_key({"a": "1", "b": "2"}, {}, "1"),
        blob_key({"a": "1"}, {"b": "2"}, "1"),
        blob_key({"a": "1", "b": "3"}, {}, "1"),
        blob_key({"a": "1", "b": "2"}, {}, "2"),
    }
    assert len(keys) == 4
    assert blob_key({"b": "2", "a": "1"}, {}, "1") in keys


def test_copies_are_whole_and_made_once(store: BlobStore, tmp_path: Path) -> None:
    """A blob is copied where it is lacking or damaged, and not where it is good."""
    Maker().get(store)
    other = tmp_path / "other"
    assert copy_blob(store.path(KEY), other)
    assert not copy_blob(store.path(KEY), other)
    os.truncate(BlobStore(other, ".txt").path(KEY), 1)
    assert copy_blob(store.path(KEY), other)
    assert BlobStore(other, ".txt").path(KEY).read_text() == "costly"
