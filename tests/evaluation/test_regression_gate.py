"""Tests of the regression gate: what fails it, what passes it, and what it refuses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from datasets.synthetic import Synthetic
from evaluation import gate_measurement
from evaluation.gate_base_shapes import shape_variants
from evaluation.gate_baseline import (
    FOLDER,
    Baseline,
    baseline_text,
    new_baseline,
    read_baseline,
    write_baseline,
)
from evaluation.gate_measurement import (
    GateMeasurement,
    GateSet,
    measure_gate,
    rounded,
    synthetic_gate_set,
    variants,
)
from evaluation.gate_sirfs import fitted_variants
from evaluation.regression_gate import (
    FIT_ELSEWHERE,
    LOSS_ELSEWHERE,
    OTHER_PLATFORM,
    RENDERED_ELSEWHERE,
    SAME_PLATFORM,
    compare,
)
from shading_model import object_model
from shading_model.arrays import Float
from shading_model.contour_shape import shape_from_contour
from shading_model.errors import RelightlabError
from shading_model.geometric_detail import geometric_detail
from shading_model.illumination import PointLights
from shading_model.retinex import IntrinsicImages, Retinex, RetinexThresholds
from tests.evaluation.conftest import LIGHTS
from tests.evaluation.sirfs.fake_fits import diverging_fit, pretend

Patch = Callable[[pytest.MonkeyPatch], None]


@pytest.fixture(scope="module")
def tiny_gate(tiny_set: Synthetic) -> GateSet:
    """Three small objects under two lights."""
    return GateSet(tiny_set, LIGHTS[:2], "a tiny set")


@pytest.fixture(scope="module")
def measured(tiny_gate: GateSet) -> GateMeasurement:
    """What the code as it is measures on the tiny set."""
    return measure_gate(tiny_gate)


@pytest.fixture(scope="module")
def baseline(measured: GateMeasurement) -> Baseline:
    """Its record."""
    return new_baseline(measured, "the first", "2001-02-03")


def scaled(measured: GateMeasurement, cell: str, factor: float) -> GateMeasurement:
    """Return a measurement with the first error of one row multiplied by a factor."""
    first, *rest = measured.errors[cell]
    assert first is not None
    return replace(measured, errors={**measured.errors, cell: (first * factor, *rest)})


def point_light_fit(patch: pytest.MonkeyPatch) -> None:
    """Scale the fitted point lights' shading by 1%."""
    shade = PointLights.shade
    patch.setattr(PointLights, "shade", lambda *arguments: 1.01 * shade(*arguments))


def albedo(patch: pytest.MonkeyPatch) -> None:
    """Multiply the Retinex albedo by noise of 1%."""
    separate = Retinex.separate

    def noisy(self: Retinex, *arguments: RetinexThresholds) -> IntrinsicImages:
        parts = separate(self, *arguments)
        noise: Float = np.random.default_rng(0).normal(size=parts.albedo.shape)
        return IntrinsicImages(parts.albedo * (1 + 0.01 * noise), parts.shading)

    patch.setattr(Retinex, "separate", noisy)


def thresholds(patch: pytest.MonkeyPatch) -> None:
    """Raise both Retinex thresholds by 1%."""
    separate = Retinex.separate

    def changed(self: Retinex, given: RetinexThresholds) -> IntrinsicImages:
        raised = RetinexThresholds(1.01 * given.gray, 1.01 * given.chromaticity)
        return separate(self, raised)

    patch.setattr(Retinex, "separate", changed)


def normals(patch: pytest.MonkeyPatch) -> None:
    """Perturb the normals of the base shape by 1%."""

    def perturbed(mask: Float, slope_limit: float) -> object:
        shape = shape_from_contour(mask.astype(bool), slope_limit=slope_limit)
        noise = np.random.default_rng(0).normal(size=shape.normals.shape)
        tilted = shape.normals + 0.01 * noise
        unit = tilted / np.linalg.norm(tilted, axis=-1, keepdims=True)
        return replace(shape, normals=unit)

    patch.setattr(object_model, "shape_from_contour", perturbed)


