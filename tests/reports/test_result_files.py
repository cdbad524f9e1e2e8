"""Tests of result files."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reports.result_files import require_writable, write_csv, write_json
from shading_model.errors import RelightlabError

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)


@given(number=NUMBERS)
def test_numbers_keep_every_digit(tmp_path_factory: pytest.TempPathFactory, number: float) -> None:
    """A number is read back from JSON and from CSV to the last bit."""
    folder = tmp_path_factory.getbasetemp()
    write_json(folder / "a.json", {"number": number})
    assert json.loads((folder / "a.json").read_text())["number"] == number
    write_csv(folder / "a.csv", [{"number": number}])
    with (folder / "a.csv").open(encoding="utf-8") as stream:
        assert float(next(iter(csv.DictReader(stream)))["number"]) == number


def test_nan_is_not_written(tmp_path: Path) -> None:
    """JSON has no NaN: a document with one is a fault of ours, and leaves no file."""
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(tmp_path / "a.json", {"number": math.nan})
    assert list(tmp_path.iterdir()) == []


def test_what_is_missing_is_an_empty_field(tmp_path: Path) -> None:
    """None becomes nothing between commas."""
    write_csv(tmp_path / "a.csv", [{"a": None, "b": "é"}])
    assert (tmp_path / "a.csv").read_text(encoding="utf-8") == "a,b\n,é\n"


def test_outputs_are_tried_before_the_work(tmp_path: Path) -> None:
    """A good output leaves no trace of the trial and keeps what it held; a bad one is refused."""
    kept = tmp_path / "kept.json"
    kept.write_text("{}")
    require_writable(kept, None, tmp_path / "new" / "table.csv")
    assert kept.read_text() == "{}"
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["kept.json"]
    with pytest.raises(RelightlabError, match="cannot write"):
        require_writable(kept / "below-a-file.json")
