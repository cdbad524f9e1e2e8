"""The shipped dictionary of smooth shading patches."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest

from datasets import shading_dictionary
from datasets.model_parameters import shipped_parameters
from datasets.shading_dictionary import (
    ATOMS,
    SHA256,
    SIDE,
    learn_dictionary,
    random_lights,
    random_outline,
    shipped_dictionary,
    smooth_patches,
)
from shading_model.errors import RelightlabError
from shading_model.geometric_detail import geometric_detail, unit_atoms
from shading_model.seeds import generator_for


def test_the_file_is_the_one_that_was_learned() -> None:
    """Its SHA-256 is the one written in the module."""
    assert hashlib.sha256(shading_dictionary.FILE.read_bytes()).hexdigest() == SHA256


@pytest.mark.parametrize("content", [None, b"", b"another file"])
def test_another_file_is_refused(
    content: bytes | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Missing, empty or changed by one byte, it says what to do."""
    file = tmp_path / "shading_dictionary.npy"
    if content is not None:
        whole = bytearray(shading_dictionary.FILE.read_bytes())
        whole[-1] ^= 1
        file.write_bytes(content and bytes(whole))
    monkeypatch.setattr(shading_dictionary, "FILE", file)
    shipped_dictionary.cache_clear()
    with pytest.raises(RelightlabError, match="missing or damaged: install again, or learn it"):
        shipped_dictionary()
    shipped_dictionary.cache_clear()


def test_atoms_are_unit_and_mean_free() -> None:
    """Five hundred patches of twelve by twelve."""
    atoms = shipped_dictionary().atoms
    assert atoms.shape == (ATOMS, SIDE, SIDE)
    assert np.allclose(np.linalg.norm(atoms, axis=(1, 2)), 1, atol=1e-5)
    assert np.allclose(atoms.mean(axis=(1, 2)), 0, atol=1e-6)


def test_atoms_are_smooth() -> None:
    """Most atoms vary far less from pixel to pixel than noise of the same norm does.

    White noise has a mean squared difference of neighbours of twice its variance.
    """
    atoms = shipped_dictionary().atoms
    change = (np.diff(atoms, axis=1) ** 2).mean(axis=(1, 2))
    change += (np.diff(atoms, axis=2) ** 2).mean(axis=(1, 2))
    noise = 4 / SIDE**2
    assert np.median(change) < 0.1 * noise
    assert change.max() < noise


@pytest.mark.parametrize("side", [4, 7, 24])
def test_resized_atoms_keep_their_norm(side: int) -> None:
    """Unit norm and mean zero at other patch sizes."""
    atoms = shipped_dictionary().resized(side).atoms
    assert atoms.shape == (ATOMS, side, side)
    assert np.allclose(np.linalg.norm(atoms, axis=(1, 2)), 1)
    assert np.allclose(atoms.mean(axis=(1, 2)), 0, atol=1e-12)


def test_a_smooth_shading_has_less_detail_than_a_rough_one() -> None:
    """A shading of the kind it was learned on leaves a fifth of what a bumpy one leaves."""
    generator = generator_for("test", "smooth shading")
    mask = random_outline(generator, side=150)
    rows, columns = np.indices(mask.shape) / 150
    smooth = np.where(mask, 0.5 + 0.3 * np.sin(3 * rows + 2 * columns), np.nan)
    bumps = 0.05 * np.random.default_rng(0).standard_normal(mask.shape)
    calm, rough = (
        geometric_detail(s, mask, shipped_dictionary()) for s in (smooth, smooth + bumps)
    )
    assert np.nanstd(calm) < 0.2 * np.nanstd(rough)


def test_models_are_built_with_it() -> None:
    """The shipped parameters hold the shipped dictionary."""
    assert shipped_parameters().dictionary is shipped_dictionary()


def test_random_outlines_are_inside_their_picture() -> None:
    """Every draw is one object that touches no edge, and two draws differ."""
    generator = generator_for("test", "outlines")
    outlines = [random_outline(generator, side=80) for _ in range(5)]
    for mask in outlines:
        assert 0.05 < mask.mean() < 0.8
        assert not (mask[0] | mask[-1] | mask[:, 0] | mask[:, -1]).any()
    assert (outlines[0] != outlines[1]).any()


def test_random_lights_are_in_front_and_of_unit_strength() -> None:
    """One to three sources, whose irradiances at the centre of the picture sum to one."""
    generator = generator_for("test", "lights")
    counts = set()
    for _ in range(30):
        light = random_lights(generator, side=100)
        centred = light.positions - [50, -50, 0]
        assert (centred[:, 2] > 0).all()
        assert np.isclose(np.sum(light.intensities / np.sum(centred**2, axis=1)), 1)
        counts.add(len(light.positions))
    assert counts == {1, 2, 3}


def test_learning_patches_are_unit_and_follow_the_generator(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Mean-free patches of unit norm, the same from the same generator."""
    monkeypatch.setattr(shading_dictionary, "OUTLINES", 1)
    monkeypatch.setattr(shading_dictionary, "LIGHTS_PER_OUTLINE", 2)
    monkeypatch.setattr(shading_dictionary, "PATCHES", 200)
    one, other = (smooth_patches(generator_for("test", "patches")) for _ in range(2))
    assert one.tobytes() == other.tobytes()
    assert 0 < len(one) <= 200
    assert np.allclose(np.linalg.norm(one, axis=1), 1)
    assert np.allclose(one.mean(axis=1), 0)


def test_learning_finds_the_atoms_patches_are_made_of(monkeypatch: pytest.MonkeyPatch) -> None:
    """Patches that are multiples of four atoms give a dictionary that holds all four."""
    monkeypatch.setattr(shading_dictionary, "ATOMS", 20)
    generator = np.random.default_rng(0)
    truth = unit_atoms(generator.normal(size=(4, 16)))
    patches = truth[generator.integers(4, size=2000)] * generator.choice([-1, 1], size=(2000, 1))
    learned = learn_dictionary(patches)
    assert learned.atoms.shape == (20, 4, 4)
    likeness = np.abs(learned.atoms.reshape(20, 16) @ truth.T).max(axis=0)
    assert (likeness > 0.99).all()