def detail(patch: pytest.MonkeyPatch) -> None:
    """Scale the geometric detail by 1%."""

    def weakened(*arguments: object, **options: object) -> Float:
        layer: Float = geometric_detail(*arguments, **options)  # type: ignore[arg-type]
        return 0.99 * layer

    patch.setattr(object_model, "geometric_detail", weakened)


def test_every_variant_is_measured(measured: GateMeasurement) -> None:
    """Each object in each setting has every source and rule, the LMSE and both residuals."""
    words = {f"{source} {rule}" for source, rule in variants()} | set(gate_measurement.INTRINSIC)
    keys = {
        f"{setting} {name} {rest}"
        for setting in ("natural", "laboratory")
        for name in ("bear", "cup", "medal")
        for rest in words
    }
    shapes = {
        f"laboratory {name} {rest}"
        for name in ("bear", "cup", "medal")
        for rest in shape_variants()
    }
    assert set(measured.errors) == keys | shapes
    assert measured.size == 6 * (11 * 2 + 3) + 3 * 8 * 10
    assert all(value is not None for row in measured.errors.values() for value in row)


def test_the_same_code_passes(
    tiny_gate: GateSet, baseline: Baseline, measured: GateMeasurement, tmp_path: Path
) -> None:
    """Measured again, nothing is worse or better than the record read back from its file."""
    write_baseline(baseline, tmp_path)
    comparison = compare(read_baseline("synthetic", tmp_path), measure_gate(tiny_gate))
    assert comparison.passed
    assert (comparison.worse, comparison.better, comparison.differing) == ((), (), ())
    assert comparison.compared == measured.size
    assert comparison.tolerance == SAME_PLATFORM


@pytest.mark.parametrize("degrade", [point_light_fit, albedo, thresholds, normals, detail])
def test_a_planted_degradation_fails(
    degrade: Patch, tiny_gate: GateSet, baseline: Baseline, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One per cent in one stage makes cells worse, the worst first, also by the loose tolerance."""
    degrade(monkeypatch)
    elsewhere = replace(measure_gate(tiny_gate), platform={"system": "another"})
    comparison = compare(baseline, elsewhere)
    assert comparison.tolerance == OTHER_PLATFORM
    assert not comparison.passed
    growth = [change.relative for change in comparison.worse]
    assert growth == sorted(growth, reverse=True)
    assert growth[0] > 5 * OTHER_PLATFORM


def test_a_cell_that_improved_passes_and_is_told(
    baseline: Baseline, measured: GateMeasurement
) -> None:
    """A smaller error is listed as better and does not fail the gate."""
    cell = "natural cup default oracle"
    comparison = compare(baseline, scaled(measured, cell, 0.9))
    assert comparison.passed
    assert [change.cell for change in comparison.better] == [f"{cell} 00"]
    assert comparison.better[0].relative == pytest.approx(-0.1)


@pytest.mark.parametrize(
    ("platform", "below", "above"),
    [
        ({}, 0.5 * SAME_PLATFORM, 2 * SAME_PLATFORM),
        ({"system": "another"}, 0.5 * OTHER_PLATFORM, 2 * OTHER_PLATFORM),
    ],
)
def test_tolerances(
    platform: dict[str, str],
    below: float,
    above: float,
    baseline: Baseline,
    measured: GateMeasurement,
) -> None:
    """A growth below the platform's tolerance passes, one above it fails."""
    here = replace(measured, platform={**measured.platform, **platform})
    cell = "laboratory bear gt-shading regression"
    assert compare(baseline, scaled(here, cell, 1 + below)).passed
    assert not compare(baseline, scaled(here, cell, 1 + above)).passed
    assert bool(compare(baseline, here).differing) is bool(platform)


def test_a_cell_that_could_not_be_measured_is_the_worst(
    baseline: Baseline, measured: GateMeasurement
) -> None:
    """A missing number fails the gate, before all that are only larger."""
    larger = scaled(measured, "natural cup default oracle", 2)
    cell = "natural cup lmse"
    broken = replace(larger, errors={**larger.errors, cell: (None,)}, reasons=("out of memory",))
    comparison = compare(baseline, broken)
    assert [change.cell for change in comparison.worse] == [cell, "natural cup default oracle 00"]
    assert comparison.document()["worse"][0]["new"] is None
    assert comparison.reasons == ("out of memory",)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"protocol": "table-1 0"}, "this is table-1 0"),
        ({"content": "another set"}, "content of the dataset is another"),
        ({"errors": {"natural cup lmse": (0.1,)}}, "its cells are others, such as"),
    ],
)
def test_what_cannot_be_compared_is_refused(
    changes: dict[str, object], words: str, baseline: Baseline, measured: GateMeasurement
) -> None:
    """Another protocol, content or grid is refused, with the command that records anew."""
    with pytest.raises(RelightlabError, match=words) as refusal:
        compare(baseline, replace(measured, **changes))  # type: ignore[arg-type]
    assert "relightlab gate record --dataset synthetic" in str(refusal.value)


