"""What tests of studies share."""

from __future__ import annotations

from pathlib import Path

import pytest

from studies.example_study import write_example
from studies.study_file import Study, load_study


@pytest.fixture(scope="session")
def example_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write the example study once and return its file; tests leave it as it is."""
    return write_example(tmp_path_factory.mktemp("example"))


@pytest.fixture(scope="session")
def example_study(example_file: Path) -> Study:
    """Return the example study."""
    return load_study(example_file)
