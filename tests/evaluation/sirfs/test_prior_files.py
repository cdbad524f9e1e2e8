"""Priors in files, the shipped one, and their identity."""

from __future__ import annotations

import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from evaluation.sirfs.absolute_albedo import gray_knots
from evaluation.sirfs.light_prior import light_whitening
from evaluation.sirfs.prior_files import (
    FILE,
    load_priors,
    rounded_priors,
    save_priors,
    shipped_priors,
)
from evaluation.sirfs.priors import MIXTURES, arrays_of, priors_identity, priors_of
from evaluation.sirfs.settings import CHANNELS, LIGHTS
from shading_model.errors import RelightlabError
from tests.evaluation.sirfs.small_priors import small_priors


def test_saved_and_loaded_are_the_same(tmp_path: Path) -> None:
    """Every number, to the last bit, and so the identity."""
    priors = small_priors()
    save_priors(tmp_path / "priors.npz", priors)
    loaded = load_priors(tmp_path / "priors.npz")
    ours, theirs = arrays_of(priors), arrays_of(loaded)
    assert list(ours) == list(theirs)
    assert all(np.array_equal(ours[name], theirs[name]) for name in ours)
    assert priors_identity(loaded) == priors_identity(priors)


def test_the_same_priors_give_the_same_bytes(tmp_path: Path) -> None:
    """Whenever they are written."""
    for name in ("one.npz", "other.npz"):
        save_priors(tmp_path / name, small_priors())
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "other.npz").read_bytes()


def test_the_cost_of_a_colour_is_rounded(tmp_path: Path) -> None:
    """To steps of 1/256, before the identity is taken."""
    priors = small_priors()
    odd = replace(priors, color_absolute=priors.color_absolute + 1e-4)
    assert priors_identity(odd) != priors_identity(priors)
    assert priors_identity(rounded_priors(odd)) == priors_identity(priors)
    save_priors(tmp_path / "odd.npz", odd)
    assert priors_identity(load_priors(tmp_path / "odd.npz")) == priors_identity(priors)


def test_identity_is_that_of_every_number() -> None:
    """Whichever array changes by its last digit, the identity does."""
    priors = small_priors()
    seen = {priors_identity(priors)}
    arrays = arrays_of(priors)
    for name, values in arrays.items():
        changed = values + 1 if name.endswith("count") else np.nextafter(values, np.inf)
        seen.add(priors_identity(priors_of(arrays | {name: changed})))
    assert len(seen) == len(arrays) + 1


def test_a_damaged_file_is_one_sentence(tmp_path: Path) -> None:
    """Cut short, or of another content, it is not taken."""
    path = tmp_path / "priors.npz"
    save_priors(path, small_priors())
    whole = path.read_bytes()
    for length in range(0, len(whole), 97):
        path.write_bytes(whole[:length])
        with pytest.raises(RelightlabError, match=r"is damaged, or holds no priors of SIRFS"):
            load_priors(path)


def test_a_changed_number_is_one_sentence(tmp_path: Path) -> None:
    """A whole archive whose numbers are not those that were saved is refused."""
    path, other = tmp_path / "priors.npz", tmp_path / "other.npz"
    save_priors(path, small_priors())
    with zipfile.ZipFile(path) as archive, zipfile.ZipFile(other, "w") as changed:
        for name in archive.namelist():
            content = bytearray(archive.read(name))
            if name == "gray_absolute.npy":
                content[-1] ^= 1
            changed.writestr(name, bytes(content))
    with pytest.raises(RelightlabError, match="do not match the SHA-256 stored with them"):
        load_priors(other)


def test_other_archives_are_one_sentence(tmp_path: Path) -> None:
    """An archive of something else holds no priors."""
    np.savez(tmp_path / "model.npz", albedo=np.ones(3))
    with pytest.raises(RelightlabError, match="holds no priors of SIRFS"):
        load_priors(tmp_path / "model.npz")
    with pytest.raises(RelightlabError, match="no such file"):
        load_priors(tmp_path / "nowhere.npz")
    with pytest.raises(RelightlabError, match=r"to end in \.npz, got .*priors\.mat"):
        save_priors(tmp_path / "priors.mat", small_priors())


def test_shipped_priors_are_complete() -> None:
    """Of the documented shapes, for all lights and channels, small, and read once."""
    priors = shipped_priors()
    assert priors is shipped_priors()
    assert FILE.stat().st_size < 400_000
    assert set(priors.lights) == {(light, channels) for light in LIGHTS for channels in CHANNELS}
    for (_, channels), prior in priors.lights.items():
        size = 9 if channels == "gray" else 27
        assert prior.mean.shape == (size,)
        assert prior.covariance.shape == (size, size)
        assert np.isfinite(light_whitening(prior).inverse).all()
    for name in MIXTURES:
        mixture = getattr(priors, name)
        assert mixture.weights.shape == mixture.scales.shape == (40,)
        assert np.isclose(mixture.weights.sum(), 1)
        assert (np.diff(mixture.cost_table(101).values) > 0)[50:].all()
    assert priors.color_difference.covariance is not None
    assert np.isclose(np.linalg.det(priors.color_difference.covariance), 1)
    for absolute in (priors.gray_absolute, priors.color_absolute):
        assert absolute.min() == 0
        assert np.isfinite(absolute).all()
    assert priors.gray_absolute.shape == (256,)
    assert priors.color_absolute.shape == (102, 102, 102)


def test_shipped_costs_of_differences() -> None:
    """They are those of the original program, within the noise of sampling."""
    priors = shipped_priors()
    albedo = {0.01: 0.51, 0.05: 2.34, 0.1: 3.23, 0.5: 5.73, 1: 7.17, 2: 9.14}
    curvature = {0.001: 0.04, 0.01: 1.02, 0.05: 3.02, 0.1: 4.08, 0.5: 9.16, 1: 13.1}
    for mixture, costs in ((priors.gray_difference, albedo), (priors.curvature, curvature)):
        found = mixture.cost(np.array(list(costs)))
        assert np.allclose(found, list(costs.values()), rtol=0.03, atol=0.02)


def test_shipped_cost_of_gray_albedo() -> None:
    """Where albedos lie it is that of the original program, within the noise of sampling."""
    places, costs = [-3.12, -2.47, -1.82, -1.18, -0.53, -0.18], [3.5, 1.49, 1.82, 2.06, 1.34, 0.0]
    found = np.interp(places, gray_knots(), shipped_priors().gray_absolute)
    assert np.allclose(found, costs, atol=0.12)
