"""Fits of a dataset's photographs: what they are made of, and that each is made once."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from datasets.records import Capture, Photograph
from datasets.synthetic import Synthetic
from evaluation.blob_store import blob_fault, blob_files
from evaluation.sirfs.fit import FitOptions
from evaluation.sirfs.result import SirfsFit
from evaluation.sirfs_fits import (
    FITTING_CODE,
    SirfsFits,
    fit_key,
    light_model,
    object_outline,
)
from shading_model.arrays import Image, Mask
from shading_model.errors import RelightlabError
from tests.evaluation.sirfs.fake_fits import diverging_fit, flat_fit, pretend
from tests.evaluation.sirfs.test_fit_files import same
from tests.example_objects import disk, painted
from tests.repository import ROOT, imports_of, parsed

UNINVOLVED = {f"{name}.py" for name in ("shading_model/errors", "shading_model/arrays")} | {
    "datasets/array_archive.py"
}
"""They check, tell and keep, and change no number."""


class Recorder:
    """A fake fit that remembers what it was asked for."""

    def __init__(self) -> None:
        self.calls: list[dict[str, Any]] = []

    def __call__(
        self, image: Image, mask: Mask, priors: Any, options: FitOptions, *, outline: Mask
    ) -> SirfsFit:
        """Remember, and fit."""
        self.calls.append({"mask": mask, "options": options, "outline": outline})
        return flat_fit(image, mask, priors, options)


@pytest.fixture
def recorder(monkeypatch: pytest.MonkeyPatch) -> Recorder:
    """In place of SIRFS."""
    found = Recorder()
    pretend(monkeypatch, found)
    return found


@dataclasses.dataclass(frozen=True)
class TwoMasks:
    """A set of one disk whose natural photograph is known on a smaller part."""

    whole: Mask
    settings: tuple[str, ...] = ("natural", "laboratory")
    name: str = "two masks"
    objects: tuple[str, ...] = ("disk",)

    def load(self, name: str, setting: str) -> Capture:
        """The photograph of a setting."""
        mask = disk(40, 12) if setting == "natural" else self.whole
        photograph = Photograph(painted(mask), mask, name, setting)
        return Capture(photograph, None, setting)  # type: ignore[arg-type]


def test_a_fit_is_made_once(recorder: Recorder, tiny_set: Synthetic, tmp_path: Path) -> None:
    """A second time it is read, to the last bit; without a folder it is made again."""
    kept, unkept = SirfsFits(tmp_path), SirfsFits()
    first = kept.fit(tiny_set, "cup", "natural")
    assert same(kept.fit(tiny_set, "cup", "natural"), first)
    assert len(recorder.calls) == len(list(blob_files(tmp_path))) == 1
    assert same(unkept.fit(tiny_set, "cup", "natural"), first)
    assert same(unkept.fit(tiny_set, "cup", "natural"), first)
    assert len(recorder.calls) == 3


def test_a_deleted_and_a_damaged_fit_are_made_again(
    recorder: Recorder, tiny_set: Synthetic, tmp_path: Path
) -> None:
    """What a store lost is made again, and is good then."""
    fits = SirfsFits(tmp_path)
    first = fits.fit(tiny_set, "cup", "natural")
    (blob,) = blob_files(tmp_path)
    content = blob.read_bytes()
    for damage in (b"", content[:-40], None):
        blob.unlink() if damage is None else blob.write_bytes(damage)
        assert same(fits.fit(tiny_set, "cup", "natural"), first)
        assert blob_fault(blob) is None
        assert blob.read_bytes() == content
    assert len(recorder.calls) == 4


def test_what_a_fit_is_asked_for(recorder: Recorder, tiny_set: Synthetic) -> None:
    """The light model is the setting's, channels and terms left out are those asked for."""
    SirfsFits(without=("slant",)).fit(tiny_set, "cup", "natural", "gray")
    SirfsFits().fit(tiny_set, "cup", "laboratory")
    options = [call["options"] for call in recorder.calls]
    assert [one.light for one in options] == ["natural", "laboratory"]
    assert [one.channels for one in options] == ["gray", "color"]
    assert [one.without for one in options] == [("slant",), ()]
    assert light_model("photograph") == "laboratory"


