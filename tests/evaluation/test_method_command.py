"""Methods in another environment: the folder they get, and every way they can fail."""

from __future__ import annotations

import json
import shlex
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from datasets.image_files import read_linear_png
from datasets.model_parameters import shipped_parameters
from datasets.synthetic import Synthetic
from evaluation.method_command import CommandMethod, write_inputs
from evaluation.own_rows import own_choices, run_own_rows
from shading_model.arrays import Image, Mask
from shading_model.errors import RelightlabError
from tests.evaluation.conftest import LIGHTS, OBJECTS
from tests.example_objects import disk, painted

HEADER = """
import json, sys, numpy as np
inputs, outputs = sys.argv[1:]
image = np.load(inputs + "/photograph.npy")
lights = json.load(open(inputs + "/lights.json"))["lights"]
"""
GOOD = """
for name, coefficients in lights.items():
    np.save(f"{outputs}/light_{name}.npy", image * np.exp(coefficients[0]))
"""
NAMED = {f"{number:02d}": light for number, light in enumerate(LIGHTS)}


def command(folder: Path, body: str, seconds: float = 60.0) -> CommandMethod:
    """Return a method whose command is a script with this body."""
    script = folder / "script.py"
    script.write_text(HEADER + body, encoding="utf-8")
    words = [sys.executable, str(script)]
    return CommandMethod(f"{shlex.join(words)} {{inputs}} {{outputs}}", seconds)


def photograph() -> tuple[Image, Mask]:
    """Return a small photograph and its mask."""
    return painted(disk(24)), disk(24)


def test_images_come_back_as_they_were_written(tmp_path: Path) -> None:
    """One for each light, from arrays."""
    image, mask = photograph()
    relit = command(tmp_path, GOOD).relit(image, mask, NAMED)
    assert list(relit) == list(NAMED)
    for name, light in NAMED.items():
        assert np.allclose(relit[name], image * np.exp(light.coefficients[0]))


def test_sixteen_bit_pictures_come_back(tmp_path: Path) -> None:
    """A PNG of 16 bits is linear and keeps its bits."""
    body = """
import cv2
for name in lights:
    levels = np.round(65535 * image).astype(np.uint16)
    cv2.imwrite(f"{outputs}/light_{name}.png", levels[..., ::-1])
"""
    image, mask = photograph()
    relit = command(tmp_path, body).relit(image, mask, NAMED)
    assert np.abs(relit["00"] - image).max() < 1 / 65535


def test_the_inputs_are_as_documented(tmp_path: Path) -> None:
    """Photograph in two formats, mask, coefficients, and a sphere that each light shades."""
    image, mask = photograph()
    write_inputs(tmp_path, image, mask, NAMED)
    assert np.array_equal(np.load(tmp_path / "photograph.npy"), image)
    assert np.abs(read_linear_png(tmp_path / "photograph.png") - image).max() <= 0.5 / 65535
    stored = cv2.imread(str(tmp_path / "mask.png"), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(stored == 255, mask)
    document = json.loads((tmp_path / "lights.json").read_text())
    assert document["convention"] == "log"
    assert list(document["lights"]) == list(NAMED)
    for name, light in NAMED.items():
        assert document["lights"][name] == light.coefficients.tolist()
        sphere = np.load(tmp_path / f"sphere_{name}.npy")
        facing = light.shade(np.array([[[0.0, 0.0, 1.0]]]))[0, 0]
        assert np.isclose(sphere[64, 64, 0], facing, rtol=0.02)
        scaled = read_linear_png(tmp_path / f"sphere_{name}.png")
        assert np.allclose(scaled, document["sphere_png_exposure"] * sphere, atol=1e-5)


@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        ("sys.exit('out of memory')", "ended with exit code 1; it said last: out of memory"),
        ("", "left no light_00.npy, .png or .exr"),
        ("sys.stderr.write('no GPU')", "left no light_00.npy, .png or .exr; it said last: no GPU"),
        (GOOD.replace("image *", "image[:5] *"), "light_00.npy is of shape (5, 24, 3), expected"),
        (GOOD.replace("image *", "np.nan *image *"), "light_00.npy has 284 pixels that are not"),
        ("open(outputs + '/light_00.npy', 'w').write('x')", "cannot use the command's image"),
        (
            "import cv2; cv2.imwrite(outputs + '/light_00.png', np.uint8(image))",
            "expected a 16-bit PNG, got 8-bit: light_00.png",
        ),
    ],
)
def test_every_fault_is_one_sentence(tmp_path: Path, body: str, sentence: str) -> None:
    """Exit code, missing file, wrong size, NaN, damaged file: told with what was said last."""
    with pytest.raises(RelightlabError) as error:
        command(tmp_path, body).relit(*photograph(), NAMED)
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)


def test_a_command_that_hangs_is_stopped_with_its_children(tmp_path: Path) -> None:
    """After its time, the command and what it started are gone."""
    body = """
import subprocess, time
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
open(sys.argv[0] + ".pid", "w").write(str(child.pid))
sys.stderr.write("loading")
sys.stderr.flush()
time.sleep(60)
"""
    started = time.monotonic()
    with pytest.raises(RelightlabError, match=r"took longer than 2 s; it said last: loading"):
        command(tmp_path, body, seconds=2).relit(*photograph(), NAMED)
    assert time.monotonic() - started < 20
    child = Path("/proc") / (tmp_path / "script.py.pid").read_text() / "stat"
    # Killed: gone, or a zombie that nobody has waited for yet.
    assert not child.exists() or child.read_text().rsplit(")", 1)[1].split()[0] == "Z"


def test_a_failing_command_fails_its_rows_and_the_run_goes_on(
    tiny_set: Synthetic, tmp_path: Path
) -> None:
    """Its cells are missing with the sentence; the method beside it has its numbers."""
    good = command(tmp_path, GOOD)
    (tmp_path / "bad").mkdir()
    bad = CommandMethod("no-such-program-here {inputs} {outputs}")
    own = run_own_rows(own_choices(commands=[bad, good]), tiny_set, LIGHTS, shipped_parameters())
    cells = {row["method"]: row["cells"] for row in own.rows()}
    assert cells == {bad.name: 0, good.name: len(OBJECTS) * len(LIGHTS)}
    reasons = {missing.reason for missing in own.missing_entries()}
    assert reasons == {"cannot run 'no-such-program-here': No such file or directory"}


def test_identity_follows_the_files_the_command_names(tmp_path: Path) -> None:
    """A changed script is another method; the same one is not."""
    method = command(tmp_path, GOOD)
    before = method.identity
    assert command(tmp_path, GOOD).identity == before
    assert command(tmp_path, GOOD + "# changed").identity != before
    assert method.name.endswith("script.py")


@pytest.mark.parametrize(
    ("words", "seconds", "sentence"),
    [
        ("relight {inputs}", 1.0, "expected {inputs} and {outputs} in the method command"),
        ("relight '{inputs} {outputs}", 1.0, "cannot read the command"),
        ("{inputs} {outputs}", 1.0, "expected a program to run first"),
        ("relight {inputs} {outputs}", 0.0, "expected a time limit above zero, got 0"),
    ],
)
def test_commands_that_cannot_be_run_are_refused(words: str, seconds: float, sentence: str) -> None:
    """Before anything is measured."""
    with pytest.raises(RelightlabError) as error:
        CommandMethod(words, seconds)
    assert sentence in str(error.value)
