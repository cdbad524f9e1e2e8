"""The photometric-stereo set: a miniature of its layout, and the measured one where present."""

from __future__ import annotations

import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from datasets.locations import find_root_of
from datasets.psm_uw import LIGHTS, OBJECTS, PROBES, PsmUw
from datasets.records import Dataset
from shading_model.arrays import Float, Mask, Normals
from shading_model.diffuse_probe import fit_diffuse_probe
from shading_model.errors import RelightlabError
from shading_model.harmonic_conversion import visible_normals
from shading_model.probe_sphere import fit_sphere

SIDE = 64
TURNS = np.linspace(0, 2 * np.pi, 12, endpoint=False)
DIRECTIONS = np.column_stack([0.4 * np.cos(TURNS), 0.4 * np.sin(TURNS), np.full(12, 0.84**0.5)])


def ball(reach: float) -> tuple[Normals, Mask]:
    """A ball of radius `reach` of half the picture's width, and its mask."""
    rows, columns = (np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2) / (reach * SIDE / 2)
    squared = rows**2 + columns**2
    upright = np.sqrt(np.maximum(0, 1 - squared))
    return np.stack([columns, -rows, upright], axis=-1), squared < 1


def write_set(root: Path) -> Path:
    """All objects and spheres as matt balls, 12 linear pictures each."""
    for name in (*OBJECTS, *PROBES):
        (root / name).mkdir(parents=True)
        normals, mask = ball(0.7)
        cv2.imwrite(str(root / name / f"{name}.mask.png"), 255 * mask.astype(np.uint8))
        for k, direction in enumerate(DIRECTIONS):
            shading = np.where(mask, np.maximum(0.02, normals @ direction), 0)
            blue_to_red = shading[..., None] * [0.3, 0.5, 0.8]
            levels = np.round(255 * blue_to_red).astype(np.uint8)
            cv2.imwrite(str(root / name / f"{name}.{k}.png"), levels)
    write_lights(root, DIRECTIONS)
    return root


def write_lights(root: Path, directions: Float, count: int | None = None) -> None:
    """The list of lights as the set has it."""
    rows = [" ".join(f"{value:.8f}" for value in direction) for direction in directions]
    first = len(directions) if count is None else count
    (root / LIGHTS).write_text("\n".join([str(first), *rows]))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> PsmUw:
    """A miniature of the set, written once for this module."""
    return PsmUw(write_set(tmp_path_factory.mktemp("psm") / "psm-uw"))


@pytest.fixture
def copied(made: PsmUw, tmp_path: Path) -> PsmUw:
    """A copy that a test may damage."""
    shutil.copytree(made.root, tmp_path / "psm-uw")
    return PsmUw(tmp_path / "psm-uw")


@pytest.fixture(scope="session")
def measured() -> PsmUw:
    """The measured set; skips where there is none."""
    root = find_root_of("psm-uw")
    if root is None:
        pytest.skip("psm-uw was not found")
    return PsmUw(root / "psm-uw")


def test_a_capture_is_the_mean_and_a_reference(made: PsmUw) -> None:
    """The mean of the pictures, and the ball's own shape; nothing else is claimed."""
    dataset: Dataset = made
    capture = dataset.load("cat", "laboratory")
    lit = dataset.lit_photographs("cat")
    mask = capture.photograph.mask
    mean = np.mean([item.photograph.image for item in lit], axis=0)
    assert np.allclose(capture.photograph.image, mean)
    assert mask.shape == (60, 60)  # a ball of 44 pixels and 8 on each side
    truth = capture.truth
    assert truth.albedo is truth.shading is truth.illumination is None
    assert truth.normals is not None
    assert truth.height is not None
    normals = fit_sphere(mask).normals((60, 60))
    inner = fit_sphere(mask).inner_pixels(mask, 0.1)
    assert np.nanmin(np.einsum("ni,ni->n", normals[inner], truth.normals[inner])) > np.cos(0.03)
    error = (truth.height - 22 * normals[..., 2])[inner]
    assert np.nanstd(error) < 0.3
    assert np.isnan(truth.height[~mask]).all()


