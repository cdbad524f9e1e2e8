"""Learning all priors: the same from the same files, and those that are shipped."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evaluation.sirfs import absolute_color, training_data
from evaluation.sirfs.prior_files import save_priors, shipped_priors
from evaluation.sirfs.prior_training import STEPS, train_priors
from evaluation.sirfs.priors import arrays_of, priors_identity
from shading_model.errors import RelightlabError
from tests.evaluation.sirfs.small_priors import write_training_set


def test_trained_twice_gives_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the same files, whatever was drawn before; and every step is reported."""
    monkeypatch.setattr(absolute_color, "_STAGES", ((12, 40), (23, 20)))
    monkeypatch.setattr(training_data, "SAMPLES", 500)
    write_training_set(tmp_path / "set")
    reports: list[tuple[int, int, str]] = []
    for name in ("one.npz", "other.npz"):
        priors = train_priors(tmp_path / "set", lambda *report: reports.append(report))
        save_priors(tmp_path / name, priors)
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "other.npz").read_bytes()
    assert [done for done, _, _ in reports] == [*range(1, STEPS + 1)] * 2
    assert priors.color_absolute.shape == (23, 23, 23)
    assert len(priors.lights) == 4
    assert all(np.isfinite(values).all() for values in arrays_of(priors).values())


def test_a_missing_file_is_one_sentence(tmp_path: Path) -> None:
    """Nothing is learned from half a set."""
    write_training_set(tmp_path)
    (tmp_path / "natural_lights.mat").unlink()
    with pytest.raises(RelightlabError, match=r"no such file: .*natural_lights\.mat"):
        train_priors(tmp_path)


@pytest.mark.real_data
@pytest.mark.slow
def test_shipped_priors_are_learned_from_the_set(mit_berkeley_root: Path) -> None:
    """Learned again, they are those shipped: to the bit on like machines, nearly on others."""
    learned, shipped = train_priors(mit_berkeley_root), shipped_priors()
    if priors_identity(learned) == priors_identity(shipped):
        return
    ours, theirs = arrays_of(learned), arrays_of(shipped)
    assert list(ours) == list(theirs)
    for name in ours:
        if name == "color_absolute":
            common = theirs[name] < 8
            assert np.abs(ours[name] - theirs[name])[common].mean() < 0.05
        else:
            assert np.allclose(ours[name], theirs[name], rtol=1e-3, atol=1e-3)
