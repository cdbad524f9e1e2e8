"""Tests of Table 1 as text."""

from __future__ import annotations

from typing import Any

from evaluation.published_table1 import PUBLISHED
from reports.table1_entries import LEFT_OUT
from reports.table1_text import COLUMNS, TITLE, summary_lines, table1_lines, table1_title
from tests.reports.rival_rows import left_out

RULES = ("coarse", "default", "regression", "oracle", "manual")


def entry(setting: str, source: str, rule: str, imse: float | None) -> dict[str, Any]:
    """Return a row of the document."""
    return {
        "setting": setting,
        "method": "ours",
        "detail_source": source,
        "weights": rule,
        "imse": imse,
        "relative_imse": None if imse is None else 10 * imse,
    }


def document(imse: float | None = 0.01) -> dict[str, Any]:
    """Return a document in which every error is the same."""
    settings = ("natural", "laboratory")
    rival = [entry(s, "default", "none", imse) | {"method": "sirfs"} for s in settings]
    return {
        "rows": [
            entry(setting, source, rule, imse)
            for setting in settings
            for source in ("default", "sirfs-shading", "gt-shading")
            for rule in RULES
        ]
        + rival,
        "baselines": [entry(setting, "flat", "coarse", imse) for setting in settings],
        "published": list(PUBLISHED),
        "open": [],
        "objects": [
            {"object": name, "detail_source": "default", "weights": "oracle"}
            for name in ("a", "b", "a")
        ],
        "missing": [],
        "protocol": {"name": "table-1", "version": 1, "lights": 20, "channels": "gray"},
        "provenance": {
            "dataset": "mit-berkeley",
            "cells_done": 160,
            "cells_missing": 80,
            "seconds": 1.5,
            "workers": 2,
            "commit": "0123456789abcdef",
            "data_hash": "fedcba9876543210",
        },
    }


def test_every_entry_is_a_line() -> None:
    """Per setting: a flat shape, SIRFS, and five rules of three sources."""
    lines = table1_lines(document())
    assert lines.count(()) == 1
    assert len(lines) == 2 * (1 + 1 + 15) + 1
    assert {len(line) for line in lines if line} == {len(COLUMNS)}


def test_sirfs_has_a_line_of_its_own() -> None:
    """B + M stands once for each setting, with its number, beside the published one."""
    lines = [line for line in table1_lines(document()) if line[1:2] == ("B + M",)]
    assert lines == [
        ("natural", "B + M", "SIRFS", "none", "0.01000", "0.100", "0.0172"),
        ("laboratory", "B + M", "SIRFS", "none", "0.01000", "0.100", "0.0372"),
    ]


def test_what_a_quick_run_leaves_out_stays_in_sight() -> None:
    """Rows (b) and B + M say so, beside the published value, and have no number of ours."""
    lines = [line for line in table1_lines(left_out(document())) if LEFT_OUT in line]
    assert len(lines) == 6
    assert {line[5] for line in lines} == {"-"}
    published = {f"{row['imse']:.4f}" for row in PUBLISHED if row["method"] == "sirfs"}
    assert published < {line[6] for line in lines}


def test_every_published_value_is_shown_once() -> None:
    """The last column holds each value of the published table, in a quick run too."""
    for result in (document(), left_out(document())):
        shown = sorted(line[6] for line in table1_lines(result) if line and line[6] != "-")
        assert shown == sorted(f"{row['imse']:.4f}" for row in PUBLISHED)


def test_a_missing_number_is_a_dash() -> None:
    """A rule that had nothing to learn from shows no number."""
    assert all(line[4] == "-" for line in table1_lines(document(None)) if line)


def test_the_summary_has_five_lines() -> None:
    """Objects and protocol, two settings, cells, and where it came from."""
    lines = summary_lines(document())
    assert len(lines) == 5
    assert lines[0].startswith("mit-berkeley: 2 objects under 20 lights")
    assert lines[1] == (
        "natural: IMSE regression 0.01000 (0.0358 published), oracle 0.01000 (0.0329 published),"
        " B+M 0.01000 (0.0172 published)"
    )
    assert lines[3] == "160 cells done, 80 missing"
    assert summary_lines(left_out(document()))[3] == (
        "160 cells done, 80 missing; rows (b) and B+M left out by --quick"
    )
    assert lines[4] == "1.5 s, workers: 2, code 0123456789ab, data fedcba987654"


def test_title_says_what_is_missing() -> None:
    """The title of the printed table begins with INCOMPLETE and a count where cells are missing."""
    assert table1_title({"missing": []}) == TITLE
    cell = {"object": "sun", "reason": "not measured"}
    assert table1_title({"missing": [cell] * 2}) == f"INCOMPLETE, 2 cells missing. {TITLE}"
    assert table1_title({"missing": [cell], "quick": True}) == (
        f"QUICK, without SIRFS. INCOMPLETE, 1 cell missing. {TITLE}"
    )