def test_pictures_come_with_the_light_of_the_gray_sphere(made: PsmUw) -> None:
    """In the order of the lights, of one mask, each shaded as its sphere is."""
    lit = made.lit_photographs("owl")
    normals = visible_normals()
    normals = normals[normals[:, 2] > 0.4]
    assert len(lit) == 12
    for item, direction in zip(lit, DIRECTIONS, strict=True):
        assert item.illumination.coefficients.shape == (9, 3)
        expected = np.maximum(0.02, normals @ direction)[:, None] * [0.8, 0.5, 0.3]
        error = item.illumination.shade(normals) - expected
        assert np.sqrt(np.mean(error**2) / np.mean(expected**2)) < 0.05
        assert (item.photograph.mask == lit[0].photograph.mask).all()
    assert lit[10].photograph.source == "psm-uw/owl/owl.10.png"


def test_linear_lights_are_those_of_the_same_spheres(made: PsmUw) -> None:
    """Nine linear harmonics; where the sphere is lit they shade as the log ones do."""
    normals = visible_normals()
    normals = normals[normals[:, 2] > 0.6]
    for log, linear in zip(made.log_lights(), made.linear_lights(), strict=True):
        assert np.allclose(log.shade(normals), linear.shade(normals), atol=0.06)


def test_probes_keep_their_outline(made: PsmUw) -> None:
    """A sphere's pictures have a margin, so that its circle is seen whole."""
    for probe in PROBES:
        photographs = made.probe_photographs(probe)
        assert len(photographs) == 12
        assert not fit_sphere(photographs[0].mask).is_cut


def test_the_fingerprint_follows_the_content(copied: PsmUw, made: PsmUw) -> None:
    """A copy has the same, a note beside the set changes nothing, another light does."""
    (copied.root / "SOURCE.txt").write_text("a note")
    assert copied.fingerprint() == made.fingerprint()
    write_lights(copied.root, DIRECTIONS[::-1])
    assert copied.fingerprint() != made.fingerprint()


def test_the_set_is_found_in_a_data_root(copied: PsmUw) -> None:
    """By the name of its folder."""
    assert find_root_of("psm-uw", copied.root.parent) == copied.root.parent


def test_pictures_and_lights_have_to_match(copied: PsmUw) -> None:
    """One picture less, or one light less, and nothing is paired."""
    write_lights(copied.root, DIRECTIONS[:11])
    with pytest.raises(RelightlabError, match=r"there are 12 pictures beside .* but 11 lights"):
        copied.lit_photographs("cat")
    write_lights(copied.root, DIRECTIONS)
    (copied.root / "cat" / "cat.11.png").unlink()
    with pytest.raises(RelightlabError, match=r"there are 11 pictures beside .* but 12 lights"):
        copied.load("cat", "laboratory")
    (copied.root / "cat" / "cat.5.png").unlink()
    with pytest.raises(RelightlabError, match=r"lacks cat\.5\.png"):
        copied.load("cat", "laboratory")


def test_lights_in_one_plane_are_refused(copied: PsmUw) -> None:
    """They determine no normals."""
    angles = np.linspace(-0.5, 0.5, 12)
    plane = np.column_stack([np.sin(angles), np.zeros(12), np.cos(angles)])
    write_lights(copied.root, plane)
    with pytest.raises(RelightlabError, match="span 2 of 3 dimensions"):
        copied.load("cat", "laboratory")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "cannot read"),
        ("", "expected a number of lights, then x y z"),
        ("1\n0 0 one", "expected a number of lights"),
        ("1\n0 0 1 0", "expected a number of lights"),
        ("3\n0 0 1", "promises 3 lights but holds 1"),
        ("1\n0 0 2", "not of unit length"),
        ("1\n0 0 nan", "not of unit length"),
    ],
)
def test_damaged_lights_are_one_sentence(copied: PsmUw, text: str | None, words: str) -> None:
    """Missing, empty, not numbers, of another number, not unit vectors."""
    (copied.root / LIGHTS).unlink()
    if text is not None:
        (copied.root / LIGHTS).write_text(text)
    with pytest.raises(RelightlabError, match=words):
        copied.light_directions()


