"""Files of fits: what is saved comes back, and what is damaged is told."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from evaluation.sirfs.fit import FitOptions
from evaluation.sirfs.fit_files import load_fit, save_fit
from evaluation.sirfs.result import SirfsFit
from shading_model.errors import RelightlabError
from tests.evaluation.sirfs.fake_fits import flat_fit
from tests.example_objects import disk, painted


def made(channels: str = "color") -> SirfsFit:
    """A fit of a painted disk."""
    return flat_fit(painted(disk(20)), disk(20), 1.5, FitOptions(channels=channels))


def same(one: SirfsFit, other: SirfsFit) -> bool:
    """Return whether two fits agree to the last bit, NaN and types included."""
    return all(
        np.array_equal(first.coefficients, second.coefficients)
        if field.name == "illumination"
        else type(first) is type(second)
        and (
            np.array_equal(first, second, equal_nan=True) and first.dtype == second.dtype
            if isinstance(first, np.ndarray)
            else first == second
        )
        for field in fields(SirfsFit)
        for first, second in [(getattr(one, field.name), getattr(other, field.name))]
    )


@pytest.mark.parametrize("channels", ["color", "gray"])
def test_a_fit_comes_back_bit_by_bit(channels: str, tmp_path: Path) -> None:
    """All maps, the light, the terms and the words, in colour and in gray."""
    fit = made(channels)
    save_fit(tmp_path / "a.npz", fit)
    assert same(load_fit(tmp_path / "a.npz"), fit)
    assert not same(replace(fit, final_loss=0.0), fit)


def test_the_same_fit_gives_the_same_bytes(tmp_path: Path) -> None:
    """Two files of one fit are alike, also when it was read from the first."""
    save_fit(tmp_path / "a.npz", made())
    save_fit(tmp_path / "b.npz", load_fit(tmp_path / "a.npz"))
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_numpy_reads_the_file(tmp_path: Path) -> None:
    """The documented names are there for anyone who has NumPy alone."""
    fit = made()
    save_fit(tmp_path / "a.npz", fit)
    with np.load(tmp_path / "a.npz") as stored:
        names = {"height", "normals", "albedo", "shading", "light", "final_loss", "mask"}
        assert names <= set(stored)
        assert stored["light"].shape == (9, 3)
        assert float(stored["final_loss"]) == fit.final_loss
        assert np.array_equal(stored["albedo"], fit.albedo, equal_nan=True)


def test_a_fit_without_terms_comes_back(tmp_path: Path) -> None:
    """Nothing is a mapping too."""
    save_fit(tmp_path / "a.npz", replace(made(), terms={}))
    assert load_fit(tmp_path / "a.npz").terms == {}


def test_every_cut_and_flip_is_told(tmp_path: Path) -> None:
    """A file cut anywhere, or with a byte of its content changed, is refused in one sentence."""
    path = tmp_path / "a.npz"
    save_fit(path, made())
    whole = path.read_bytes()
    cuts = [whole[:length] for length in range(0, len(whole), 211)]
    flips = []
    for place in range(60, len(whole) // 2, 97):
        flipped = bytearray(whole)
        flipped[place] ^= 0xFF
        flips.append(bytes(flipped))
    refused: list[str] = []
    for content in cuts + flips:
        path.write_bytes(content)
        try:
            assert same(load_fit(path), made())  # a byte that says nothing, such as a date
        except RelightlabError as error:
            refused.append(str(error))
    assert all("is damaged, or no 'relightlab sirfs fit 1'" in sentence for sentence in refused)
    assert len(refused) > 0.9 * len(cuts + flips)


def test_other_files_are_told(tmp_path: Path) -> None:
    """No file, a folder, another archive or format, maps of several sizes: a sentence each."""
    with pytest.raises(RelightlabError, match="no such file"):
        load_fit(tmp_path / "none.npz")
    with pytest.raises(RelightlabError, match="cannot read"):
        load_fit(tmp_path)
    np.savez(tmp_path / "b.npz", height=np.zeros(3))
    with pytest.raises(RelightlabError, match="is damaged, or no"):
        load_fit(tmp_path / "b.npz")
    with pytest.raises(RelightlabError, match=r"to end in \.npz"):
        save_fit(tmp_path / "a.zip", made())
    save_fit(tmp_path / "c.npz", replace(made(), height=np.zeros((2, 2))))
    with pytest.raises(RelightlabError, match="several sizes"):
        load_fit(tmp_path / "c.npz")
    save_fit(tmp_path / "d.npz", made())
    with np.load(tmp_path / "d.npz") as stored:
        changed = {**stored, "format": np.asarray("relightlab sirfs fit 0")}
    np.savez(tmp_path / "d.npz", **changed)
    with pytest.raises(RelightlabError, match="its format is relightlab sirfs fit 0"):
        load_fit(tmp_path / "d.npz")
