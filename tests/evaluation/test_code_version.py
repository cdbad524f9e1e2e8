"""The version of the code that numbers depend on."""

from __future__ import annotations

from pathlib import Path

import pytest

from evaluation import code_version


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout of two modules, one in a folder of a folder."""
    for name in ("evaluation/code_version.py", "evaluation/rival/fit.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("", encoding="utf-8")
    monkeypatch.setattr(code_version, "__file__", str(tmp_path / "evaluation" / "code_version.py"))
    return tmp_path


@pytest.mark.parametrize("name", ["code_version.py", "rival/fit.py", "rival/another.py"])
def test_every_module_counts(checkout: Path, name: str) -> None:
    """A module that changes or is added anywhere below a folder is another version."""
    version = code_version.code_hash.__wrapped__
    before = version(("evaluation",))
    assert version(("evaluation",)) == before
    (checkout / "evaluation" / name).write_text("changed", encoding="utf-8")
    assert version(("evaluation",)) != before


def test_what_is_no_code_does_not_count(checkout: Path) -> None:
    """Compiled modules and data beside them leave the version as it is."""
    version = code_version.code_hash.__wrapped__
    before = version(("evaluation",))
    (checkout / "evaluation" / "rival" / "__pycache__").mkdir()
    (checkout / "evaluation" / "rival" / "__pycache__" / "fit.cpython-311.pyc").touch()
    (checkout / "evaluation" / "record.json").touch()
    assert version(("evaluation",)) == before
