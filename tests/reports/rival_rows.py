"""Rows of SIRFS that no fit stands behind, put beside measured ones for tests of the report."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

SHADING_SHARE = 0.9
"""The error with the fake shading of SIRFS, over that with Retinex."""
RIVAL_SHARES = {"natural": 0.3, "laboratory": 0.8}
"""The error of the fake SIRFS, over that of our default model with regressed weights."""
HELD_OUT_SHARE = 1.1
"""The error over the test objects, over that over all."""
ERRORS = {
    "natural": (9.5, 0.31, 0.0021, 0.0034, 0.011, 0.0042),
    "laboratory": (12.0, 0.42, 0.0055, 0.0141, 0.035, 0.0123),
}
"""Errors of the fake fits in each setting, in the order of `NAMES`."""
NAMES = ("z_mae", "n_mae", "s_mse", "r_mse", "rs_mse", "l_mse")


def with_rival(document: dict[str, Any]) -> dict[str, Any]:
    """Return a document with rows (b) and B+M, overall and by object, and errors of fits."""
    found = copy.deepcopy(document) | {"open": [], "quick": False}
    for part in ("rows", "objects"):
        own = [row for row in found[part] if row["detail_source"] == "default"]
        found[part] += [_scaled(row, SHADING_SHARE, "sirfs-shading") for row in own]
        found[part] += [
            _scaled(row, RIVAL_SHARES[row["setting"]], "default")
            | {"method": "sirfs", "weights": "none"}
            for row in own
            if row["weights"] == "regression"
        ]
    found["test_rows"] = [
        _scaled(row, HELD_OUT_SHARE, row["detail_source"]) for row in found["rows"]
    ]
    found["sirfs_rows"] = [
        fit_row(row["object"], row["setting"], 1 + number / 10)
        for number, row in enumerate(found["intrinsic"])
    ]
    found["sirfs_summary"] = [
        fit_row("all", setting) | {"objects": len({row["object"] for row in found["objects"]})}
        for setting in RIVAL_SHARES
    ]
    return found


def fit_row(name: str, setting: str, factor: float = 1.0) -> dict[str, Any]:
    """Return the errors of a fake fit, each times a factor."""
    errors = {key: factor * value for key, value in zip(NAMES, ERRORS[setting], strict=True)}
    rest = {"mean": 0.03 * factor, "final_loss": 25.0, "evaluations": 320.5, "seconds": 11.5}
    return {"object": name, "setting": setting, "channels": "color", **errors, **rest}


def left_out(
    document: dict[str, Any], settings: Sequence[str] = ("natural", "laboratory")
) -> dict[str, Any]:
    """Return a document as a quick run makes it: without SIRFS in settings, its entries open."""
    entries = [
        {"setting": setting, "method": method, "detail_source": source}
        for setting in settings
        for method, source in (("sirfs", "default"), ("ours", "sirfs-shading"))
    ]
    kept = {
        part: [row for row in document[part] if not _is_left_out(row, settings)]
        for part in ("rows", "objects", "test_rows", "sirfs_rows", "sirfs_summary")
        if part in document
    }
    return document | kept | {"open": entries, "quick": True}


def _is_left_out(row: dict[str, Any], settings: Sequence[str]) -> bool:
    of_rival = row.get("detail_source") == "sirfs-shading" or row.get("weights", "none") == "none"
    return of_rival and row.get("setting") in settings


def _scaled(row: dict[str, Any], share: float, source: str) -> dict[str, Any]:
    errors = {
        key: None if row[key] is None else share * row[key] for key in ("imse", "relative_imse")
    }
    return row | errors | {"detail_source": source}
