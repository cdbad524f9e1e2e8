"""SIRFS as a grid: errors by object and over sets, what fails, and what goes on."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from datasets.records import Capture, GroundTruth
from datasets.synthetic import Synthetic
from evaluation.grid_run import RunOptions
from evaluation.object_sets import object_sets
from evaluation.row_store import MemoryRows, RowStore
from evaluation.sirfs.fit import FitOptions
from evaluation.sirfs.metrics import ERROR_NAMES, sirfs_errors
from evaluation.sirfs.result import SirfsFit
from evaluation.sirfs_fits import SirfsFits
from evaluation.sirfs_grid import SirfsContext, run_sirfs, sirfs_experiment
from shading_model.arrays import Image, Mask
from shading_model.errors import RelightlabError
from tests.evaluation.conftest import OBJECTS
from tests.evaluation.sirfs.fake_fits import flat_fit, pretend

KEYS = [
    *("object", "setting", "channels", *ERROR_NAMES, "mean"),
    *("final_loss", "evaluations", "seconds"),
]


@dataclasses.dataclass(frozen=True)
class Renamed:
    """The tiny set under another name, its objects under others, with less of the truth."""

    whole: Synthetic
    name: str = "mit-berkeley"
    objects: tuple[str, ...] = ("apple", "pear", "sun")
    settings: tuple[str, ...] = ("natural", "laboratory")
    lacking: tuple[str, ...] = ()

    def load(self, name: str, setting: str) -> Capture:
        """An object by its new name."""
        capture = self.whole.load(OBJECTS[self.objects.index(name)], setting)
        less: dict[str, Any] = dict.fromkeys(self.lacking)
        return dataclasses.replace(capture, truth=dataclasses.replace(capture.truth, **less))

    def fingerprint(self) -> str:
        """The whole set's."""
        return self.whole.fingerprint()


def faulty_fit(image: Image, mask: Mask, priors: Any, options: FitOptions, **_: Any) -> SirfsFit:
    """Fail on gray photographs only."""
    if options.channels == "gray":
        raise RelightlabError("the mask has too few pixels")
    return flat_fit(image, mask, priors, options)


@pytest.fixture(autouse=True)
def fake(monkeypatch: pytest.MonkeyPatch) -> None:
    """No test here fits in earnest."""
    pretend(monkeypatch)


def context(dataset: Any, **options: Any) -> SirfsContext:
    """What is measured with, keeping nothing."""
    return SirfsContext(dataset, SirfsFits(**options))


def test_every_fit_has_its_row(tiny_set: Synthetic) -> None:
    """Setting by object by channels, the documented keys, and the errors of the fit itself."""
    table = run_sirfs(context(tiny_set))
    assert len(table.rows) == 2 * len(OBJECTS) * 2
    assert all(list(row) == KEYS for row in table.rows)
    assert table.missing == ()
    for row in table.rows:
        capture = tiny_set.load(row["object"], row["setting"])
        options = FitOptions(channels=row["channels"])
        fit = flat_fit(capture.photograph.image, capture.photograph.mask, 1.5, options)
        errors = sirfs_errors(fit, capture.truth)
        assert [row[name] for name in ERROR_NAMES] == [getattr(errors, n) for n in ERROR_NAMES]
        assert row["mean"] == errors.mean
        assert (row["final_loss"], row["evaluations"]) == (1.5, 12.25)
        assert row["seconds"] > 0


def test_sets_have_geometric_means(tiny_set: Synthetic) -> None:
    """Over training and test objects of MIT-Berkeley, with the number of objects."""
    table = run_sirfs(context(Renamed(tiny_set)), channels=["color"])
    assert [(row["object"], row["setting"], row["objects"]) for row in table.summary] == [
        ("MIT_TRAIN", "natural", 1),
        ("MIT_TEST", "natural", 2),
        ("MIT_TRAIN", "laboratory", 1),
        ("MIT_TEST", "laboratory", 2),
    ]
    assert all(list(row) == [*KEYS, "objects"] for row in table.summary)
    for row in table.summary:
        members = ("apple",) if row["object"] == "MIT_TRAIN" else ("pear", "sun")
        of_set = [
            one
            for one in table.rows
            if one["object"] in members and one["setting"] == row["setting"]
        ]
        for name in (*ERROR_NAMES, "mean"):
            expected = np.exp(np.mean([np.log(one[name]) for one in of_set]))
            assert np.isclose(row[name], expected)
        assert np.isclose(row["seconds"], np.mean([one["seconds"] for one in of_set]))


def test_other_sets_are_averaged_whole(tiny_set: Synthetic) -> None:
    """One summary for each setting and number of channels."""
    table = run_sirfs(context(tiny_set), channels=["gray"], settings=["natural"])
    assert [(row["object"], row["objects"]) for row in table.summary] == [("all", len(OBJECTS))]
    assert object_sets("own:set", ("mug",)) == {"all": ("mug",)}
    assert object_sets("mit-berkeley", ("mug",)) == {"all": ("mug",)}


