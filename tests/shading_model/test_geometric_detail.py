"""Geometric detail: what a dictionary of smooth patches cannot explain."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.linear_model import Lasso

from shading_model import geometric_detail as module
from shading_model.arrays import Float, Mask
from shading_model.errors import RelightlabError
from shading_model.geometric_detail import (
    PatchDictionary,
    code_patches,
    geometric_detail,
    patch_side,
    unit_atoms,
)
from tests.shading_model.outlines import disk, masks


def smooth_dictionary(side: int = 12, count: int = 60) -> PatchDictionary:
    """Ramps and parabolas in many directions: smooth patches, as the shipped ones are."""
    generator = np.random.default_rng(11)
    rows, columns = np.mgrid[:side, :side] / side - 0.5
    monomials = np.stack([rows, columns, rows**2, rows * columns, columns**2]).reshape(5, -1)
    weights = generator.normal(size=(count, 5)) * [1, 1, 0.5, 0.5, 0.5]
    return PatchDictionary(unit_atoms(weights @ monomials).reshape(count, side, side))


DICTIONARY = smooth_dictionary()


def objective(targets: Float, rebuilt: Float, codes_norm: Float, sparsity: float) -> Float:
    """The penalised error of each patch."""
    return 0.5 * np.sum((targets - rebuilt) ** 2, axis=1) + sparsity * codes_norm


@pytest.mark.parametrize("sparsity", [0.02, 0.1, 0.5])
def test_codes_are_those_of_the_lasso(sparsity: float) -> None:
    """Run to convergence, patches are rebuilt as scikit-learn's Lasso rebuilds them.

    The minimiser's codes need not be unique, but its reconstruction is.
    """
    generator = np.random.default_rng(0)
    atoms = unit_atoms(generator.normal(size=(30, 16)))
    patches = generator.normal(size=(8, 16))
    dictionary = PatchDictionary(atoms.reshape(30, 4, 4))
    found = code_patches(patches, dictionary, sparsity, iterations=2000)
    means = patches.mean(axis=1, keepdims=True)
    # Lasso divides the squared error by the number of values.
    lasso = Lasso(alpha=sparsity / 16, fit_intercept=False, tol=1e-10, max_iter=100_000)
    codes = np.stack([lasso.fit(atoms.T, patch).coef_ for patch in patches - means])
    assert np.abs(found - means - codes @ atoms).max() < 1e-3
    assert np.abs(codes @ atoms).max() > 0.1


def test_few_iterations_come_close_to_the_lasso() -> None:
    """What the default iterations rebuild is within 5 % (of its energy) of the converged one."""
    generator = np.random.default_rng(1)
    atoms = DICTIONARY.atoms.reshape(len(DICTIONARY.atoms), -1)
    patches = generator.normal(size=(50, 3)) @ atoms[:3] * 2
    converged = code_patches(patches, DICTIONARY, 0.3, iterations=2000)
    default = code_patches(patches, DICTIONARY, 0.3)
    assert np.sum((default - converged) ** 2) < 0.05 * np.sum(converged**2)


def test_an_orthonormal_dictionary_shrinks_softly() -> None:
    """With orthonormal atoms the Lasso is soft thresholding of the projections."""
    atoms = np.linalg.qr(np.column_stack([np.ones(16), np.eye(16)[:, :15]]))[0].T[1:]
    patches = np.random.default_rng(2).normal(size=(20, 16))
    projections = (patches - patches.mean(axis=1, keepdims=True)) @ atoms.T
    shrunk = np.sign(projections) * np.maximum(np.abs(projections) - 0.4, 0)
    found = code_patches(patches, PatchDictionary(atoms.reshape(15, 4, 4)), 0.4, iterations=500)
    assert np.allclose(found, shrunk @ atoms + patches.mean(axis=1, keepdims=True), atol=1e-5)


def test_a_large_penalty_leaves_the_mean() -> None:
    """Beyond the largest projection nothing is coded."""
    patches = np.random.default_rng(3).normal(size=(5, 144))
    found = code_patches(patches, DICTIONARY, sparsity=1e3)
    assert np.allclose(found, patches.mean(axis=1, keepdims=True))


def test_chunks_do_not_change_the_result(monkeypatch: pytest.MonkeyPatch) -> None:
    """Coding 7 patches at a time gives what coding all at once gives."""
    patches = np.random.default_rng(4).normal(size=(60, 144))
    whole = code_patches(patches, DICTIONARY, 0.1)
    monkeypatch.setattr(module, "CHUNK", 7)
    assert np.allclose(code_patches(patches, DICTIONARY, 0.1), whole, atol=1e-5)


def affine_shading(mask: Mask, slope: float) -> Float:
    """A ramp over the picture, of mean about one half."""
    rows, columns = np.indices(mask.shape) / max(mask.shape) - 0.5
    return np.where(mask, 0.5 + slope * (rows + 0.7 * columns), np.nan)


def test_a_constant_shading_has_no_detail() -> None:
    """Each patch keeps its mean, so nothing is left."""
    mask = disk(40)[0]
    detail = geometric_detail(np.where(mask, 0.5, np.nan), mask, DICTIONARY)
    assert np.nanmax(np.abs(detail)) < 1e-6


def test_an_affine_shading_has_next_to_no_detail() -> None:
    """What the penalty takes from a ramp cancels where patches overlap, away from the outline."""
    mask = np.ones((90, 90), bool)
    shading = affine_shading(mask, 0.3)
    detail = geometric_detail(shading, mask, DICTIONARY)
    inner = detail[15:-15, 15:-15]
    assert np.abs(inner).max() < 0.01 * np.ptp(shading)
    assert np.abs(detail).max() < 0.05 * np.ptp(shading)


@given(st.floats(1e-3, 1e3))
@settings(max_examples=10)
def test_detail_scales_with_the_shading(scale: float) -> None:
    """A photograph twice as bright has twice the detail."""
    mask, x, y = disk(20)
    shading = np.where(mask, 1 + 0.2 * np.sin(9 * x) * np.cos(7 * y), np.nan)
    one, other = (geometric_detail(k * shading, mask, DICTIONARY) for k in (1, scale))
    assert np.allclose(other[mask], scale * one[mask], atol=1e-4 * scale)


def test_a_fine_texture_is_found_where_it_is() -> None:
    """A checkered half of a smooth ball: detail there follows the texture, and only there."""
    mask, x, y = disk(80)
    smooth = 0.3 + 0.5 * np.sqrt(np.maximum(1.2 - x**2 - y**2, 0))
    rows, columns = np.indices(mask.shape)
    checks = 0.03 * np.where((rows + columns) % 2, 1.0, -1.0) * (x > 0.1)
    plain = geometric_detail(np.where(mask, smooth, np.nan), mask, DICTIONARY)
    detail = geometric_detail(np.where(mask, smooth + checks, np.nan), mask, DICTIONARY)
    textured = mask & (x > 0.15)
    elsewhere = mask & (x < -0.15)
    assert np.corrcoef(detail[textured], checks[textured])[0, 1] > 0.8
    assert np.std(detail[textured]) > 2 * np.std(plain[textured])
    assert np.allclose(detail[elsewhere], plain[elsewhere], atol=2e-3)


def test_nothing_outside_the_mask_matters() -> None:
    """Values outside the mask are not looked at, and the result there is NaN."""
    mask, x, y = disk(25)
    shading = 0.5 + 0.1 * np.sin(8 * x + 3 * y)
    given_nan = geometric_detail(np.where(mask, shading, np.nan), mask, DICTIONARY)
    given_junk = geometric_detail(np.where(mask, shading, 1e9), mask, DICTIONARY)
    assert np.array_equal(given_nan, given_junk, equal_nan=True)
    assert (np.isnan(given_nan) == ~mask).all()


def test_where_the_object_lies_in_its_picture_does_not_matter() -> None:
    """Room around the object changes nothing, to the last bit."""
    mask, x, y = disk(25)
    shading = np.where(mask, 0.5 + 0.1 * np.sin(8 * x + 3 * y), np.nan)
    here = geometric_detail(shading, mask, DICTIONARY)
    room = ((13, 4), (1, 30))
    there = geometric_detail(np.pad(shading, room), np.pad(mask, room), DICTIONARY)
    assert np.array_equal(there[13:-4, 1:-30], here, equal_nan=True)


@settings(max_examples=30)
@given(masks(14), st.integers(0, 2**32 - 1))
def test_any_mask_has_finite_detail_inside_and_only_there(mask: Mask, seed: int) -> None:
    """Objects smaller than a patch, single pixels, thin and scattered parts included."""
    shading = np.random.default_rng(seed).uniform(0.1, 1, size=mask.shape)
    detail = geometric_detail(shading, mask, DICTIONARY)
    assert (np.isfinite(detail) == mask).all()


def test_the_patch_follows_the_size_of_the_object() -> None:
    """Twelve pixels at six hundred, in proportion elsewhere, never below four."""
    assert [patch_side((size, 10)) for size in (100, 200, 300, 600, 1200, 2400)] == [
        4,
        4,
        6,
        12,
        24,
        48,
    ]
    assert patch_side((10, 600)) == patch_side((600, 10))


def test_the_patch_size_is_that_of_the_bounding_box(monkeypatch: pytest.MonkeyPatch) -> None:
    """The dictionary is resized for the object, not for the picture around it."""
    asked: list[int] = []
    resized = PatchDictionary.resized

    def noted(self: PatchDictionary, side: int) -> PatchDictionary:
        asked.append(side)
        return resized(self, side)

    monkeypatch.setattr(PatchDictionary, "resized", noted)
    mask = np.zeros((700, 40), bool)
    mask[100:400, 5:20] = True
    geometric_detail(np.where(mask, 0.5, np.nan), mask, DICTIONARY)
    assert asked == [6]


@pytest.mark.parametrize("side", [4, 5, 12, 30])
def test_resized_atoms_stay_unit_and_mean_free(side: int) -> None:
    """At any size, and ramps stay ramps."""
    resized = DICTIONARY.resized(side)
    rows = resized.atoms.reshape(len(DICTIONARY.atoms), -1)
    assert resized.atoms.shape == (60, side, side)
    assert np.allclose(rows.mean(axis=1), 0, atol=1e-12)
    assert np.allclose(np.linalg.norm(rows, axis=1), 1)
    ramp = PatchDictionary(unit_atoms(np.arange(144.0)[None] // 12).reshape(1, 12, 12))
    expected = unit_atoms(np.repeat(np.arange(float(side)), side)[None]).ravel()
    assert ramp.resized(side).atoms.ravel() @ expected > 0.99


def test_its_own_size_is_the_dictionary_itself() -> None:
    """Nothing is interpolated where nothing has to be."""
    assert DICTIONARY.resized(12) is DICTIONARY


def test_atoms_of_one_value_stay_zero() -> None:
    """A constant atom has no direction; it is left at zero, not divided by zero."""
    assert (unit_atoms(np.full((1, 9), 3.0)) == 0).all()


@pytest.mark.parametrize("shape", [(5, 16), (5, 4, 3), (4,)])
def test_atoms_of_another_shape_are_refused(shape: tuple[int, ...]) -> None:
    """Atoms are square patches, one per row of the array."""
    with pytest.raises(RelightlabError, match=r"expected atoms of shape \(k, p, p\)"):
        PatchDictionary(np.zeros(shape))


def test_unusable_input_is_refused() -> None:
    """NaN in the dictionary, an empty mask, and a shading of another size."""
    with pytest.raises(RelightlabError, match="atoms contain NaN"):
        PatchDictionary(np.full((1, 2, 2), np.nan))
    with pytest.raises(RelightlabError, match="the mask is empty"):
        geometric_detail(np.ones((5, 5)), np.zeros((5, 5), bool), DICTIONARY)
    with pytest.raises(RelightlabError, match="expected shading of shape"):
        geometric_detail(np.ones((5, 4)), np.ones((5, 5), bool), DICTIONARY)
