"""Errors of fits against the truth."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from datasets.mit_axes import harmonics_from_mit_axes
from datasets.mit_berkeley import MitBerkeley, normals_of_depth
from datasets.records import GroundTruth
from evaluation.sirfs.metrics import (
    ERROR_NAMES,
    SirfsErrors,
    geometric_mean_errors,
    sirfs_errors,
)
from evaluation.sirfs.result import SirfsFit
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics

SHAPE = (24, 31)
THEIR_NAMES = {
    "z_mae": "height",
    "n_mae": "normal",
    "s_mse": "shading",
    "r_mse": "reflectance",
    "rs_mse": "grosse",
    "l_mse": "light",
    "mean": "avg",
}
THEIR_SETTINGS = {"natural": "natural", "laboratory": "lab"}
seeds = st.integers(0, 2**32 - 1)


def bumpy_truth(generator: np.random.Generator) -> GroundTruth:
    """Everything of a rough surface in a coloured light."""
    height = np.cumsum(generator.normal(size=SHAPE), axis=0)
    light = LogHarmonics(0.2 * generator.normal(size=(9, 3)))
    normals = normals_of_depth(height)
    albedo = generator.uniform(0.2, 1, size=(*SHAPE, 3))
    return GroundTruth(height, normals, albedo, light.shade(normals), light)


def perfect_fit(truth: GroundTruth) -> SirfsFit:
    """The truth itself, as a fit."""
    assert truth.height is not None
    assert truth.normals is not None
    assert truth.albedo is not None
    assert truth.shading is not None
    assert truth.illumination is not None
    return SirfsFit(
        mask=np.ones(SHAPE, bool),
        height=truth.height,
        normals=truth.normals,
        albedo=truth.albedo,
        shading=truth.shading,
        illumination=truth.illumination,
        final_loss=0.0,
        terms={},
        evaluations=0.0,
        stopped="",
    )


def gray(fit: SirfsFit) -> SirfsFit:
    """The mean over the channels of albedo, shading and light."""
    return replace(
        fit,
        albedo=fit.albedo.mean(axis=-1, keepdims=True),
        shading=fit.shading.mean(axis=-1, keepdims=True),
        illumination=fit.illumination.monochrome(),
    )


@given(seeds)
def test_the_truth_has_no_error(seed: int) -> None:
    """In colour and in gray, however height is shifted and albedo, shading and light scaled."""
    truth = bumpy_truth(np.random.default_rng(seed))
    fit = perfect_fit(truth)
    brighter = fit.illumination.coefficients.copy()
    brighter[0] += 0.7
    moved = replace(
        fit,
        height=fit.height + 12.5,
        albedo=3 * fit.albedo,
        shading=fit.shading / 3,
        illumination=LogHarmonics(brighter),
    )
    for found in (fit, gray(fit), moved, gray(moved)):
        errors = sirfs_errors(found, truth)
        # The arc cosine of a cosine that rounding left short of one.
        assert errors.n_mae < 1e-7
        assert max(errors.z_mae, errors.s_mse, errors.r_mse, errors.rs_mse, errors.l_mse) < 1e-12


def test_each_error_by_hand() -> None:
    """Closed forms: steps of height, one tilt, and scales of single channels."""
    truth = bumpy_truth(np.random.default_rng(1))
    fit = perfect_fit(truth)
    step = np.zeros(SHAPE)
    step[:8] = 3.0
    assert np.isclose(sirfs_errors(replace(fit, height=fit.height + step), truth).z_mae, 1.0)

    facing = np.broadcast_to([0.0, 0.0, 1.0], (*SHAPE, 3))
    tilted = np.broadcast_to([0.0, np.sin(0.3), np.cos(0.3)], (*SHAPE, 3))
    level = replace(truth, normals=np.array(facing))
    assert np.isclose(sirfs_errors(replace(fit, normals=np.array(tilted)), level).n_mae, 0.3)

    # One scale for all channels: truth (1, 1, 1) by (1, 1, 2) leaves 1 - 16 / (6 * 3) of it.
    white = replace(truth, albedo=np.ones((*SHAPE, 3)))
    bluish = replace(fit, albedo=np.array(np.broadcast_to([1.0, 1.0, 2.0], (*SHAPE, 3))))
    errors = sirfs_errors(bluish, white)
    assert np.isclose(errors.r_mse, 1 - 16 / 18)
    # But each channel and window by itself is right.
    assert errors.rs_mse < 1e-12


def test_a_flat_light_against_a_lamp() -> None:
    """What no scale explains of exp(z) over the disk is its variance, by quadrature."""
    lamp = np.zeros(9)
    lamp[2] = 1 / (2 * 0.511664)
    truth = replace(bumpy_truth(np.random.default_rng(0)), illumination=LogHarmonics(lamp))
    fit = gray(perfect_fit(bumpy_truth(np.random.default_rng(0))))
    flat = replace(fit, illumination=LogHarmonics(np.zeros(9)))
    # Over a disk z^2 is uniform: the means of exp(z) and exp(2 z) are 2 and (e^2 + 1) / 2.
    # The published grid is half a pixel off its middle.
    expected = (np.e**2 + 1) / 2 - 4
    assert np.isclose(sirfs_errors(flat, truth).l_mse, expected, rtol=5e-3)


def test_the_rim_of_the_picture_does_not_count() -> None:
    """Albedo and shading are compared inside the outermost rows and columns; height everywhere."""
    truth = bumpy_truth(np.random.default_rng(2))
    fit = perfect_fit(truth)
    rim = np.ones(SHAPE, bool)
    rim[1:-1, 1:-1] = False
    changed = replace(
        fit,
        albedo=np.where(rim[..., None], 9.0, fit.albedo),
        shading=np.where(rim[..., None], 9.0, fit.shading),
        height=np.where(rim, fit.height + 1, fit.height),
    )
    errors = sirfs_errors(changed, truth)
    assert max(errors.s_mse, errors.r_mse, errors.rs_mse) < 1e-12
    assert np.isclose(errors.z_mae, rim.mean())


def test_what_is_not_known_is_nan() -> None:
    """Without a true light or shading their errors, and the mean, are NaN; the others stay."""
    truth = bumpy_truth(np.random.default_rng(3))
    fit = gray(perfect_fit(truth))
    bare = GroundTruth(truth.height, truth.normals, truth.albedo)
    errors = sirfs_errors(fit, bare)
    unknown = {name for name in ERROR_NAMES if np.isnan(getattr(errors, name))}
    assert unknown == {"s_mse", "rs_mse", "l_mse"}
    assert np.isnan(errors.mean)
    nothing = sirfs_errors(fit, GroundTruth(albedo=truth.albedo))
    assert np.isnan([nothing.z_mae, nothing.n_mae]).all()


def test_means_are_geometric_and_leave_out_zeros() -> None:
    """Of six errors, and of each error over objects; all zero is zero."""
    errors = SirfsErrors(2.0, 8.0, 1e-11, 4.0, 4.0, 4.0)
    assert np.isclose(errors.mean, 4.0)
    assert SirfsErrors(*[0.0] * 6).mean == 0
    both = geometric_mean_errors([errors, SirfsErrors(8.0, 2.0, 3.0, 1.0, 4.0, 1.0)])
    assert np.allclose([both.z_mae, both.n_mae, both.s_mse, both.r_mse], [4, 4, 3, 2])
    with pytest.raises(RelightlabError, match="at least one object"):
        geometric_mean_errors([])


def test_sizes_that_differ_and_nothing_in_common_are_refused() -> None:
    """Each with its sentence."""
    truth = bumpy_truth(np.random.default_rng(4))
    fit = perfect_fit(truth)
    assert truth.albedo is not None
    smaller = replace(truth, albedo=truth.albedo[:-1])
    with pytest.raises(RelightlabError, match=r"of shape \(24, 31\) but its truth of \(23, 31\)"):
        sirfs_errors(fit, smaller)
    with pytest.raises(RelightlabError, match="no pixel in common"):
        sirfs_errors(replace(fit, mask=np.zeros(SHAPE, bool)), truth)


@pytest.mark.real_data
@pytest.mark.parametrize("setting", ["natural", "laboratory"])
@pytest.mark.parametrize("channels", ["color", "gray"])
@pytest.mark.parametrize("name", ["paper2", "raccoon", "turtle"])
def test_the_original_programs_own_figures(
    name: str, channels: str, setting: str, data_root: Path, mit_berkeley_root: Path
) -> None:
    """On the results of SIRFS 1.5, run under Octave, these are the errors that it printed.

    Albedo and shading are stored as 16-bit floats, so their errors have fewer digits.
    """
    path = data_root / "sirfs-octave" / f"{THEIR_SETTINGS[setting]}_{channels}"
    if not path.is_dir():
        pytest.skip(f"{data_root} holds no results of the original program")
    with np.load(path / f"{name}.npz") as stored:
        arrays = dict(stored)
    albedo, shading = (
        np.atleast_3d(arrays[part].astype(np.float64)) for part in ("albedo", "shading")
    )
    height = arrays["height"].astype(np.float64)
    light = LogHarmonics(harmonics_from_mit_axes(arrays["light"]))
    fit = SirfsFit(
        *(arrays["valid"], height, normals_of_depth(height), albedo, shading, light),
        *(0.0, {}, 0.0, ""),
    )
    errors = sirfs_errors(fit, MitBerkeley(mit_berkeley_root).load(name, setting).truth)
    theirs = json.loads(str(arrays["errors"]))
    for ours, their_name in THEIR_NAMES.items():
        stored_whole = ours in {"z_mae", "n_mae", "l_mse"}
        tolerance = 1e-7 if stored_whole else 3e-4
        assert getattr(errors, ours) == pytest.approx(theirs[their_name], rel=tolerance)
