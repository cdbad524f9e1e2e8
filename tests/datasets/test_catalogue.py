"""The list of known sets and the record of the published files."""

from __future__ import annotations

import re
from pathlib import Path

from datasets.catalogue import (
    KNOWN_DATASETS,
    MIT_BERKELEY_LICENCE,
    known_datasets,
    mit_berkeley_files,
    present_sets,
)


def test_rows_of_a_data_root(tmp_path: Path) -> None:
    """Every known set has a row, and the row of a present one counts its files and bytes."""
    (tmp_path / "hdri").mkdir()
    (tmp_path / "hdri" / "park.exr").write_bytes(bytes(10))
    (tmp_path / "mit-berkeley").mkdir()
    rows = {row.name: row for row in known_datasets(tmp_path)}
    assert list(rows) == [known.name for known in KNOWN_DATASETS]
    assert (rows["hdri"].present, rows["hdri"].files, rows["hdri"].bytes) == (True, 1, 10)
    assert not rows["mit-berkeley"].present
    assert present_sets(tmp_path) == ("hdri",)


def test_every_set_says_what_it_is() -> None:
    """Each known set has a unique name, a licence and a description."""
    assert len({known.name for known in KNOWN_DATASETS}) == len(KNOWN_DATASETS)
    assert all(known.licence and known.description for known in KNOWN_DATASETS)


def test_licence_states_the_terms() -> None:
    """The licence names its holder and the three permitted uses."""
    for term in ("Regents", "education", "research", "not-for-profit", "copyright notice"):
        assert term in MIT_BERKELEY_LICENCE


def test_recorded_files() -> None:
    """The record holds a SHA-256 for 20 files of each laboratory object and 6 of each natural."""
    recorded = mit_berkeley_files()
    assert re.fullmatch(r"[0-9a-f]{40}", recorded.commit)
    assert all(re.fullmatch(r"[0-9a-f]{64}", value) for value in recorded.sha256.values())
    folders = [name.rpartition("/")[0] for name in recorded.sha256]
    counts = {folder: folders.count(folder) for folder in folders}
    laboratory = {k: v for k, v in counts.items() if k.startswith("MIT-Berkeley-Laboratory/")}
    natural = {k: v for k, v in counts.items() if k.startswith("MIT-Berkeley-Natural/")}
    assert (len(laboratory), set(laboratory.values())) == (20, {20})
    assert (len(natural), set(natural.values())) == (20, {6})
    assert set(counts) - set(laboratory) - set(natural) == {""}