def test_files_made_elsewhere_may_differ_in_their_last_digits(
    baseline: Baseline, measured: GateMeasurement
) -> None:
    """A set made alike is compared though its files have another hash."""
    for platform in ({"system": "another"}, measured.platform):
        elsewhere = replace(measured, fingerprint="0" * 64, platform=platform)
        assert compare(baseline, elsewhere).passed


def test_the_file_is_deterministic_and_read_back(
    baseline: Baseline, tiny_gate: GateSet, tmp_path: Path
) -> None:
    """Two measurements give the same bytes, and reading and writing them changes nothing."""
    again = replace(measure_gate(tiny_gate, workers=2), commit=baseline.measured.commit)
    text = baseline_text(baseline)
    assert baseline_text(new_baseline(again, "the first", "2001-02-03")) == text
    path = write_baseline(baseline, tmp_path)
    assert path.read_text(encoding="utf-8") == text
    assert baseline_text(read_baseline("synthetic", tmp_path)) == text


def test_a_record_needs_a_reason(measured: GateMeasurement) -> None:
    """A record without a reason is refused."""
    with pytest.raises(RelightlabError, match="expected --reason"):
        new_baseline(measured, " \n", "2001-02-03")


def test_a_record_has_every_cell(measured: GateMeasurement) -> None:
    """A measurement that lacks a cell cannot become the record."""
    cell = "natural cup lmse"
    broken = replace(measured, errors={**measured.errors, cell: (None,)}, reasons=("it hung",))
    with pytest.raises(RelightlabError, match=r"could be measured \(it hung\)"):
        new_baseline(broken, "a reason", "2001-02-03")


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "{}", '{"format": "another"}', '{"format": "relightlab gate record 1"}']
)
def test_a_damaged_record_is_told(text: str, tmp_path: Path) -> None:
    """Whatever else lies in a record's place is refused in one sentence."""
    (tmp_path / "synthetic.json").write_text(text, encoding="utf-8")
    with pytest.raises(RelightlabError, match="is damaged, or no 'relightlab gate record 1'"):
        read_baseline("synthetic", tmp_path)


def test_a_missing_record_is_told(tmp_path: Path) -> None:
    """Where there is no record, the sentence says how to make one."""
    with pytest.raises(RelightlabError, match=r"there is no record of synthetic .* gate record"):
        read_baseline("synthetic", tmp_path)


@pytest.mark.parametrize(("value", "kept"), [(float("nan"), None), (1 / 3, 0.33333333)])
def test_numbers_are_kept_with_eight_digits(value: float, kept: float | None) -> None:
    """Numbers are rounded to eight significant digits; NaN is not measured."""
    assert rounded(value) == kept


