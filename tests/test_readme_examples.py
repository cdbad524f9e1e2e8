"""The examples of the README and of docs/, run as they are printed."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from datasets.synthetic import synthesize
from reports.command_line import run
from tests.repository import ROOT

PROGRAM = "relightlab"


@pytest.fixture(scope="module")
def two_objects(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A synthetic set of two small objects."""
    folder = tmp_path_factory.mktemp("set")
    synthesize(folder, size=40, samples=1, objects=["apple", "pear"], workers=1)
    return folder


def block(document: str, word: str) -> str:
    """Return the one fenced block of a document that holds a word."""
    text = (ROOT / document).read_text(encoding="utf-8")
    (found,) = [b for b in re.findall(r"```\w*\n(.*?)```", text, re.DOTALL) if word in b]
    return str(found)


def command(document: str, word: str) -> list[str]:
    """Return the words of the one command line of a document that holds a word."""
    (line,) = [line for line in block(document, word).splitlines() if word in line]
    program, *words = shlex.split(line)
    assert Path(program).name == PROGRAM
    return words


def measured(words: list[str], *options: str) -> dict[str, dict[str, float]]:
    """Run a command and return the rows of Table 1 by method and setting."""
    assert run([*words, "--quick", "--workers", "1", "--json", "rows.json", *options]) == 0
    rows = json.loads(Path("rows.json").read_text(encoding="utf-8"))["rows"]
    found: dict[str, dict[str, float]] = {}
    for row in rows:
        found.setdefault(row["method"], {})[row["setting"]] = row["imse"]
    return found


def test_the_method_of_the_readme_has_its_row(
    two_objects: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ten lines in a file of the current folder, found, tried and measured."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    Path("dome.py").write_text(block("README.md", "class Dome"), encoding="utf-8")
    rows = measured(command("README.md", "--method dome:Dome"), "--data", str(two_objects))
    assert set(rows) == {"ours", "dome:Dome"}
    assert set(rows["dome:Dome"]) == {"natural", "laboratory"}
    assert all(0 < imse < 0.1 for imse in rows["dome:Dome"].values())


def test_the_dataset_of_the_readme_is_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The script writes a set that is verified without a fault, and measured."""
    monkeypatch.chdir(tmp_path)
    script = block("README.md", "my-set/mug")
    subprocess.run([sys.executable, "-c", script], check=True)
    assert run(command("README.md", "data verify my-set")) == 0
    assert "mug: photograph 61x61, depth, albedo" in capsys.readouterr().out
    rows = measured(command("README.md", "--dataset my-set"))
    assert set(rows["ours"]) == {"photograph"}


def test_the_command_of_the_documentation_has_its_row(
    two_objects: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A script in another process, from a folder of inputs to one of images."""
    monkeypatch.chdir(tmp_path)
    script = block("docs/own-method.md", "import json")
    Path("relight.py").write_text(script, encoding="utf-8")
    words = command("docs/own-method.md", "--method-command")
    python = [word.replace("python ", f"{shlex.quote(sys.executable)} ") for word in words]
    rows = measured(python, "--data", str(two_objects))
    (own,) = set(rows) - {"ours"}
    assert own.endswith("relight.py")
    assert all(0 < imse < 0.1 for imse in rows[own].values())


def test_the_lights_of_the_documentation_are_read(tmp_path: Path) -> None:
    """The lights.json that is printed is one that can be used."""
    from datasets.own_folder import ObjectFiles

    text = block("docs/own-dataset.md", '"convention"')
    (tmp_path / "lights.json").write_text(text, encoding="utf-8")
    assert list(ObjectFiles(tmp_path).lights()) == ["lit_01"]


def test_the_fit_of_the_documentation_runs(
    two_objects: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A photograph and its mask beside the script are fitted; the loss is the sum of its terms."""
    from datasets.synthetic import Synthetic

    seen = Synthetic(two_objects).load("pear", "natural").photograph
    monkeypatch.chdir(tmp_path)
    cv2.imwrite("photo.jpg", np.rint(255 * seen.image[..., ::-1] ** (1 / 2.2)).astype(np.uint8))
    cv2.imwrite("mask.png", np.uint8(255) * seen.mask)
    found: dict[str, Any] = {}
    exec(block("docs/sirfs.md", "fit_sirfs("), found)  # noqa: S102  our own documentation
    fit = found["fit"]
    assert fit.final_loss == pytest.approx(sum(fit.terms.values()))
    assert np.isfinite(fit.height[fit.mask]).all()


@pytest.mark.slow
def test_the_study_of_the_readme_is_designed_and_analysed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All but the serving, which has tests of its own; simulated subjects answer in its place."""
    monkeypatch.chdir(tmp_path)
    words = ("study example", "study design", "study power", "study analyze")
    example, design, power, analyze = (command("README.md", word) for word in words)
    assert run(example) == 0
    assert run(design) == 0
    assert run([*power, "--draws", "50"]) == 0
    database, study = analyze[2], design[-1]
    assert run(["study", "simulate", study, "--subjects", "60", "--database", database]) == 0
    assert run(analyze) == 0
    assert "SIMULATED" in Path("results/report/index.html").read_text(encoding="utf-8")
