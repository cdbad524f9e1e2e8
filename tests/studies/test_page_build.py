"""The build of the studies' page: pinned, checked, the same each time, and clear when it fails."""

from __future__ import annotations

import json
import re
import stat
from pathlib import Path
from typing import Any

import pytest

from shading_model.errors import RelightlabError
from studies import page_build
from studies.page_build import BUNDLES, SOURCE, build_page, integrity, node_commands, page_folder


def read_json(name: str) -> dict[str, Any]:
    """Return one of npm's files."""
    content: dict[str, Any] = json.loads((SOURCE / name).read_text(encoding="utf-8"))
    return content


@pytest.fixture
def bundles(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bundles that need no registry."""
    made = {name: f"// {name}\n".encode() for name in BUNDLES}
    monkeypatch.setattr(page_build, "_fetch_bundles", lambda: made)


def failing_npm(folder: Path, errors: str) -> None:
    """Write an npm and a node into a folder, of which the first fails."""
    for name in ("node", "npm"):
        program = folder / name
        program.write_text(f"#!/bin/sh\necho '{errors}' >&2\nexit 1\n")
        program.chmod(program.stat().st_mode | stat.S_IXUSR)


def test_packages_are_pinned() -> None:
    """Every package has one version, and every one in the lock file a hash and no address."""
    asked = read_json("package.json")["dependencies"]
    assert asked["jspsych"] == "8.3.0"
    assert all(re.fullmatch(r"\d+\.\d+\.\d+", version) for version in asked.values())
    locked = read_json("package-lock.json")["packages"]
    assert locked[""]["dependencies"] == asked
    for name, package in locked.items():
        assert not name or package["integrity"].startswith("sha512-"), name
        assert "resolved" not in package
    assert "://" not in (SOURCE / "package-lock.json").read_text(encoding="utf-8")


def test_sources_name_no_other_host() -> None:
    """Nothing in the page's sources loads from elsewhere, and markup holds no script of its own."""
    markup = (SOURCE / "index.html").read_text(encoding="utf-8")
    assert not re.search(r"<script(?![^>]*\ssrc=)|<style|\son\w+=|\sstyle=", markup)
    for path in SOURCE.iterdir():
        if path.suffix in {".js", ".css", ".html"}:
            assert "://" not in path.read_text(encoding="utf-8"), path.name


@pytest.mark.usefixtures("bundles")
def test_same_bytes(tmp_path: Path) -> None:
    """Two builds are alike, and a page is replaced where only a source has changed."""
    first, second = build_page(tmp_path / "a"), build_page(tmp_path / "b")
    (second / "study.js").write_text("old")
    build_page(second)
    assert {p.name: p.read_bytes() for p in first.iterdir()} == {
        p.name: p.read_bytes() for p in second.iterdir()
    }


@pytest.mark.usefixtures("bundles")
def test_bundles_are_checked_by_the_browser(tmp_path: Path) -> None:
    """The page names the hash of every bundle it loads."""
    built = build_page(tmp_path)
    markup = (built / "index.html").read_text(encoding="utf-8")
    for name in BUNDLES:
        digest = integrity((built / name).read_bytes())
        assert f'src="static/{name}" integrity="{digest}"' in markup


@pytest.mark.usefixtures("bundles")
def test_bundles_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A second build asks no registry, until the lock file changes."""
    build_page(tmp_path)
    monkeypatch.setattr(page_build, "_fetch_bundles", lambda: pytest.fail("asked again"))
    build_page(tmp_path)
    (tmp_path / "package-lock.json").write_text("{}")
    with pytest.raises(pytest.fail.Exception, match="asked again"):
        build_page(tmp_path)


def test_registry_out_of_reach(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where npm fails, one sentence says why, without an address."""
    failing_npm(tmp_path, "npm error code ENOTFOUND\nnpm error request to https://x.example/y")
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    with pytest.raises(RelightlabError, match=r"packages of the studies' page \(ENOTFOUND\); try"):
        build_page(tmp_path / "built")
    assert not (tmp_path / "built" / "index.html").exists()


def test_no_node(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without any Node, one sentence says what to install."""
    monkeypatch.setattr(page_build, "node_commands", lambda: None)
    with pytest.raises(RelightlabError, match="expected Node with npm"):
        build_page(tmp_path)


def test_node_of_the_wheel(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a Node on the path, that of the wheel is taken."""
    monkeypatch.setattr(page_build.shutil, "which", lambda _: None)
    commands = node_commands()
    assert commands is not None
    assert [Path(part).name for part in commands[0]] == ["node", "npm-cli.js"]
    assert all(Path(part).is_file() for part in commands[0])


def test_page_not_built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever needs the page before it is built is told how to build it."""
    monkeypatch.setattr(page_build, "BUILT", tmp_path)
    with pytest.raises(RelightlabError, match="not built; run `make setup`"):
        page_folder()