def test_the_synthetic_set_is_made_alike_every_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two folders hold the same set, and its description names size and lights."""
    monkeypatch.setattr(gate_measurement, "SYNTHETIC_OBJECTS", ("apple",))
    one, two = (synthetic_gate_set(tmp_path / name) for name in "ab")
    assert one.dataset.fingerprint() == two.dataset.fingerprint()
    assert one.content == two.content
    assert "size 96" in one.content


@pytest.mark.parametrize("dataset", gate_measurement.SETS)
def test_the_projects_records_are_whole(dataset: str) -> None:
    """The committed records can be read, give a reason and cover every variant."""
    found = read_baseline(dataset, FOLDER)
    assert found.reason
    assert found.measured.dataset == dataset
    rows = {key.split(" ", 2)[2] for key in found.measured.errors}
    own = {f"{s} {r}" for s, r in variants()} | set(gate_measurement.INTRINSIC)
    assert rows == own | set(shape_variants()) | set(fitted_variants())
    fitted = {key.split()[1] for key in found.measured.errors if key.endswith("final_loss")}
    assert fitted == set(gate_measurement.FITTED[dataset])


@pytest.fixture(scope="module")
def fitted(tiny_set: Synthetic) -> Baseline:
    """A record with fits of one object, which are fakes."""
    with pytest.MonkeyPatch.context() as patch:
        pretend(patch)
        subject = GateSet(tiny_set, LIGHTS[:2], "a tiny set", ("cup",))
        return new_baseline(measure_gate(subject), "with fits", "2001-02-03")


def test_fits_are_measured_beside_the_rest(fitted: Baseline, measured: GateMeasurement) -> None:
    """Of the chosen object every variant and figure; all other numbers are as without."""
    own = {
        key: row
        for key, row in fitted.measured.errors.items()
        if not key.split()[2].startswith("sirfs")
    }
    assert own.keys() == measured.errors.keys()
    assert all(np.allclose(np.array(own[key]), np.array(measured.errors[key])) for key in own)  # type: ignore[arg-type]
    assert set(fitted.measured.errors) - set(own) == {
        f"{setting} cup {words}"
        for setting in ("natural", "laboratory")
        for words in fitted_variants()
    }
    assert fitted.measured.errors["natural cup sirfs final_loss"] == (1.5,)


def test_fits_that_fail_are_told(tiny_set: Synthetic, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their numbers are missing, with the reason, and cannot be recorded."""
    pretend(monkeypatch, diverging_fit)
    broken = measure_gate(GateSet(tiny_set, LIGHTS[:2], "a tiny set", ("cup",)))
    assert broken.errors["natural cup sirfs none"] == (None, None)
    assert broken.errors["laboratory cup sirfs z_mae"] == (None,)
    with pytest.raises(RelightlabError, match="the fit diverged"):
        new_baseline(broken, "a reason", "2001-02-03")


@pytest.mark.parametrize(
    ("cell", "changes", "tolerance"),
    [
        ("natural cup sirfs none", {}, SAME_PLATFORM),
        ("natural cup sirfs final_loss", {}, SAME_PLATFORM),
        ("natural cup sirfs none", {"platform": {}}, FIT_ELSEWHERE),
        ("natural cup sirfs-shading oracle", {"platform": {}}, FIT_ELSEWHERE),
        ("natural cup sirfs final_loss", {"platform": {}}, LOSS_ELSEWHERE),
        ("natural cup gt-shading oracle", {"platform": {}, "fingerprint": "0"}, OTHER_PLATFORM),
        ("laboratory cup gt-shading oracle", {"platform": {}}, OTHER_PLATFORM),
        (
            "laboratory cup gt-shading oracle",
            {"platform": {}, "fingerprint": "0"},
            RENDERED_ELSEWHERE,
        ),
        ("laboratory cup sirfs final_loss", {"platform": {}, "fingerprint": "0"}, FIT_ELSEWHERE),
    ],
)
def test_tolerances_of_what_wanders(
    cell: str, changes: dict[str, object], tolerance: float, fitted: Baseline
) -> None:
    """Fits on another platform, and photographs that it rendered, have tolerances of their own."""
    here = replace(fitted.measured, **changes)  # type: ignore[arg-type]
    assert compare(fitted, scaled(here, cell, 1 + 0.5 * tolerance)).passed
    assert not compare(fitted, scaled(here, cell, 1 + 2 * tolerance)).passed
