"""Fitting SIRFS: what comes out, what is known stays, and what cannot be fitted is told."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from evaluation.sirfs.fit import FitOptions, fit_sirfs, fit_sirfs_stereo
from evaluation.sirfs.prior_files import shipped_priors
from shading_model.arrays import Image, Mask
from shading_model.errors import RelightlabError
from shading_model.height_field import normals_of_slopes, slopes
from shading_model.illumination import LogHarmonics

SHORT = FitOptions(evaluations=(60,))
LEFT = LogHarmonics(np.array([-0.9, 0.2, 0.5, -0.6, 0, 0, 0.1, 0, 0]))
RIGHT = LogHarmonics(np.array([-0.9, 0.2, 0.5, 0.6, 0, 0, 0.1, 0, 0]))


def dome(side: int = 61, radius: float = 22.0) -> tuple[np.ndarray, Mask]:
    """A dome in the middle of a picture: its height and its mask."""
    y, x = np.mgrid[:side, :side] - side // 2
    away = np.hypot(x, y)
    height = np.sqrt(np.maximum(radius**2 - away**2, 0.0)) * 0.7
    return height, away < radius - 1


def lit_dome(light: LogHarmonics = LEFT) -> tuple[Image, Mask]:
    """A photograph of the dome with two paints, under a light from the left."""
    height, mask = dome()
    shading = light.shade(normals_of_slopes(*slopes(height)))
    paint = np.where(np.arange(61)[:, None, None] > 30, [0.6, 0.4, 0.3], [0.3, 0.4, 0.5])
    return paint * shading[..., None] * np.ones((61, 61, 1)), mask


def test_photograph_is_albedo_times_shading() -> None:
    """Albedo times shading is the photograph, and all maps are NaN outside the mask."""
    image, mask = lit_dome()
    fit = fit_sirfs(image, mask, shipped_priors(), SHORT)
    np.testing.assert_allclose((fit.albedo * fit.shading)[mask], image[mask], rtol=1e-10)
    for values in (fit.height, fit.normals, fit.albedo, fit.shading):
        assert np.isfinite(values[mask]).all()
        assert np.isnan(values[~mask]).all()
    assert fit.final_loss == pytest.approx(sum(fit.terms.values()))


def test_shading_is_that_of_normals_under_the_light() -> None:
    """The shading is what the fitted light makes of the fitted normals."""
    image, mask = lit_dome()
    fit = fit_sirfs(image, mask, shipped_priors(), SHORT)
    np.testing.assert_allclose(
        fit.illumination.shade(fit.normals)[mask], fit.shading[mask], rtol=1e-9
    )


@pytest.mark.parametrize("channels", ["gray", "color"])
def test_a_dome_comes_out_as_a_dome(channels: str) -> None:
    """A dome under a known kind of light is found: it bulges, and its light comes from its side."""
    image, mask = lit_dome()
    options = FitOptions(channels=channels, evaluations=(300,))
    fit = fit_sirfs(image, mask, shipped_priors(), options)
    height = dome()[0]
    assert np.corrcoef(fit.height[mask], height[mask])[0, 1] > 0.9
    from_left = fit.illumination.coefficients[3]
    assert np.all(from_left < 0)


def test_loss_falls_with_more_evaluations() -> None:
    """More evaluations never end higher, and are counted."""
    image, mask = lit_dome()
    losses = []
    for most in (10, 40, 160):
        fit = fit_sirfs(image, mask, shipped_priors(), replace(SHORT, evaluations=(most,)))
        losses.append(fit.final_loss)
        assert fit.evaluations <= most
    assert losses[0] > losses[1] > losses[2]


def test_coarse_to_fine_comes_as_low() -> None:
    """Descending at half the resolution first comes about as low in less work."""
    image, mask = (np.kron(a, np.ones((2, 2, 1) if a.ndim == 3 else (2, 2))) for a in lit_dome())
    whole = fit_sirfs(image, mask > 0, shipped_priors(), replace(SHORT, evaluations=(300,)))
    staged = fit_sirfs(image, mask > 0, shipped_priors(), replace(SHORT, evaluations=(100, 100)))
    assert staged.evaluations <= 125
    assert staged.final_loss < 1.03 * whole.final_loss


def test_known_height_stays() -> None:
    """With a known shape only the light is fitted, and well."""
    image, mask = lit_dome()
    height = np.where(mask, dome()[0], np.nan)
    options = replace(SHORT, known_height=height, without=("contour", "slant", "curvature"))
    fit = fit_sirfs(image, mask, shipped_priors(), options)
    np.testing.assert_array_equal(fit.height[mask], height[mask])


def test_known_light_stays() -> None:
    """With a known light only the shape is fitted."""
    image, mask = lit_dome()
    fit = fit_sirfs(image, mask, shipped_priors(), replace(SHORT, known_light=LEFT))
    expected = np.repeat(LEFT.coefficients[:, None], 3, axis=1)
    np.testing.assert_allclose(fit.illumination.coefficients, expected, atol=1e-9)


def test_depth_draws_the_shape() -> None:
    """An external depth map makes the shape come nearer to it, holes or not."""
    image, mask = lit_dome()
    height = dome()[0]
    depth = np.where(mask & (np.arange(61) % 3 > 0), height, np.nan)
    alone = fit_sirfs(image, mask, shipped_priors(), SHORT)
    drawn = fit_sirfs(image, mask, shipped_priors(), replace(SHORT, depth=depth, depth_blur=1.0))

    def away(fitted: np.ndarray) -> float:
        return float(np.abs(fitted - height)[mask].mean())

    assert away(drawn.height) < 0.5 * away(alone.height)


def test_terms_left_out_are_zero() -> None:
    """A term that is left out costs nothing, and the others remain."""
    image, mask = lit_dome()
    options = replace(SHORT, without=("albedo_entropy", "slant"), evaluations=(10,))
    fit = fit_sirfs(image, mask, shipped_priors(), options)
    assert fit.terms["albedo_entropy"] == fit.terms["slant"] == 0.0
    assert fit.terms["albedo_smoothness"] > 0


def test_stereo_shares_one_shape() -> None:
    """Photographs under two lights share a shape and have each a light of their own side."""
    (first, mask), (second, _) = lit_dome(LEFT), lit_dome(RIGHT)
    options = replace(SHORT, evaluations=(200,))
    left, right = fit_sirfs_stereo((first, second), mask, shipped_priors(), options)
    np.testing.assert_array_equal(left.height, right.height)
    assert np.all(left.illumination.coefficients[3] < 0)
    assert np.all(right.illumination.coefficients[3] > 0)
    np.testing.assert_allclose((right.albedo * right.shading)[mask], second[mask], rtol=1e-10)


def test_same_bytes_twice() -> None:
    """The same photograph gives the same bytes again."""
    image, mask = lit_dome()
    first, second = (fit_sirfs(image, mask, shipped_priors(), SHORT) for _ in range(2))
    assert first.height.tobytes() == second.height.tobytes()
    assert first.albedo.tobytes() == second.albedo.tobytes()
    assert first.final_loss == second.final_loss


@pytest.mark.slow
def test_same_bytes_with_one_or_two_threads() -> None:
    """The number of threads of the linear algebra changes no byte of a fit."""
    program = (
        "import hashlib\n"
        "from evaluation.sirfs.fit import fit_sirfs\n"
        "from evaluation.sirfs.prior_files import shipped_priors\n"
        "from tests.evaluation.sirfs.test_fit import SHORT, lit_dome\n"
        "fit = fit_sirfs(*lit_dome(), shipped_priors(), SHORT)\n"
        "print(hashlib.sha256(fit.height.tobytes() + fit.albedo.tobytes()).hexdigest())"
    )
    found = []
    for threads in ("1", "2"):
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": threads, "NUMBA_NUM_THREADS": threads}
        command = [sys.executable, "-c", program]
        done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
        found.append(done.stdout)
    assert found[0] == found[1]


def test_what_lies_outside_the_mask_plays_no_part() -> None:
    """Anything may stand outside the mask, NaN too."""
    image, mask = lit_dome()
    other = np.where(mask[..., None], image, np.nan)
    options = replace(SHORT, evaluations=(20,))
    first, second = (fit_sirfs(i, mask, shipped_priors(), options) for i in (image, other))
    np.testing.assert_array_equal(first.height, second.height)


def test_zeros_inside_the_mask_are_left_out() -> None:
    """Pixels without light have no logarithm: they are not explained, and the rest is."""
    image, mask = lit_dome()
    image[25:28, 25:28] = 0.0
    fit = fit_sirfs(image, mask, shipped_priors(), replace(SHORT, evaluations=(30,)))
    assert not fit.mask[26, 26]
    assert np.isnan(fit.albedo[26, 26]).all()
    assert np.isfinite(fit.albedo[fit.mask]).all()


@pytest.mark.parametrize("value", [0.5, 1.0])
def test_constant_photographs_are_fitted(value: float) -> None:
    """A photograph of one value, or saturated all over, has a finite fit."""
    mask = lit_dome()[1]
    image = np.full((61, 61, 3), value)
    fit = fit_sirfs(image, mask, shipped_priors(), replace(SHORT, evaluations=(30,)))
    assert np.isfinite(fit.final_loss)
    assert np.isfinite(fit.height[mask]).all()


def test_an_object_that_fills_the_picture() -> None:
    """An object without background on any side is fitted."""
    image = lit_dome()[0] + 0.01
    mask = np.ones((61, 61), bool)
    fit = fit_sirfs(image, mask, shipped_priors(), replace(SHORT, evaluations=(30,)))
    assert np.isfinite(fit.height).all()


def few_pixels(mask: Mask) -> Mask:
    """A mask of nine pixels."""
    few = np.zeros_like(mask)
    few[30:33, 30:33] = True
    return few


def with_pixel(image: Image, value: float) -> Image:
    """A photograph with one odd pixel."""
    odd = image.copy()
    odd[30, 30] = value
    return odd


FAULTS = {
    "few pixels": lambda image, mask: (image, few_pixels(mask), SHORT),
    "black": lambda image, mask: (np.zeros_like(image), mask, SHORT),
    "NaN": lambda image, mask: (with_pixel(image, np.nan), mask, SHORT),
    "negative": lambda image, mask: (with_pixel(image, -1.0), mask, SHORT),
    "empty": lambda image, mask: (image, np.zeros_like(mask), SHORT),
    "size": lambda image, mask: (image, mask[1:], SHORT),
    "light": lambda image, mask: (image, mask, replace(SHORT, light="laboratry")),
    "depth": lambda image, mask: (image, mask, replace(SHORT, depth=np.full(mask.shape, np.nan))),
    "depth size": lambda image, mask: (image, mask, replace(SHORT, depth=np.zeros((3, 3)))),
}


@pytest.mark.parametrize(
    ("fault", "sentence"),
    [
        ("few pixels", "expected at least 64 pixels above zero on the object, got 9"),
        ("black", "black all over the mask"),
        ("NaN", "1 NaN or infinite pixels"),
        ("negative", "1 negative pixels"),
        ("empty", "the mask is empty"),
        ("size", "its mask is 61x60"),
        ("light", "Did you mean 'laboratory'"),
        ("depth", "known nowhere"),
        ("depth size", "expected depths of shape"),
    ],
)
def test_what_cannot_be_fitted_is_told(fault: str, sentence: str) -> None:
    """Each fault of the input is one sentence."""
    image, mask, options = FAULTS[fault](*lit_dome())
    with pytest.raises(RelightlabError, match=sentence):
        fit_sirfs(image, mask, shipped_priors(), options)


def test_no_photograph_is_told() -> None:
    """SIRFS-stereo of nothing is refused."""
    with pytest.raises(RelightlabError, match="at least one photograph"):
        fit_sirfs_stereo((), np.ones((9, 9), bool), shipped_priors())


def test_a_loss_that_is_not_finite_is_told() -> None:
    """A fit that diverges says so instead of giving numbers."""
    image, mask = lit_dome()
    light = LogHarmonics(np.full(9, 1e200))
    with pytest.raises(RelightlabError, match="diverged"):
        fit_sirfs(image, mask, shipped_priors(), replace(SHORT, known_light=light))


def test_progress_tells_loss_and_work() -> None:
    """Progress rises to no more than the limit, and its loss falls."""
    image, mask = lit_dome()
    seen: list[tuple[float, float, float]] = []
    fit_sirfs(image, mask, shipped_priors(), SHORT, progress=lambda *state: seen.append(state))
    done = [state[0] for state in seen]
    assert done == sorted(done)
    assert done[-1] <= seen[0][1] == 60
    assert seen[-1][2] < seen[0][2]
