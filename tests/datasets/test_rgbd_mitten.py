"""The depth-sensor set: a miniature of its layout, and the measured one where it is present."""

from __future__ import annotations

import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.ndimage import binary_erosion

from datasets.locations import find_root_of
from datasets.records import Dataset
from datasets.rgbd_mitten import RgbdMitten
from shading_model.arrays import Map, Mask
from shading_model.errors import RelightlabError

ROWS, COLUMNS = 48, 40
FARTHEST = 9870
CALIBRATION = "60.0,0,40\n0,60.0,30\n0,0,1\n2,0,9870"
WINDOW = "rows 10:58 cols 20:60 of the 96x80 RGB frames"


def dome() -> tuple[Map, Mask]:
    """Depth in millimetres of a dome at half a metre, at the pictures' resolution, and its mask."""
    rows, columns = np.mgrid[:ROWS, :COLUMNS].astype(np.float64)
    squared = ((rows - 23.5) / 20) ** 2 + ((columns - 19.5) / 17) ** 2
    return 560 - 60 * np.maximum(0, 1 - squared), squared < 0.95


def readings_and_mask() -> tuple[Map, Mask]:
    """The dome as the sensor sees it, each reading over two by two pixels, and its mask."""
    depth, mask = dome()
    return depth.reshape(ROWS // 2, 2, COLUMNS // 2, 2).mean(axis=(1, 3)), mask


def write_set(root: Path) -> Path:
    """Twenty pictures of a checked cloth, brighter on one side or the other, and readings."""
    root.mkdir()
    depth, mask = readings_and_mask()
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    albedo = np.where((rows // 4 + columns // 4) % 2, 0.5, 0.3)[..., None] * [1, 0.8, 0.6]
    cv2.imwrite(str(root / "mask.png"), 255 * mask.astype(np.uint8))
    for k in range(1, 21):
        shading = np.exp((k - 10.5) / 20 * (columns - 19.5) / 20)[..., None]
        levels = np.round(255 * albedo * shading).astype(np.uint8)
        cv2.imwrite(str(root / f"rgb_{k:02d}.png"), levels)
        readings = depth / FARTHEST * 65535
        readings[k % 7 :: 7, 3::5] = 0
        cv2.imwrite(str(root / f"depth_{k:02d}.png"), np.round(readings).astype(np.uint16))
    (root / "K.txt").write_text(CALIBRATION)
    (root / "crop.txt").write_text(WINDOW)
    return root


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> RgbdMitten:
    """A miniature of the set, written once for this module."""
    return RgbdMitten(write_set(tmp_path_factory.mktemp("mitten") / "rgbd-mitten"))


@pytest.fixture
def copied(made: RgbdMitten, tmp_path: Path) -> RgbdMitten:
    """A copy that a test may damage."""
    shutil.copytree(made.root, tmp_path / "rgbd-mitten")
    return RgbdMitten(tmp_path / "rgbd-mitten")


@pytest.fixture(scope="session")
def measured() -> RgbdMitten:
    """The measured set; skips where there is none."""
    root = find_root_of("rgbd-mitten")
    if root is None:
        pytest.skip("rgbd-mitten was not found")
    return RgbdMitten(root / "rgbd-mitten")


def test_a_capture_is_the_mean_and_no_truth(made: RgbdMitten) -> None:
    """The mean of the linear pictures; every part of the truth is unknown."""
    dataset: Dataset = made
    capture = dataset.load("mitten", "laboratory")
    lit = dataset.lit_photographs("mitten")
    mean = np.mean([item.photograph.image for item in lit], axis=0)
    assert np.allclose(capture.photograph.image, mean)
    assert len(lit) == 20
    assert all(value is None for value in vars(capture.truth).values())


def test_readings_are_millimetres(made: RgbdMitten) -> None:
    """At half the resolution of the pictures, zero where there is none."""
    frames = made.depth_frames()
    depth = readings_and_mask()[0]
    assert frames.shape == (20, ROWS // 2, COLUMNS // 2)
    read = frames > 0
    assert 0.02 < 1 - read.mean() < 0.05
    assert np.abs(frames - depth)[read].max() <= FARTHEST / 65535


def test_the_sensor_shape_is_the_dome(made: RgbdMitten) -> None:
    """Nearest in the middle, falling to both sides as the depth rises, known on the mask."""
    shape = made.sensor_shape()
    depth, mask = dome()
    assert np.isfinite(shape.height[mask]).all()
    inner = binary_erosion(mask, iterations=6)
    expected = -depth * 60 / np.median(depth[mask])
    assert np.corrcoef(shape.height[inner], expected[inner])[0, 1] > 0.99
    assert shape.normals[24, 8, 0] < -0.1 < 0.1 < shape.normals[24, 31, 0]


def test_lights_are_told_from_the_object(made: RgbdMitten) -> None:
    """A picture brighter on the right gets a light from the right, though the cloth is checked."""
    lights = [item.illumination for item in made.lit_photographs("mitten")]
    right, left = np.array([0.5, 0, 0.75**0.5]), np.array([-0.5, 0, 0.75**0.5])
    ratios = [float((light.shade(right) / light.shade(left)).mean()) for light in lights]
    assert (np.diff(ratios) > 0).all()
    assert ratios[0] < 0.9
    assert ratios[-1] > 1.1
    for fit in (made.relative_lights()[0], made.relative_lights()[-1]):
        assert fit.residual < 0.7 * fit.unlit_residual


def test_saturated_samples_are_told(copied: RgbdMitten) -> None:
    """And the light of their picture comes from the others."""
    before = copied.relative_lights()[4].illumination.coefficients
    picture = cv2.imread(str(copied.root / "rgb_05.png"))
    assert picture is not None
    picture[20:24, 16:20] = 255
    cv2.imwrite(str(copied.root / "rgb_05.png"), picture)
    saturated = copied.saturated()
    assert saturated[4, 20:24, 16:20].all()
    assert saturated.sum() == 16
    after = copied.relative_lights()[4].illumination.coefficients
    assert np.abs(after - before).max() < 0.05


def test_the_camera_is_that_of_the_cut_picture(made: RgbdMitten) -> None:
    """The principal point moves by the corner of the window."""
    assert made.intrinsics().tolist() == [[60, 0, 20], [0, 60, 20], [0, 0, 1]]


def test_the_fingerprint_follows_the_content(copied: RgbdMitten, made: RgbdMitten) -> None:
    """A copy has the same, the uncut frame plays no part, a changed calibration does."""
    shutil.copy(copied.root / "rgb_01.png", copied.root / "full_frame_rgb_01.png")
    assert copied.fingerprint() == made.fingerprint()
    (copied.root / "K.txt").write_text(CALIBRATION.replace("9870", "9871"))
    assert copied.fingerprint() != made.fingerprint()


def test_the_set_is_found_in_a_data_root(copied: RgbdMitten) -> None:
    """By the name of its folder."""
    assert find_root_of("rgbd-mitten", copied.root.parent) == copied.root.parent


def test_files_that_do_not_match_in_number_are_refused(copied: RgbdMitten) -> None:
    """A picture or a frame less than there are lights."""
    (copied.root / "depth_20.png").unlink()
    with pytest.raises(RelightlabError, match="holds 19 depth frames, expected 20"):
        copied.lit_photographs("mitten")
    (copied.root / "rgb_20.png").unlink()
    with pytest.raises(RelightlabError, match=r"there are 19 pictures beside .* but 20 lights"):
        copied.load("mitten", "laboratory")


def test_readings_of_another_size_are_refused(copied: RgbdMitten) -> None:
    """One frame unlike the others, or all unlike the pictures."""
    cv2.imwrite(str(copied.root / "depth_07.png"), np.full((9, 9), 4000, np.uint16))
    with pytest.raises(RelightlabError, match=r"not all of one \(h, w\)"):
        copied.depth_frames()
    for k in range(1, 21):
        frame = np.full((9, 9), 4000, np.uint16)
        cv2.imwrite(str(copied.root / f"depth_{k:02d}.png"), frame)
    with pytest.raises(RelightlabError, match="not one window in two resolutions"):
        copied.sensor_shape()


def test_eight_bit_readings_are_refused(copied: RgbdMitten) -> None:
    """They would be a depth in steps of forty millimetres."""
    cv2.imwrite(str(copied.root / "depth_01.png"), np.full((24, 20), 9, np.uint8))
    with pytest.raises(RelightlabError, match="expected a 16-bit PNG, got 8-bit"):
        copied.depth_frames()


@pytest.mark.parametrize(
    ("file", "text", "words"),
    [
        ("K.txt", None, "cannot read"),
        ("K.txt", "a,b,c", "cannot read"),
        ("K.txt", "1,0,0\n0,1,0\n0,0,1", "three rows of the camera matrix, then"),
        ("K.txt", CALIBRATION.replace("9870", "0"), "three rows of the camera matrix, then"),
        ("crop.txt", None, "cannot read"),
        ("crop.txt", "118 758", "not as expected: 'rows"),
    ],
)
def test_a_damaged_calibration_is_one_sentence(
    copied: RgbdMitten, file: str, text: str | None, words: str
) -> None:
    """Missing, not numbers, not the numbers expected."""
    (copied.root / file).unlink()
    if text is not None:
        (copied.root / file).write_text(text)
    with pytest.raises(RelightlabError, match=words):
        copied.intrinsics()


def test_unknown_names_are_suggested(made: RgbdMitten) -> None:
    """Object and setting."""
    with pytest.raises(RelightlabError, match=r"Unknown object 'mitt'\. Did you mean 'mitten'"):
        made.load("mitt", "laboratory")
    with pytest.raises(RelightlabError, match="Unknown object 'glove'"):
        made.lit_photographs("glove")
    with pytest.raises(RelightlabError, match="Unknown object 'cat'"):
        made.sensor_shape("cat")
    with pytest.raises(RelightlabError, match="Unknown setting 'natural'"):
        made.load("mitten", "natural")


@pytest.mark.slow
@pytest.mark.real_data
def test_the_measured_set_is_as_described(measured: RgbdMitten) -> None:
    """Pixels and readings as counted before; lights explain a fifth of what there is to explain.

    Measured: residuals of 0.04 to 0.27, mean 0.149, where the mean picture times one number leaves
    0.188.
    """
    capture = measured.load("mitten", "laboratory")
    mask, frames = capture.photograph.mask, measured.depth_frames()
    assert mask.sum() == 148600
    assert capture.photograph.image.shape == (640, 482, 3)
    assert frames.shape == (20, 320, 241)
    assert abs(np.median(frames[frames > 0]) - 546) < 60
    assert measured.intrinsics()[:2, 2].tolist() == [639.5 - 366, 479.5 - 118]
    fits = measured.relative_lights()
    assert len(fits) == 20
    assert all(fit.residual < fit.unlit_residual for fit in fits)
    assert np.mean([fit.residual for fit in fits]) < 0.16
    assert np.isfinite(measured.sensor_shape().height[mask]).all()
