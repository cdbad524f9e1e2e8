"""Tests of reports.base_shape_studies: which studies stand in a report, and their files."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import pytest

from datasets.own_folder import OwnFolder
from datasets.psm_uw import PsmUw
from datasets.rgbd_mitten import RgbdMitten
from datasets.synthetic import Synthetic
from evaluation.base_shapes import FITTED_SHAPES
from evaluation.study_variants import VARIANTS
from reports import base_shape_studies
from reports.base_shape_run import BaseShapeStudy
from reports.base_shape_studies import (
    HELD_OUT,
    REPORT_VARIANTS,
    SIMULATION_VARIANTS,
    ReportStudy,
    joined,
    measure_report_study,
    report_studies,
    study_paths,
    write_study,
)
from reports.base_shape_views import PART
from tests.datasets.own_set import write_object
from tests.evaluation.sirfs.fake_fits import pretend
from tests.reports.small_result import SmallResult
from tests.reports.small_study import study_document


def test_variants_of_a_report_exist() -> None:
    """Every variant named is one of the study, the table's own first."""
    assert {*REPORT_VARIANTS, HELD_OUT} <= set(VARIANTS)
    assert set(SIMULATION_VARIANTS) <= set(REPORT_VARIANTS)
    assert REPORT_VARIANTS[0] == "mean"


def test_leave_one_out_is_measured_without_fits(small_result: SmallResult) -> None:
    """Of the two runs of a set, the one that would need many fits leaves them out."""
    table, held_out = ReportStudy(small_result.dataset).choices()
    assert set(table.variants) == set(REPORT_VARIANTS)
    assert set(FITTED_SHAPES) <= set(table.shapes_of(small_result.dataset))
    assert held_out.variants == (HELD_OUT,)
    assert not set(FITTED_SHAPES) & set(held_out.shapes_of(small_result.dataset))


def test_quick_measures_the_table_alone(small_result: SmallResult) -> None:
    """A quick report has one run in one variant, without fits."""
    (choice,) = ReportStudy(small_result.dataset, quick=True).choices()
    assert choice.variants == ("mean",)
    assert not set(FITTED_SHAPES) & set(choice.shapes_of(small_result.dataset))


def test_variants_a_set_cannot_have_are_left_out() -> None:
    """Without a diffuse photograph there is no such variant; a real sensor is not simulated."""
    uw = ReportStudy(PsmUw(Path("psm-uw"))).choices()[0].variants
    mitten = ReportStudy(RgbdMitten(Path("rgbd-mitten"))).choices()[0].variants
    assert "diffuse" not in {*uw, *mitten}
    assert "small-object" in uw
    assert "small-object" not in mitten


def test_sets_without_lit_photographs_are_left_out_in_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A user's folder that has no photographs under known lights is no failure."""
    write_object(tmp_path / "mugs" / "ball", lit=0)
    own = OwnFolder(tmp_path / "mugs")
    assert report_studies(own, named=str(tmp_path / "mugs")) == ()
    said = capsys.readouterr().out
    assert said.startswith("Table 2 is left out on own:mugs: own:mugs has no photographs of its")
    assert said.count("\n") == 1


def test_a_folder_with_lit_photographs_is_studied(tmp_path: Path) -> None:
    """A user's folder with photographs under known lights is studied, and nothing beside it."""
    write_object(tmp_path / "mugs" / "ball", lit=3)
    (study,) = report_studies(OwnFolder(tmp_path / "mugs"), named=str(tmp_path / "mugs"))
    assert study.experiments()[0].axes["light"] == ("00", "01", "02")


@pytest.mark.parametrize(
    ("named", "beside"), [(None, True), ("mit-berkeley", True), ("synthetic", False)]
)
def test_other_sets_are_looked_for_unless_one_was_named(
    small_result: SmallResult, monkeypatch: pytest.MonkeyPatch, named: str | None, beside: bool
) -> None:
    """The real sets that are found stand beside the paper's, not beside one that was asked for."""
    other = Synthetic(small_result.dataset.root)
    monkeypatch.setattr(base_shape_studies, "STUDY_SETS", {"psm-uw": lambda _: other})
    monkeypatch.setattr(base_shape_studies, "find_root_of", lambda *_: Path())
    found = report_studies(small_result.dataset, None, named, quick=True)
    assert [study.dataset is other for study in found] == ([False, True] if beside else [False])


@pytest.mark.slow
def test_all_variants_stand_in_one_document(
    small_result: SmallResult, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """What was measured in two runs is one study, kept in the store and turned for the check."""
    pretend(monkeypatch)
    monkeypatch.setattr(base_shape_studies, "REPORT_VARIANTS", ("mean", "half-height"))
    study = measure_report_study(ReportStudy(small_result.dataset), store=tmp_path)
    document = study.document
    variants = dict.fromkeys(row["variant"] for row in document["sensitivity"])
    assert list(variants) == ["mean", HELD_OUT, "half-height"]
    held_out = [row for row in document["sensitivity"] if row["variant"] == HELD_OUT]
    assert all(set(row["imse"]).isdisjoint(FITTED_SHAPES) for row in held_out)
    assert document["provenance"]["cells_done"] == 3 * 10 * (2 * 6 + 4)
    assert document["missing"] == []
    assert document[PART]


def test_joined_studies_keep_the_first_table(small_study: BaseShapeStudy) -> None:
    """Rows and tests are the first's; missing cells and counts are of both."""
    cell = {"object": "cup", "reason": "no room"}
    other = replace(
        small_study,
        document=study_document({"contour": 0.5}, dataset="synthetic", missing=[cell]),
    )
    both = joined(small_study, other).document
    assert both["rows"] == small_study.document["rows"]
    assert both["missing"] == [cell]
    first, second = (one.document["provenance"]["cells_done"] for one in (small_study, other))
    assert both["provenance"]["cells_done"] == first + second


def test_files_are_named_by_the_set(small_study: BaseShapeStudy, tmp_path: Path) -> None:
    """JSON and CSV have the set's name, are announced beforehand, and hold the same rows."""
    study = ReportStudy(small_study.context.dataset)
    written = write_study(tmp_path, small_study)
    assert written == study_paths(tmp_path, [study])
    assert [path.name for path in written] == ["table2-synthetic.json", "table2-synthetic.csv"]
    document = json.loads(written[0].read_text(encoding="utf-8"))
    assert document == small_study.document
    with written[1].open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["imse"]) for row in rows] == [row["imse"] for row in document["rows"]]
