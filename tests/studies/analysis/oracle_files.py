"""Reads the numbers of R that are kept beside the tests."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import pandas as pd

FOLDER = Path(__file__).parent / "oracles"


@cache
def r_fits() -> dict[str, Any]:
    """What lme4, geepack and sandwich say of 24 made-up subjects, with the answers themselves."""
    return _read("r_fits.json")


def lme4_converged() -> dict[str, Any]:
    """What lme4 says of the published sets if its inner iterations are carried to the end."""
    return _read("lme4_converged.json")


def r_answers() -> pd.DataFrame:
    """The answers that the fits of `r_fits` are of."""
    return pd.DataFrame(r_fits()["data"])


def _read(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((FOLDER / name).read_text(encoding="utf-8"))
    return found