def test_a_choice_has_its_rows_alone(tiny_set: Synthetic) -> None:
    """Objects, settings and channels narrow the grid; unknown ones are refused."""
    table = run_sirfs(context(tiny_set), ["cup"], ["laboratory"], ["gray"])
    assert [(row["object"], row["setting"], row["channels"]) for row in table.rows] == [
        ("cup", "laboratory", "gray")
    ]
    for words, choice in {
        "Unknown object 'cap'. Did you mean 'cup'?": {"objects": ["cap"]},
        "Unknown setting 'both'": {"settings": ["both"]},
        "Unknown channels 'grey'. Did you mean 'gray'?": {"channels": ["grey"]},
    }.items():
        with pytest.raises(RelightlabError) as caught:
            run_sirfs(context(tiny_set), **choice)
        assert words in str(caught.value)
    with pytest.raises(RelightlabError, match="Unknown term 'slope'"):
        run_sirfs(context(tiny_set, without=("slope",)))


def test_a_fit_that_fails_is_a_missing_row(
    tiny_set: Synthetic, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The others are measured, the reason is told, and the next run tries it again."""
    pretend(monkeypatch, faulty_fit)
    store = MemoryRows()
    table = run_sirfs(context(tiny_set), ["cup"], store=store)
    assert {row["channels"] for row in table.rows} == {"color"}
    assert [cell["reason"] for cell in table.missing] == ["the mask has too few pixels"] * 2
    assert {cell["channels"] for cell in table.missing} == {"gray"}
    assert len(table.summary) == 2
    pretend(monkeypatch)
    mended = run_sirfs(context(tiny_set), ["cup"], store=store)
    assert mended.missing == ()
    assert [row for row in mended.rows if row["channels"] == "color"] == list(table.rows)


def test_a_store_is_shared_by_all_choices(tiny_set: Synthetic, tmp_path: Path) -> None:
    """What one choice measured another finds, with its seconds; ablations are kept apart."""
    store = RowStore(tmp_path / "rows.jsonl")
    run_sirfs(context(tiny_set), ["cup"], channels=["color"], store=store)
    whole = run_sirfs(context(tiny_set), channels=["color"], store=store)
    assert len(store.read()[0]) == 2 * len(OBJECTS)
    again = run_sirfs(context(tiny_set), ["cup", "bear"], channels=["color"], store=store)
    assert list(again.rows) == [row for row in whole.rows if row["object"] != "medal"]
    ablated = run_sirfs(context(tiny_set, without=("slant",)), ["cup"], ["natural"], store=store)
    assert {row["final_loss"] for row in ablated.rows} == {2.5}
    assert {row["final_loss"] for row in whole.rows} == {1.5}
    names = {row["experiment"] for row in store.read()[0]}
    assert names == {"sirfs", "sirfs without slant"}


def test_what_is_not_known_has_no_error(tiny_set: Synthetic) -> None:
    """Without a true light or shading their errors and the mean are None; the rest is there."""
    dataset = Renamed(tiny_set, name="own", lacking=("shading", "illumination"))
    table = run_sirfs(context(dataset), settings=["natural"], channels=["color"])
    for row in (*table.rows, *table.summary):
        unknown = {name for name in KEYS if row[name] is None}
        assert unknown == {"s_mse", "rs_mse", "l_mse", "mean"}


def test_without_any_truth_the_fit_is_still_told(tiny_set: Synthetic) -> None:
    """Loss and evaluations are there though no error is known."""
    everything = tuple(field.name for field in dataclasses.fields(GroundTruth))
    dataset = Renamed(tiny_set, name="own", lacking=everything)
    table = run_sirfs(context(dataset), ["sun"], ["natural"], ["color"])
    (row,) = table.rows
    assert all(row[name] is None for name in (*ERROR_NAMES, "mean"))
    assert row["final_loss"] == 1.5


def test_inputs_change_with_priors(tiny_set: Synthetic, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows by other priors do not count."""
    before = sirfs_experiment(context(tiny_set)).input_hash()
    pretend(monkeypatch, priors="others")
    assert sirfs_experiment(context(tiny_set)).input_hash() != before


def test_cells_are_measured_by_any_choice_of_the_run(tiny_set: Synthetic) -> None:
    """Cells left out by --only are missing, not failed."""
    options = RunOptions(only={"object": ["cup"]})
    table = run_sirfs(context(tiny_set), settings=["natural"], channels=["color"], options=options)
    assert [row["object"] for row in table.rows] == ["cup"]
    assert {cell["reason"] for cell in table.missing} == {"not measured"}