def test_a_saturated_sphere_is_refused(copied: PsmUw) -> None:
    """It tells no light."""
    white = np.full((SIDE, SIDE, 3), 255, np.uint8)
    cv2.imwrite(str(copied.root / "gray" / "gray.3.png"), white)
    with pytest.raises(RelightlabError, match="saturated"):
        copied.lit_photographs("cat")


def test_unknown_names_are_suggested(made: PsmUw) -> None:
    """Objects, settings and spheres."""
    with pytest.raises(RelightlabError, match=r"Unknown object 'cta'\. Did you mean 'cat'"):
        made.load("cta", "laboratory")
    with pytest.raises(RelightlabError, match="Unknown object 'gray'"):
        made.lit_photographs("gray")
    with pytest.raises(RelightlabError, match="Unknown object 'hoarse'"):
        made.photometric_stereo("hoarse")
    with pytest.raises(RelightlabError, match="Unknown setting 'natural'"):
        made.load("cat", "natural")
    with pytest.raises(RelightlabError, match=r"Unknown light probe 'grey'\. Did you mean 'gray'"):
        made.probe_photographs("grey")


@pytest.mark.real_data
def test_directions_are_in_the_projects_axes(measured: PsmUw) -> None:
    """The distant light regressed on the gray sphere is the given one: 1.0 to 7.1 degrees off.

    On average 3.2 degrees as the axes are, but 20, 41 and 47 with x, y or both turned.
    """
    probes = measured.probe_photographs("gray")
    given = measured.light_directions()
    fits = [fit_diffuse_probe(probe.image, probe.mask).distant for probe in probes]
    found = np.array([fit.direction for fit in fits if fit is not None])
    means = {
        signs: np.degrees(np.arccos(np.sum(found * given * [*signs, 1], axis=1))).mean()
        for signs in ((1, 1), (-1, 1), (1, -1), (-1, -1))
    }
    assert min(means, key=lambda signs: means[signs]) == (1, 1)
    assert means[1, 1] < 4
    assert sorted(means.values())[1] > 15


@pytest.mark.real_data
def test_photometric_stereo_finds_the_gray_sphere(measured: PsmUw) -> None:
    """Its normals are 4.3 degrees off the sphere's on average (3.7 in the median)."""
    stereo = measured.photometric_stereo("gray")
    mask = measured.probe_photographs("gray")[0].mask
    sphere = fit_sphere(mask)
    inner = sphere.inner_pixels(mask) & np.isfinite(stereo.normals).all(axis=-1)
    normals = sphere.normals((mask.shape[0], mask.shape[1]))
    cosine = np.einsum("ni,ni->n", normals[inner], stereo.normals[inner])
    angle = np.degrees(np.arccos(np.minimum(cosine, 1)))
    assert angle.mean() < 4.6
    assert np.median(angle) < 3.9
    assert stereo.residual < 0.035


@pytest.mark.real_data
@pytest.mark.parametrize(("name", "pixels"), [("cat", 36526), ("horse", 30243), ("owl", 47115)])
def test_measured_objects_have_shapes_and_lights(measured: PsmUw, name: str, pixels: int) -> None:
    """All pixels of the mask, a reference on 99 % of them, and lights that explain the pictures."""
    capture = measured.load(name, "laboratory")
    lit = measured.lit_photographs(name)
    mask, normals = capture.photograph.mask, capture.truth.normals
    assert mask.sum() == pixels
    assert normals is not None
    known = np.isfinite(normals).all(axis=-1)
    assert known[mask].mean() > 0.99
    assert capture.truth.height is not None
    assert np.isfinite(capture.truth.height[mask]).all()
    shading = np.stack([item.illumination.shade(normals) for item in lit])[:, known]
    images = np.stack([item.photograph.image for item in lit])[:, known]
    albedo = (shading * images).sum(axis=0) / (shading**2).sum(axis=0)
    residual = np.sqrt(np.mean((albedo * shading - images) ** 2) / np.mean(images**2))
    assert residual < 0.12
