"""Table 1 as a JSON document."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import pytest

from evaluation.provenance import Provenance, provenance_of
from evaluation.table1 import PROTOCOL, PROTOCOL_VERSION
from evaluation.table1_record import Table1
from evaluation.table1_results import table1_document
from tests.evaluation.conftest import LIGHTS, OBJECTS


@pytest.fixture(scope="module")
def provenance() -> Provenance:
    """Where the tiny table came from."""
    return provenance_of(
        protocol=f"{PROTOCOL} version {PROTOCOL_VERSION}",
        dataset="synthetic",
        data_hash="0" * 64,
        seeds={},
        seconds=1.0,
        workers=1,
        cells_done=2 * len(OBJECTS) * len(LIGHTS),
        cells_missing=0,
    )


@pytest.fixture(scope="module")
def document(tiny_table: Table1, provenance: Provenance) -> dict[str, Any]:
    """The document of the tiny table."""
    return table1_document(tiny_table, provenance)


def test_the_document_is_json_without_nan(document: dict[str, Any]) -> None:
    """Strict JSON, the same after a round trip."""
    assert json.loads(json.dumps(document, allow_nan=False)) == document


def test_the_document_holds_every_number(document: dict[str, Any], tiny_table: Table1) -> None:
    """Rows, baselines, objects and intrinsic figures are the table's own."""
    assert document["rows"] == tiny_table.rows()
    assert document["baselines"] == tiny_table.baselines()
    assert document["objects"] == tiny_table.object_rows()
    assert document["intrinsic"] == tiny_table.intrinsic_rows()
    assert document["protocol"]["lights"] == len(LIGHTS)
    assert document["protocol"]["version"] == PROTOCOL_VERSION


def test_the_published_table_stands_beside_ours(document: dict[str, Any]) -> None:
    """All fourteen published values (`tab:mse`), and the entries that are open."""
    published = {
        (e["setting"], e["method"], e["detail_source"], e["weights"]): e["imse"]
        for e in document["published"]
    }
    assert len(published) == len(document["published"]) == 14
    assert published["natural", "ours", "gt-shading", "oracle"] == 0.0206
    assert published["laboratory", "sirfs", "default", "none"] == 0.0372
    computed = {(r["setting"], r["method"], r["detail_source"]) for r in document["rows"]}
    open_entries = {(e["setting"], e["method"], e["detail_source"]) for e in document["open"]}
    assert {key[:3] for key in published} == computed | open_entries
    assert not computed & open_entries


def test_an_unknown_number_is_none(tiny_table: Table1, provenance: Provenance) -> None:
    """JSON has no NaN: the regression of a set of one object is null."""
    alone = dataclasses.replace(
        tiny_table,
        objects=("cup",),
        results=tuple(result for result in tiny_table.results if result.name == "cup"),
    )
    document = table1_document(alone, provenance)
    text = json.dumps(document, allow_nan=False)
    for row in json.loads(text)["rows"]:
        assert (row["imse"] is None) == (row["weights"] == "regression")