def test_the_outline_is_that_of_the_whole_object(recorder: Recorder) -> None:
    """A natural photograph that is blank in places ends where the laboratory photograph does."""
    whole = TwoMasks(disk(40, 15))
    for setting in whole.settings:
        SirfsFits().fit(whole, "disk", setting)  # type: ignore[arg-type]
    natural, laboratory = recorder.calls
    assert np.array_equal(natural["outline"], disk(40, 15))
    assert np.array_equal(natural["mask"], disk(40, 12))
    assert np.array_equal(laboratory["outline"], laboratory["mask"])


@pytest.mark.parametrize(
    "changes", [{"settings": ("natural",)}, {"whole": disk(44, 15)}], ids=["alone", "another size"]
)
def test_an_outline_that_is_not_known_is_the_mask(changes: dict[str, Any]) -> None:
    """Without a laboratory photograph of the same size, the object ends where it is known."""
    dataset = dataclasses.replace(TwoMasks(disk(40, 15)), **changes)
    outline = object_outline(dataset, "disk", "natural")
    assert np.array_equal(outline, disk(40, 12))


def test_every_input_is_in_the_key() -> None:
    """Another pixel, mask, outline, option or prior is another key; the same inputs are not."""
    mask, options = disk(40), FitOptions()
    image = painted(mask)
    brighter = image.copy()
    brighter[20, 20, 1] += 1e-9
    keys = [
        fit_key([image], mask, mask, options, "a"),
        fit_key([brighter], mask, mask, options, "a"),
        fit_key([image, brighter], mask, mask, options, "a"),
        fit_key([brighter, image], mask, mask, options, "a"),
        fit_key([image], disk(40, 9), mask, options, "a"),
        fit_key([image], mask, disk(40, 9), options, "a"),
        fit_key([image], mask, mask, FitOptions(light="natural"), "a"),
        fit_key([image], mask, mask, FitOptions(channels="gray"), "a"),
        fit_key([image], mask, mask, FitOptions(without=("slant",)), "a"),
        fit_key([image], mask, mask, FitOptions(evaluations=(9, 9)), "a"),
        fit_key([image], mask, mask, options, "b"),
    ]
    assert len(set(keys)) == len(keys)
    assert fit_key([image.copy()], mask.copy(), mask, FitOptions(), "a") == keys[0]


def test_a_fit_that_fails_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch, tiny_set: Synthetic, tmp_path: Path
) -> None:
    """A diverging fit is an error, not a blob."""
    pretend(monkeypatch, diverging_fit)
    with pytest.raises(RelightlabError, match="the fit diverged"):
        SirfsFits(tmp_path).fit(tiny_set, "cup", "natural")
    assert list(blob_files(tmp_path)) == []


def test_the_code_of_a_fit_is_in_its_key() -> None:
    """All modules that fitting imports, directly or not, are among the code that keys cover."""
    trees = {
        ".".join(path.with_suffix("").parts): tree
        for path, tree in parsed("evaluation", "shading_model", "datasets")
    }
    found, ahead = set(), ["evaluation.sirfs.fit"]
    while ahead:
        name = ahead.pop()
        if name in trees and name not in found:
            found.add(name)
            ahead += imports_of(trees[name])
    paths = {f"{name.replace('.', '/')}.py" for name in found}
    covered = {
        str(path.relative_to(ROOT))
        for place in FITTING_CODE
        for path in ([ROOT / place] if (ROOT / place).is_file() else (ROOT / place).rglob("*.py"))
    }
    assert "evaluation/sirfs/fit.py" in paths
    assert paths <= covered | UNINVOLVED
