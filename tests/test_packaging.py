"""Packaging: pins, the environment they make, and what a wheel contains."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from functools import cache
from importlib.metadata import packages_distributions, version
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.repository import PACKAGES, ROOT, committed_files, imports_of, parsed

HASH = re.compile(r"--hash=sha256:[0-9a-f]{64}(?![0-9a-f])")


@cache
def project() -> dict[str, Any]:
    """Return pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


@cache
def pins() -> tuple[tuple[Requirement, int], ...]:
    """Return each pin of constraints.txt, with its number of hashes."""
    text = (ROOT / "constraints.txt").read_text(encoding="utf-8").replace("\\\n", " ")
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    return tuple((Requirement(line.split("--hash")[0]), len(HASH.findall(line))) for line in lines)


def pinned_on(python: str) -> dict[str, str]:
    """Return the pinned version of each distribution on Linux with the given Python."""
    machine = {"python_version": python, "python_full_version": f"{python}.0"}
    machine |= {"sys_platform": "linux", "os_name": "posix", "platform_system": "Linux"}
    return {
        canonicalize_name(pin.name): str(pin.specifier).removeprefix("==")
        for pin, _ in pins()
        if pin.marker is None or pin.marker.evaluate(machine)
    }


def declared() -> set[str]:
    """Return every distribution that pyproject.toml asks for."""
    table = project()["project"]
    groups = [table["dependencies"], *table["optional-dependencies"].values()]
    groups.append(project()["build-system"]["requires"])
    return {canonicalize_name(Requirement(text).name) for group in groups for text in group}


def test_pins_are_exact_and_hashed() -> None:
    """Every pin names one version and at least one hash of its files."""
    loose = [str(pin) for pin, hashes in pins() if not hashes or "==" not in str(pin.specifier)]
    assert len(pins()) > 50
    assert loose == []


def test_pins_hold_no_address() -> None:
    """The pins say what to install and leave where from to the user's own configuration."""
    text = (ROOT / "constraints.txt").read_text(encoding="utf-8")
    assert not re.search(r"://|--(extra-)?index|--find-links|--trusted| @ ", text)


@pytest.mark.parametrize("python", ["3.11", "3.12", "3.13"])
def test_every_dependency_is_pinned(python: str) -> None:
    """Every dependency, development tool and build requirement has a pin on each Python."""
    assert declared() - set(pinned_on(python)) == set()


def test_results_do_not_depend_on_the_python() -> None:
    """A package has one version on all supported Pythons, so that they give the same numbers."""
    oldest, *newer = (pinned_on(python) for python in ("3.11", "3.12", "3.13"))
    for pins in newer:
        # An older Python may need backports besides.
        assert pins.items() <= oldest.items()


def test_installed_dependencies_are_the_pinned_ones() -> None:
    """The environment these tests run in has the pinned versions: `make setup` makes it so."""
    expected = pinned_on(f"{sys.version_info.major}.{sys.version_info.minor}")
    wrong = {
        name: f"{version(name)} installed, {expected[name]} pinned"
        for name in declared()
        if version(name) != expected[name]
    }
    assert wrong == {}


def test_imported_libraries_are_declared() -> None:
    """Every library that a package imports is asked for in pyproject.toml, under its own name."""
    imported = {
        name.split(".")[0] for _, tree in parsed(*PACKAGES) for name in imports_of(tree)
    } - {*PACKAGES, *sys.stdlib_module_names}
    providers = packages_distributions()
    undeclared = {
        name
        for name in imported
        # A library that is a single compiled module is listed under no distribution.
        if not declared() & {canonicalize_name(found) for found in [*providers.get(name, []), name]}
    }
    assert undeclared == set()


@pytest.mark.parametrize("package", [*PACKAGES, "tests"])
def test_no_dependency_takes_a_name(package: str) -> None:
    """No installed distribution but this one provides a package under one of its names."""
    assert set(packages_distributions().get(package, [])) <= {"relightlab"}


def test_changelog_has_the_version() -> None:
    """The first version of the changelog is that of pyproject.toml and of the citation."""
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    current = project()["project"]["version"]
    assert re.findall(r"^## \[(.+?)\]", changelog, re.MULTILINE)[0] == current
    assert re.findall(r"^version: (\S+)$", citation, re.MULTILINE) == [current]


@pytest.mark.slow
def test_wheel_contains_what_is_committed(tmp_path: Path) -> None:
    """A wheel holds every committed file of the packages, their data included, and no other."""
    source = tmp_path / "source"
    for path in committed_files():
        copy = source / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, copy)
    build = "wheel --quiet --disable-pip-version-check --no-deps --no-build-isolation --no-index"
    subprocess.run(
        [sys.executable, "-m", "pip", *build.split(), "--wheel-dir", str(tmp_path), str(source)],
        check=True,
    )
    (wheel,) = tmp_path.glob("relightlab-*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    shipped = {name for name in names if ".dist-info/" not in name}
    committed = {path.relative_to(ROOT) for path in committed_files()}
    assert shipped == {path.as_posix() for path in committed if path.parts[0] in PACKAGES}
