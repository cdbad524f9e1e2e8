"""SIRFS in Table 1: the row of B + M and rows (b), by fits that cost nothing."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from datasets.model_parameters import shipped_parameters
from datasets.synthetic import Synthetic
from evaluation.blob_store import blob_files
from evaluation.grid_run import RunOptions
from evaluation.model_parts import ModelParts
from evaluation.own_rows import OwnChoices, run_own_rows
from evaluation.part_registries import find_part
from evaluation.provenance import Provenance
from evaluation.rerendering import image_cell
from evaluation.retinex_thresholds import thresholds_for
from evaluation.row_store import MemoryRows, RowStore
from evaluation.sirfs.fit import FitOptions
from evaluation.sirfs.result import SirfsFit
from evaluation.sirfs_fits import SirfsFits
from evaluation.sirfs_measurement import RIVAL, fitted_model, fitted_parts
from evaluation.table1 import run_table1
from evaluation.table1_grid import DETAIL_SOURCES, Table1Context, table1_experiment
from evaluation.table1_record import RIVAL_ENTRY, Table1
from evaluation.table1_results import table1_document
from evaluation.weight_rules import WEIGHT_RULES
from shading_model.arrays import Image, Mask
from shading_model.object_model import Weights
from shading_model.retinex import retinex
from tests.evaluation.conftest import LIGHTS, OBJECTS
from tests.evaluation.sirfs.fake_fits import diverging_fit, flat_fit, pretend

SETTINGS = ("natural", "laboratory")


def retinex_fit(image: Image, mask: Mask, priors: Any, options: FitOptions, **_: Any) -> SirfsFit:
    """Fit a flat shape, with the shading of Retinex at another scale."""
    fit = flat_fit(image, mask, priors, options)
    parameters = shipped_parameters()
    thresholds = thresholds_for("synthetic", "natural", "cup") or parameters.thresholds
    shading = retinex(image, mask, thresholds).shading
    return dataclasses.replace(fit, shading=np.repeat(3 * shading[..., None], 3, axis=-1))


def spotted_fit(image: Image, mask: Mask, priors: Any, options: FitOptions, **_: Any) -> SirfsFit:
    """Fit, but leave every seventh pixel unexplained."""
    known = mask & (np.indices(mask.shape).sum(axis=0) % 7 > 0)
    return flat_fit(image, known, priors, options)


@pytest.fixture(scope="module")
def whole_table(tiny_set: Synthetic) -> Table1:
    """Table 1 of the tiny set with rows (b) and B + M."""
    with pytest.MonkeyPatch.context() as patch:
        pretend(patch)
        return run_table1(tiny_set, LIGHTS, shipped_parameters())


def test_there_is_a_row_for_every_entry_of_the_published_table(whole_table: Table1) -> None:
    """For each setting three sources under every rule, then B + M; nothing is missing."""
    entries = [
        (row["setting"], row["method"], row["detail_source"], row["weights"])
        for row in whole_table.rows()
    ]
    assert entries == [
        entry
        for setting in SETTINGS
        for entry in (
            *((setting, "ours", s, r) for s in DETAIL_SOURCES for r in WEIGHT_RULES),
            (setting, *RIVAL_ENTRY.values()),
        )
    ]
    assert {row["cells"] for row in whole_table.rows()} == {len(OBJECTS) * len(LIGHTS)}
    assert len(whole_table.object_rows()) == len(entries) * len(OBJECTS)
    assert not whole_table.quick
    assert whole_table.missing == ()


def same_rows(ours: list[dict[str, Any]], others: list[dict[str, Any]]) -> bool:
    """Return whether rows have the same texts, and numbers that only rounding tells apart."""
    assert len(ours) == len(others)
    return all(
        one.keys() == other.keys()
        and all(
            np.isclose(value, other[key], rtol=1e-12, atol=0)
            if isinstance(value, float)
            else value == other[key]
            for key, value in one.items()
        )
        for one, other in zip(ours, others, strict=True)
    )


def test_the_other_entries_do_not_move(whole_table: Table1, tiny_table: Table1) -> None:
    """Rows, objects, baselines and intrinsic figures are those of a quick run."""
    for ours, quick in (
        (whole_table.rows(), tiny_table.rows()),
        (whole_table.object_rows(), tiny_table.object_rows()),
    ):
        needing = [
            row
            for row in ours
            if row["detail_source"] == "sirfs-shading" or row["method"] == "sirfs"
        ]
        assert same_rows([row for row in ours if row not in needing], quick)
    assert same_rows(whole_table.baselines(), tiny_table.baselines())
    assert same_rows(whole_table.intrinsic_rows(), tiny_table.intrinsic_rows())


def test_the_rival_is_its_own_albedo_under_the_new_light(
    whole_table: Table1, tiny_set: Synthetic
) -> None:
    """Each error is that of the picture A exp(B(N) . L), made from the fit by hand."""
    errors = whole_table.errors("laboratory", RIVAL, "coarse")
    for place, name in enumerate(OBJECTS):
        capture = tiny_set.load(name, "laboratory")
        photograph = capture.photograph
        fit = flat_fit(photograph.image, photograph.mask, 0.0, FitOptions())
        albedo = np.where(fit.mask[..., None], fit.albedo, 0.0)
        for number, light in enumerate(LIGHTS):
            relit = albedo * light.shade(np.array([0.0, 0.0, 1.0]))
            cell = image_cell(relit, photograph.mask, capture.truth, light)
            assert np.isclose(errors[place, number], cell.error(Weights(0, 0)), rtol=1e-12)


def test_detail_by_the_shading_of_retinex_is_the_default(
    tiny_set: Synthetic, tiny_table: Table1, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fit that splits the photograph as Retinex does gives rows (b) the errors of (a)."""
    pretend(monkeypatch, retinex_fit)
    only = {"detail_source": ["sirfs-shading"], "object": ["cup"], "setting": ["natural"]}
    table = run_table1(tiny_set, LIGHTS, shipped_parameters(), options=RunOptions(only=only))
    for rule in ("coarse", "default", "oracle"):
        found = table.errors("natural", "sirfs-shading", rule)[1]
        assert np.allclose(found, tiny_table.errors("natural", "default", rule)[1], rtol=1e-6)


