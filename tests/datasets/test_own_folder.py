"""A dataset of one's own: what is read, and what is told of a folder that is wrong."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from datasets.openexr_files import write_openexr
from datasets.own_folder import OwnFolder
from datasets.own_folder_check import check_own_folder, require_measurable
from reports.command_line import run
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics
from tests.datasets.own_set import LIGHT, SIDE, sixteen_bit, write_object
from tests.example_objects import write_picture


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A set of one object with depth, albedo and two lit photographs."""
    write_object(tmp_path / "set" / "mug")
    return tmp_path / "set"


def test_a_set_yields_the_records(own: Path) -> None:
    """Photograph, truth and lit photographs, in the conventions of every other set."""
    dataset = OwnFolder(own)
    assert (dataset.name, dataset.objects, dataset.settings) == (
        "own:set",
        ("mug",),
        ("photograph",),
    )
    capture = dataset.load("mug", "photograph")
    mask, truth = capture.photograph.mask, capture.truth
    assert capture.photograph.image.shape == (SIDE, SIDE, 3)
    assert len(np.unique(capture.photograph.image)) > 256
    for known in (truth.height, truth.normals, truth.albedo, truth.shading):
        assert known is not None
        assert np.isfinite(known[mask]).any()
        assert np.isnan(known[~mask]).all()
    assert truth.albedo is not None
    assert truth.shading is not None
    product = (truth.albedo * truth.shading)[mask]
    assert np.allclose(product, capture.photograph.image[mask])
    lit = dataset.lit_photographs("mug")
    assert [photo.photograph.source for photo in lit] == ["mug/lit_01.png", "mug/lit_02.png"]
    assert np.allclose(lit[1].illumination.coefficients, LIGHT.coefficients)


def test_the_fingerprint_follows_the_content(own: Path) -> None:
    """Another byte, another fingerprint."""
    before = OwnFolder(own).fingerprint()
    np.save(own / "mug" / "depth.npy", np.zeros((SIDE, SIDE)))
    assert OwnFolder(own).fingerprint() != before


def test_other_formats_hold_the_same(own: Path) -> None:
    """Depth as 16-bit levels with a scale, albedo as OpenEXR or array, give the same numbers."""
    folder = own / "mug"
    first = OwnFolder(own).load("mug").truth
    height = np.load(folder / "depth.npy")
    (folder / "depth.npy").unlink()
    write_picture(folder / "depth.png", np.round(height * 1000).astype(np.uint16))
    (folder / "depth.json").write_text('{"scale": 0.001}', encoding="utf-8")
    assert first.height is not None
    assert first.albedo is not None
    write_openexr(folder / "albedo.exr", np.nan_to_num(first.albedo))
    (folder / "albedo.png").unlink()
    second = OwnFolder(own).load("mug").truth
    assert second.height is not None
    assert np.allclose(second.height, first.height, atol=1e-3, equal_nan=True)
    assert second.albedo is not None
    assert np.allclose(second.albedo, first.albedo, atol=1e-6, equal_nan=True)


def test_linear_coefficients_are_converted(own: Path) -> None:
    """A constant light of two is the logarithm of two, in the first coefficient."""
    constant = [2.0 / 0.886227, *[0.0] * 8]
    document = {"convention": "linear", "lights": {"lit_01": constant, "lit_02": constant}}
    (own / "mug" / "lights.json").write_text(json.dumps(document), encoding="utf-8")
    light = OwnFolder(own).lit_photographs("mug")[0].illumination
    assert np.allclose(light.shade(np.array([[[0.0, 0.6, 0.8]]])), 2.0, atol=1e-4)


def _lights(text: str) -> Callable[[Path], None]:
    return lambda mug: (mug / "lights.json").write_text(text, encoding="utf-8") and None


def _remove(*names: str) -> Callable[[Path], None]:
    def change(mug: Path) -> None:
        for name in names:
            (mug / name).unlink()

    return change


def _small_mask(mug: Path) -> None:
    write_picture(mug / "mask.png", np.full((9, 9), 255, np.uint8))


def _small_depth(mug: Path) -> None:
    np.save(mug / "depth.npy", np.zeros((3, 3)))


def _unknown_depth(mug: Path) -> None:
    np.save(mug / "depth.npy", np.full((SIDE, SIDE), np.nan))


def _no_scale(mug: Path) -> None:
    (mug / "depth.npy").unlink()
    write_picture(mug / "depth.png", np.ones((SIDE, SIDE), np.uint16))


def _zero_scale(mug: Path) -> None:
    _no_scale(mug)
    (mug / "depth.json").write_text('{"scale": 0}', encoding="utf-8")


def _broken_array(mug: Path) -> None:
    (mug / "depth.npy").write_bytes(b"no array")


def _nan_albedo(mug: Path) -> None:
    (mug / "albedo.png").unlink()
    np.save(mug / "albedo.npy", np.full((SIDE, SIDE), np.nan))


