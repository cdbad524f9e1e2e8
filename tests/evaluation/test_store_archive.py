"""Tests of archives of stores, and of merging stores."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

from evaluation.blob_store import BLOBS, BlobStore, blob_files
from evaluation.grid_status import grid_summary
from evaluation.row_store import ROWS, RowStore
from evaluation.store_archive import MANIFEST, archive_store, verify_archive
from evaluation.store_merge import merge_stores
from shading_model.errors import RelightlabError
from tests.evaluation.small_grids import rows_of, small_experiment

KEYS = ("ab" * 32, "cd" * 32)


@pytest.fixture
def store(tmp_path: Path) -> Path:
    """A store of twelve rows and two blobs."""
    folder = tmp_path / "store"
    RowStore(folder / ROWS).append(rows_of(small_experiment()))
    for key in KEYS:
        add_blob(folder, key)
    return folder


def add_blob(folder: Path, key: str) -> Path:
    """Keep the key's own text under it."""
    blobs = BlobStore(folder / BLOBS, ".txt")
    blobs.get_or_make(key, lambda: key, Path.read_text, Path.write_text)
    return blobs.path(key)


def changed(archive: Path, **members: bytes | None) -> Path:
    """Return a copy of an archive with some members replaced, or left out for None."""
    copy = archive.with_name("changed.zip")
    with zipfile.ZipFile(archive) as source, zipfile.ZipFile(copy, "w") as target:
        kept = {name: source.read(name) for name in source.namelist()}
        for name, content in {**kept, **members}.items():
            if content is not None:
                target.writestr(name, content)
    return copy


def test_an_archive_is_the_same_bytes_wherever_it_is_made(store: Path, tmp_path: Path) -> None:
    """The same rows and blobs give the same bytes, and a summary that verifying gives again."""
    first, second = tmp_path / "a.zip", tmp_path / "b.zip"
    summary = archive_store(store, first)
    archive_store(store, second)
    assert first.read_bytes() == second.read_bytes()
    assert verify_archive(first) == summary
    assert summary.sentence() == "12 rows of small 1, 2 blobs"


def test_any_changed_byte_is_found(store: Path, tmp_path: Path) -> None:
    """An archive with one byte changed is refused wherever that byte lies, or reads the same."""
    whole = tmp_path / "a.zip"
    summary = archive_store(store, whole)
    content, copy = whole.read_bytes(), tmp_path / "b.zip"
    found = 0
    for place in range(0, len(content), 7):
        copy.write_bytes(content[:place] + bytes([content[place] ^ 16]) + content[place + 1 :])
        try:
            assert verify_archive(copy) == summary
        except RelightlabError:
            found += 1
    assert found > len(content) // 7 // 2


@pytest.mark.parametrize(
    ("members", "words"),
    [
        ({ROWS: b"nothing"}, "rows.jsonl does not fit its SHA-256"),
        ({ROWS: None}, "rows.jsonl is missing"),
        ({"more.txt": b"more"}, "more.txt is not in the manifest"),
        ({MANIFEST: None}, "no archive made by 'grid archive'"),
        ({MANIFEST: b"[]"}, "damaged or no archive"),
        ({MANIFEST: b'{"format": "x", "version": 9}'}, "archive of format x 9"),
    ],
)
def test_what_is_wrong_is_named(
    store: Path, tmp_path: Path, members: dict[str, bytes | None], words: str
) -> None:
    """The member at fault is named, and what is wrong with it."""
    archive_store(store, tmp_path / "a.zip")
    with pytest.raises(RelightlabError, match=words):
        verify_archive(changed(tmp_path / "a.zip", **members))


def test_files_that_are_no_archives(tmp_path: Path) -> None:
    """A missing file, a cut one, another suffix and a folder without rows are told apart."""
    with pytest.raises(RelightlabError, match="no such file"):
        verify_archive(tmp_path / "none.zip")
    (tmp_path / "cut.zip").write_bytes(b"PK")
    with pytest.raises(RelightlabError, match="damaged or no archive"):
        verify_archive(tmp_path / "cut.zip")
    with pytest.raises(RelightlabError, match=r"end in \.zip"):
        archive_store(tmp_path, tmp_path / "a.tar")
    with pytest.raises(RelightlabError, match=r"is no store: it has no rows\.jsonl"):
        archive_store(tmp_path, tmp_path / "a.zip")


def test_damaged_blobs_are_left_out_and_named(store: Path, tmp_path: Path) -> None:
    """An archive holds good blobs only, and says which it left out and why."""
    add_blob(store, KEYS[0]).write_text("damaged")
    summary = archive_store(store, tmp_path / "a.zip")
    assert summary.blobs == 1
    assert len(summary.left_out) == 1
    assert "does not fit its SHA-256" in summary.left_out[0]


def test_merging_is_a_union(store: Path, tmp_path: Path) -> None:
    """Stores of half the cells each make one of all, with all blobs; twice is as once."""
    rows = rows_of(small_experiment())
    half = tmp_path / "half"
    RowStore(half / ROWS).append(rows[:7])
    add_blob(half, "ef" * 32)
    archive_store(store, tmp_path / "a.zip")
    first = merge_stores(half, [tmp_path / "a.zip", store])
    assert (first.rows, first.blobs) == (5, 2)
    assert RowStore(half / ROWS).read()[0] == rows
    assert len(list(blob_files(half / BLOBS))) == 3
    before = (half / ROWS).read_bytes()
    assert merge_stores(half, [store, half]).document() == {
        "rows": 0,
        "blobs": 0,
        "damaged_lines": 0,
        "damaged_blobs": 0,
    }
    assert (half / ROWS).read_bytes() == before


def test_a_failure_undoes_no_result(store: Path, tmp_path: Path) -> None:
    """Failed rows of a source count where the target has none, never against a done cell."""
    experiment = small_experiment()
    failed = rows_of(experiment, "failed", reason="ValueError: no light", values={})
    source, empty = tmp_path / "source", tmp_path / "empty"
    RowStore(source / ROWS).append(failed)
    assert merge_stores(store, [source]).rows == 0
    assert merge_stores(empty, [source]).rows == 12
    assert merge_stores(empty, [source]).rows == 0
    assert grid_summary(experiment, RowStore(empty / ROWS)).failed == 12
    assert merge_stores(empty, [store]).rows == 12
    assert grid_summary(experiment, RowStore(empty / ROWS)).done == 12


def test_damage_is_not_merged(store: Path, tmp_path: Path) -> None:
    """Damaged lines and blobs of a source are left out and counted."""
    with (store / ROWS).open("ab") as stream:
        stream.write(b"nonsense\n")
    add_blob(store, KEYS[0]).write_text("damaged")
    summary = merge_stores(tmp_path / "target", [store])
    assert summary.document() == {"rows": 12, "blobs": 1, "damaged_lines": 1, "damaged_blobs": 1}
    assert "1 damaged lines and 1 damaged blobs left out" in summary.sentence()


def test_other_protocol_versions_do_not_mix(store: Path, tmp_path: Path) -> None:
    """A source of another version is refused, and nothing of it or of others was merged."""
    other = tmp_path / "other"
    RowStore(other / ROWS).append(rows_of(small_experiment(version=2)))
    target = tmp_path / "target"
    with pytest.raises(RelightlabError, match=r"of protocol small 1 and .* of version 2"):
        merge_stores(target, [store, other])
    assert not target.exists()
    with pytest.raises(RelightlabError, match="is no store"):
        merge_stores(store, [tmp_path])
