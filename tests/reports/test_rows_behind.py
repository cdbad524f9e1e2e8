"""Tests of reports.rows_behind."""

from __future__ import annotations

import hashlib
import json

import pytest

from reports.rows_behind import rows_behind
from shading_model.errors import RelightlabError
from tests.reports.small_result import SmallResult, small_result

__all__ = ["small_result"]


def test_hash_is_of_the_rows_alone(small_result: SmallResult) -> None:
    """The hash can be computed from the results file, and moves with any value in the rows."""
    document = small_result.document
    behind = rows_behind(document, "rows", "published")
    parts = json.loads(json.dumps([document["rows"], document["published"]]))
    text = json.dumps(parts, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    assert behind.digest == hashlib.sha256(text.encode()).hexdigest()
    assert behind.count == len(document["rows"]) + len(document["published"])
    assert rows_behind(document | {"provenance": {}}, "rows", "published") == behind
    changed = [*document["rows"][1:], document["rows"][0] | {"imse": 1.0}]
    assert rows_behind(document | {"rows": changed}, "rows", "published").digest != behind.digest


def test_unknown_part_of_the_results_is_named() -> None:
    """A part that the results do not have is refused with those they have."""
    with pytest.raises(RelightlabError, match=r"Did you mean 'rows'\?"):
        rows_behind({"rows": []}, "row")