def _saturated_probe(mug: Path) -> None:
    write_picture(mug / "probe_01.png", sixteen_bit(np.ones((8, 8, 3))))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_remove("mask.png"), "no such file"),
        (_remove("photograph.png"), "lacks photograph.png, .jpg or .exr"),
        (_small_mask, "its mask is 9x9"),
        (_small_depth, "depth.npy is of shape (3, 3), expected (40, 40)"),
        (_unknown_depth, "the depth is known nowhere on the mask"),
        (_no_scale, "depth.png needs"),
        (_zero_scale, "expected a scale above zero"),
        (_broken_array, "expected an array of numbers"),
        (_nan_albedo, "negative or not finite somewhere on the mask"),
        (_lights("{"), "cannot read"),
        (_lights('{"convention": "logg", "lights": {}}'), "Did you mean 'log'?"),
        (_lights('{"convention": "log", "lights": {"lit_01": [1]}}'), "of shape (9,)"),
        (_lights('{"convention": "log", "lights": {}}'), "lacks the lights of lit_01, lit_02"),
        (_saturated_probe, "the light probe is saturated"),
    ],
)
def test_every_fault_is_one_line(
    own: Path, change: Callable[[Path], None], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """`data verify` tells it with the object's name, ends with 2, and measuring is refused."""
    change(own / "mug")
    assert run(["data", "verify", str(own)]) == 2
    told = capsys.readouterr()
    lines = [line for line in told.out.splitlines() if "WRONG" in line]
    assert any(line.startswith("mug: WRONG: ") and words in line for line in lines)
    assert "cannot be used as it is" in told.err
    with pytest.raises(RelightlabError, match=r"^mug: "):
        require_measurable(OwnFolder(own))


def test_a_good_set_is_listed(
    own: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line for each object, exit code 0, and the same as JSON."""
    assert run(["data", "verify", str(own), "--json", str(tmp_path / "v.json")]) == 0
    out = capsys.readouterr().out
    assert "mug: photograph 40x40, depth, albedo, 2 lit photographs" in out
    assert "1 objects, 0 faults, 1 with depth and albedo" in out
    assert json.loads((tmp_path / "v.json").read_text())["lacking"] == {}


def test_what_is_optional_may_lack(own: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without depth and albedo the set is whole, but re-rendering says what it needs."""
    for name in ("depth.npy", "albedo.png"):
        (own / "mug" / name).unlink()
    assert run(["data", "verify", str(own)]) == 0
    assert "mug: no re-rendering without depth and albedo" in capsys.readouterr().out
    assert check_own_folder(OwnFolder(own)).usable
    assert run(["evaluate", "rerendering", "--dataset", str(own)]) == 2
    assert "mug lacks depth (depth.npy or depth.png) and albedo" in capsys.readouterr().err


def test_rerendering_is_measured_on_a_set_of_ones_own(
    own: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every entry of the one setting has a value."""
    write_object(own / "pot", lit=0)
    target = tmp_path / "rows.json"
    command = ["evaluate", "rerendering", "--dataset", str(own), "--workers", "1"]
    assert run([*command, "--quick", "--json", str(target)]) == 0
    rows = json.loads(target.read_text())["rows"]
    assert {row["setting"] for row in rows} == {"photograph"}
    assert {row["dataset"] for row in rows} == {"own:set"}
    assert all(0 < row["imse"] < 1 for row in rows)
    assert "2 objects of your own" in capsys.readouterr().out


def test_unknown_names_and_empty_folders_are_told(own: Path, tmp_path: Path) -> None:
    """An object, a setting, a folder without objects and one that is not there."""
    with pytest.raises(RelightlabError, match=r"Unknown object 'mog'\. Did you mean 'mug'"):
        OwnFolder(own).load("mog")
    with pytest.raises(RelightlabError, match="Unknown setting 'natural'"):
        OwnFolder(own).load("mug", "natural")
    (tmp_path / "empty").mkdir()
    with pytest.raises(RelightlabError, match="is no dataset: expected folders that hold"):
        OwnFolder(tmp_path / "empty")
    with pytest.raises(RelightlabError, match="no such folder"):
        OwnFolder(tmp_path / "absent")


def test_a_probe_stands_in_for_coefficients(own: Path) -> None:
    """A lit photograph whose light is not listed takes that of the sphere beside it."""
    mug = own / "mug"
    dimmed = OwnFolder(own).lit_photographs("mug")[0].illumination.coefficients - 2 * np.eye(9)[0]
    rows, columns = (np.mgrid[:64, :64] - 31.5) / 32
    upright = np.sqrt(np.maximum(1 - rows**2 - columns**2, 0))
    normals = np.stack([columns, -rows, upright], axis=-1)
    shading = LogHarmonics(dimmed).shade(normals)
    write_picture(mug / "probe_01.png", sixteen_bit(np.repeat(shading[..., None], 3, axis=-1)))
    document = json.loads((mug / "lights.json").read_text(encoding="utf-8"))
    del document["lights"]["lit_01"]
    (mug / "lights.json").write_text(json.dumps(document), encoding="utf-8")
    fitted, other = OwnFolder(own).lit_photographs("mug")
    assert fitted.illumination.coefficients.shape == (9, 3)
    assert other.illumination.coefficients.shape == (9,)
    inside = np.hypot(rows, columns) < 0.9
    assert np.allclose(fitted.illumination.shade(normals)[inside][:, 0], shading[inside], rtol=0.01)
