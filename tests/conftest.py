"""What all tests share: one thread, no window, repeatable examples, and the measured data."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# Before anything imports NumPy or Matplotlib, which read these once.
for _library in ("OPENBLAS", "OMP", "MKL", "NUMBA"):
    os.environ[f"{_library}_NUM_THREADS"] = "1"
os.environ["MPLBACKEND"] = "Agg"

# The same examples on every machine; a busy machine is slow, not wrong.
settings.register_profile(
    "repeatable", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("repeatable")

LACKING = {
    "real_data": "lack of data (set RELIGHTLAB_DATA to a folder that holds mit-berkeley/)",
    "browser": "lack of a Chromium",
    "postgresql": "lack of a PostgreSQL server (initdb and pg_ctl)",
    "nightly": "their length (ask for them with -m nightly)",
}


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Skip what runs long on purpose, unless it was asked for."""
    if "nightly" in str(config.getoption("markexpr")):
        return
    for item in items:
        if "nightly" in item.keywords:
            item.add_marker(pytest.mark.skip(reason="runs long: ask for it with -m nightly"))


@pytest.fixture(scope="session")
def data_root() -> Path:
    """The folder that holds the measured sets; skips where there is none."""
    from datasets.locations import find_data_root, missing_data_sentence

    root = find_data_root()
    if root is None:
        pytest.skip(missing_data_sentence("mit-berkeley"))
    return root


@pytest.fixture(scope="session")
def mit_berkeley_root(data_root: Path) -> Path:
    """The folder of the MIT-Berkeley set; skips where the data root has others only."""
    root = data_root / "mit-berkeley"
    if not root.is_dir():
        pytest.skip(f"{data_root} holds no mit-berkeley/")
    return root


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Count, last of all, the tests that could not run here."""
    skipped = terminalreporter.stats.get("skipped", [])
    terminalreporter.section("not run here")
    for marker, reason in LACKING.items():
        count = sum(marker in report.keywords for report in skipped)
        terminalreporter.write_line(f"tests skipped for {reason}: {count}")
