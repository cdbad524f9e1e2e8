"""Learning all priors: the same from the same files, and those that are shipped."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from evaluation.sirfs import absolute_color, prior_training, training_data
from evaluation.sirfs.absolute_color import COLOR_SMOOTHNESS, _solve, trilinear_splat
from evaluation.sirfs.prior_files import save_priors, shipped_priors
from evaluation.sirfs.prior_training import STEPS, train_priors
from evaluation.sirfs.priors import arrays_of
from shading_model.arrays import Float
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
def test_shipped_priors_are_learned_from_the_set(
    mit_berkeley_root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Learned again they are those shipped; of the cost of a colour, descent finds no better."""
    shipped, histograms = shipped_priors(), []

    def not_again(whitened: Float) -> Float:
        histograms.append(trilinear_splat(whitened))
        return shipped.color_absolute

    monkeypatch.setattr(prior_training, "fit_color_absolute", not_again)
    ours, theirs = arrays_of(train_priors(mit_berkeley_root)), arrays_of(shipped)
    assert list(ours) == list(theirs)
    for name in ours:
        assert np.allclose(ours[name], theirs[name], rtol=1e-6, atol=1e-6), name
    cost = shipped.color_absolute
    found = _solve(cost, histograms[0], COLOR_SMOOTHNESS, 40)
    assert np.abs((found - found.min() - cost)[cost < 8]).mean() < 0.01