def test_a_fit_that_fails_leaves_the_others_their_results(
    tiny_set: Synthetic, tiny_table: Table1, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its cells are missing with the reason; the next run measures those alone."""
    pretend(monkeypatch, diverging_fit)
    store = MemoryRows()
    broken = run_table1(tiny_set, LIGHTS, shipped_parameters(), store=store)
    lacking = {(found.cell["detail_source"], found.reason) for found in broken.missing_entries()}
    reason = "the fit diverged: its loss is not finite"
    assert lacking == {("sirfs-shading", reason), ("sirfs", reason)}
    assert len(broken.missing) == 2 * 2 * len(OBJECTS) * len(LIGHTS)
    kept = [row for row in broken.rows() if row["detail_source"] != "sirfs-shading"]
    assert same_rows([row for row in kept if row["method"] == "ours"], tiny_table.rows())
    assert all(np.isnan(row["imse"]) for row in kept if row["method"] == "sirfs")

    pretend(monkeypatch)
    measured = len(store.read()[0])
    mended = run_table1(tiny_set, LIGHTS, shipped_parameters(), store=store)
    assert len(store.read()[0]) - measured == len(broken.missing)
    assert mended.missing == ()


def test_a_whole_run_goes_on_from_a_quick_one(
    tiny_set: Synthetic, whole_table: Table1, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What a quick run measured is not measured again, nor the other way round."""
    pretend(monkeypatch)
    store, fits = RowStore(tmp_path / "rows.jsonl"), SirfsFits(tmp_path / "blobs")
    sizes = []
    for quick in (True, False, True):
        table = run_table1(
            tiny_set, LIGHTS, shipped_parameters(), store=store, quick=quick, fits=fits
        )
        sizes.append(len(store.read()[0]))
        assert table.quick == quick
        assert table.missing == ()
    each = 2 * len(OBJECTS) * len(LIGHTS)
    assert sizes == [3 * each, 5 * each, 5 * each]
    assert len(list(blob_files(tmp_path / "blobs"))) == 2 * len(OBJECTS)
    again = run_table1(tiny_set, LIGHTS, shipped_parameters(), store=store)
    assert same_rows(again.rows(), whole_table.rows())


def test_other_priors_are_other_inputs(
    tiny_set: Synthetic, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows measured by other priors do not count."""
    context = Table1Context(tiny_set, LIGHTS, shipped_parameters(), "gray", fits=SirfsFits())
    hashes = []
    for priors in ("one", "another"):
        pretend(monkeypatch, priors=priors)
        hashes.append(table1_experiment(context).input_hash())
    assert len(set(hashes)) == 2


def test_pixels_without_explanation(tiny_set: Synthetic) -> None:
    """Where a fit leaves pixels out, the rival is black and the shading is the nearest's."""
    photograph = tiny_set.load("cup", "natural").photograph
    fit = spotted_fit(photograph.image, photograph.mask, 0.0, FitOptions())
    model = fitted_model(fit, photograph.mask)
    left_out = photograph.mask & ~fit.mask
    assert left_out.sum() > 50
    assert (model.albedo[left_out] == 0).all()
    assert np.array_equal(model.albedo[fit.mask], fit.albedo[fit.mask])
    parts = fitted_parts(fit, photograph)
    assert np.isfinite(parts.shading[photograph.mask]).all()
    assert np.isfinite(parts.albedo[photograph.mask]).all()
    colour = parts.albedo * (parts.shading / fit.shading.mean(axis=-1))[..., None] * fit.shading
    assert np.allclose(colour[fit.mask], photograph.image[fit.mask])


def test_a_model_of_ones_own_has_rows_b_too(
    tiny_set: Synthetic, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Detail by SIRFS on a base shape of one's own, but no second row of B + M."""
    pretend(monkeypatch)
    choices = OwnChoices(parts=ModelParts(find_part("shape", "flat")))
    own = run_own_rows(choices, tiny_set, LIGHTS[:1], shipped_parameters())
    assert own.table is not None
    assert own.table.sources() == (*DETAIL_SOURCES, "flat")
    quick = run_own_rows(choices, tiny_set, LIGHTS[:1], shipped_parameters(), quick=True)
    kept = [row for row in own.rows() if row["detail_source"] != "sirfs-shading"]
    assert same_rows(kept, quick.rows())


def test_the_test_objects_stand_apart(whole_table: Table1) -> None:
    """Of MIT-Berkeley the same entries are given over test objects; of other sets none."""
    assert whole_table.test_rows() == []
    names = dict(zip(OBJECTS, ("apple", "pear", "sun"), strict=True))
    results = tuple(
        dataclasses.replace(result, name=names[result.name]) for result in whole_table.results
    )
    objects = tuple(names.values())
    measured = dataclasses.replace(
        whole_table, dataset="mit-berkeley", objects=objects, results=results
    )
    for row, both in zip(measured.test_rows(), measured.rows(), strict=True):
        parts = [
            one["imse"]
            for one in measured.object_rows()
            if one["object"] != "apple"
            and all(one[k] == row[k] for k in ("setting", "method", "detail_source", "weights"))
        ]
        assert row["cells"] == 2 * len(LIGHTS) < both["cells"]
        assert np.isclose(row["imse"], np.mean(parts))
    assert dataclasses.replace(measured, objects=("apple",)).test_rows() == []


@pytest.mark.parametrize("quick", [True, False])
def test_the_document_says_what_was_left_out(
    quick: bool, whole_table: Table1, tiny_table: Table1
) -> None:
    """Entries are open in a quick run alone, and then they are those that it lacks."""
    origin = Provenance(*["" for _ in range(5)], {}, "", "", {}, 0.0, 1, 0, 0)
    document = table1_document(tiny_table if quick else whole_table, origin)
    assert document["quick"] is quick
    computed = {(r["setting"], r["method"], r["detail_source"]) for r in document["rows"]}
    published = {(r["setting"], r["method"], r["detail_source"]) for r in document["published"]}
    left_out = {(e["setting"], e["method"], e["detail_source"]) for e in document["open"]}
    assert published - computed == left_out
    assert bool(left_out) is quick
    assert document["test_rows"] == []
