"""The MIT-Berkeley set: a miniature of its layout, and the measured one where it is present."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat
from scipy.ndimage import binary_erosion

from datasets.mit_axes import harmonics_from_mit_axes, normals_from_mit_axes
from datasets.mit_berkeley import (
    OBJECTS,
    TEST_OBJECTS,
    TRAINING_OBJECTS,
    MitBerkeley,
    load_mat,
)
from datasets.records import Dataset
from shading_model.errors import RelightlabError
from shading_model.illumination import harmonics
from tests.datasets.mit_miniature import CROP, SHAPE, Miniature, mit_normals, write_miniature

STEP = 1 / 65535


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Miniature:
    """The files of one object, written once for this module."""
    return write_miniature(tmp_path_factory.mktemp("mit"))


@pytest.fixture
def copied(made: Miniature, tmp_path: Path) -> MitBerkeley:
    """A copy of the miniature that a test may damage."""
    shutil.copytree(made.root, tmp_path / "set")
    return MitBerkeley(tmp_path / "set")


def test_training_and_test_objects_are_all_objects() -> None:
    """Ten and ten, none in both."""
    assert len(TRAINING_OBJECTS) == len(TEST_OBJECTS) == 10
    assert set(OBJECTS) == {*TRAINING_OBJECTS, *TEST_OBJECTS}
    assert len(OBJECTS) == 20


@pytest.mark.parametrize("setting", ["natural", "laboratory"])
def test_photographs_keep_sixteen_bits(made: Miniature, setting: str) -> None:
    """The picture is what was written, cropped, to half a step of 1/65535."""
    dataset: Dataset = MitBerkeley(made.root)
    photograph = dataset.load("apple", setting).photograph
    shading = made.natural_shading if setting == "natural" else made.corrected_shading
    expected = (made.reflectance * shading)[CROP]
    assert photograph.image.dtype == np.float64
    assert np.abs(photograph.image - expected).max() <= STEP / 2 + 1e-12
    assert len(np.unique(photograph.image)) > 256
    assert photograph.name == "apple"


def test_each_setting_has_its_own_mask(made: Miniature) -> None:
    """The laboratory's is the mask file; the natural one is where the depth is known."""
    dataset = MitBerkeley(made.root)
    laboratory, natural = (
        dataset.load("apple", setting).photograph.mask for setting in ("laboratory", "natural")
    )
    assert (laboratory == made.mask[CROP]).all()
    assert (natural == ~np.isnan(made.depth[CROP])).all()
    assert natural.sum() < laboratory.sum()


@pytest.mark.parametrize("setting", ["natural", "laboratory"])
def test_the_truth_is_turned_into_our_axes(made: Miniature, setting: str) -> None:
    """Depth, normals, albedo, shading and light are those written, NaN outside the mask."""
    capture = MitBerkeley(made.root).load("apple", setting)
    truth, mask = capture.truth, capture.photograph.mask
    assert truth.height is not None
    assert truth.normals is not None
    assert truth.albedo is not None
    assert truth.shading is not None
    assert truth.illumination is not None
    natural = setting == "natural"
    light = made.natural_light if natural else made.laboratory_lights[10]
    shading = made.natural_shading if natural else made.corrected_shading
    assert np.allclose(truth.height, made.depth[CROP], equal_nan=True)
    expected = normals_from_mit_axes(mit_normals(made.depth[CROP]))
    assert np.allclose(truth.normals, expected, equal_nan=True)
    assert np.allclose(truth.albedo[mask], made.reflectance[CROP][mask], atol=STEP)
    assert np.allclose(truth.shading[mask], shading[CROP][mask], atol=STEP)
    assert np.array_equal(truth.illumination.coefficients, harmonics_from_mit_axes(light))
    for values in (truth.height, truth.normals, truth.albedo, truth.shading):
        assert np.isnan(values[~mask]).all()


def test_the_natural_shading_is_its_light_on_its_normals(made: Miniature) -> None:
    """Axes and signs at once: the record's light on the record's normals is its shading."""
    truth = MitBerkeley(made.root).load("apple", "natural").truth
    assert truth.normals is not None
    assert truth.shading is not None
    assert truth.illumination is not None
    known = np.isfinite(truth.normals).all(axis=-1)
    shaded = truth.illumination.shade(truth.normals)
    assert np.abs(shaded - truth.shading)[known].max() < STEP
    assert known.sum() > 500


def test_ten_photographs_come_with_their_lights(made: Miniature) -> None:
    """In order, of one size and mask, each with the light calibrated for it."""
    lit = MitBerkeley(made.root).lit_photographs("apple")
    base = (made.reflectance * made.corrected_shading)[CROP]
    assert len(lit) == 10
    for k, (item, light) in enumerate(zip(lit, made.laboratory_lights[:10], strict=True), start=1):
        assert np.abs(item.photograph.image - base * k / 11).max() <= STEP
        assert (item.photograph.mask == made.mask[CROP]).all()
        assert np.array_equal(item.illumination.coefficients, harmonics_from_mit_axes(light))


def test_the_fingerprint_follows_the_content(copied: MitBerkeley, made: Miniature) -> None:
    """A copy elsewhere has the same; a changed file another; a note beside the set the same."""
    assert copied.fingerprint() == MitBerkeley(made.root).fingerprint()
    (copied.root / "README").write_text("not part of the set")
    assert copied.fingerprint() == MitBerkeley(made.root).fingerprint()
    with (copied.root / "MIT-Berkeley-Natural/apple/L.mat").open("ab") as stream:
        stream.write(b"\0")
    assert copied.fingerprint() != MitBerkeley(made.root).fingerprint()


def test_unknown_names_are_suggested(made: Miniature) -> None:
    """A misspelt object or setting gets the nearest one."""
    dataset = MitBerkeley(made.root)
    with pytest.raises(RelightlabError, match="Did you mean 'raccoon'"):
        dataset.load("racoon", "natural")
    with pytest.raises(RelightlabError, match="Unknown setting 'lab'"):
        dataset.load("apple", "lab")
    with pytest.raises(RelightlabError, match="Unknown object 'aple'"):
        dataset.lit_photographs("aple")


FILES = (
    "MIT-Berkeley-Laboratory/apple/crop_idx.mat",
    "MIT-Berkeley-Laboratory/apple/Z.mat",
    "MIT-Berkeley-Laboratory/apple/mask.png",
    "MIT-Berkeley-Laboratory/apple/reflectance.png",
    "MIT-Berkeley-Natural/apple/diffuse.png",
    "MIT-Berkeley-Natural/apple/shading_color.png",
    "MIT-Berkeley-Natural/apple/L.mat",
)


@pytest.mark.parametrize("file", FILES)
def test_a_missing_file_is_named(copied: MitBerkeley, file: str) -> None:
    """Whichever is missing, the sentence names it."""
    (copied.root / file).unlink()
    with pytest.raises(RelightlabError, match=f"no such file: .*{Path(file).name}"):
        copied.load("apple", "natural")


@pytest.mark.parametrize("kept", [0, 60, 200, -40])
@pytest.mark.parametrize("file", FILES)
def test_a_truncated_file_is_one_sentence(copied: MitBerkeley, file: str, kept: int) -> None:
    """Cut to nothing, in its header, in its middle or near its end, the file is named."""
    path = copied.root / file
    path.write_bytes(path.read_bytes()[:kept])
    with pytest.raises(RelightlabError, match=f"cannot read .*{Path(file).name}"):
        copied.load("apple", "natural")


@pytest.mark.parametrize("file", FILES)
def test_a_file_of_something_else_is_one_sentence(copied: MitBerkeley, file: str) -> None:
    """A web page saved under the file's name is not taken for data."""
    (copied.root / file).write_text("<html>Not Found</html>" * 40)
    with pytest.raises(RelightlabError, match=f"cannot read .*{Path(file).name}"):
        copied.load("apple", "natural")


@pytest.mark.parametrize("compressed", [False, True])
def test_a_mat_file_cut_anywhere_is_one_sentence(tmp_path: Path, compressed: bool) -> None:
    """At whatever byte the download ended, with or without compression."""
    path = tmp_path / "Z.mat"
    values = np.random.default_rng(0).normal(size=(4, 5))
    savemat(path, {"depth": values}, do_compression=compressed)
    whole = path.read_bytes()
    assert np.array_equal(load_mat(path, "depth")["depth"], values)
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        with pytest.raises(RelightlabError, match=r"cannot read .*the file is damaged"):
            load_mat(path, "depth")


def test_a_mat_file_of_another_variable_is_one_sentence(tmp_path: Path) -> None:
    """The variable that is not there is named."""
    savemat(tmp_path / "Z.mat", {"height": np.ones((2, 2))})
    with pytest.raises(RelightlabError, match=r"cannot read .*'depth'"):
        load_mat(tmp_path / "Z.mat", "depth")


def test_a_truncated_shading_is_one_sentence(copied: MitBerkeley) -> None:
    """The laboratory's own files are checked as well."""
    path = copied.root / "MIT-Berkeley-Laboratory/apple/shading_corrected_color.mat"
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(RelightlabError, match=r"cannot read .*shading_corrected_color"):
        copied.load("apple", "laboratory")


def test_an_eight_bit_picture_is_refused(copied: MitBerkeley) -> None:
    """A photograph converted to eight bits has lost what models need."""
    from PIL import Image

    path = copied.root / "MIT-Berkeley-Natural/apple/diffuse.png"
    Image.fromarray(np.zeros((*SHAPE, 3), np.uint8)).save(path)
    with pytest.raises(RelightlabError, match="expected a 16-bit PNG, got 8-bit"):
        copied.load("apple", "natural")


# Full set: name, crop height, crop width, mask pixels, pixels of known depth. Counted on the files
# by an independent reader (scipy.io and pypng) when the format was described.
COUNTED = {
    "apple": (222, 267, 33475, 32620),
    "box": (368, 333, 75388, 75388),
    "cup1": (271, 235, 34394, 34394),
    "cup2": (307, 262, 41388, 41388),
    "deer": (327, 374, 52910, 51679),
    "dinosaur": (543, 476, 70430, 70430),
    "frog1": (291, 376, 54080, 44444),
    "frog2": (235, 302, 27022, 26044),
    "panther": (270, 496, 61291, 49067),
    "paper1": (438, 532, 144703, 140445),
    "paper2": (379, 476, 112591, 108576),
    "pear": (291, 238, 36884, 35262),
    "phone": (229, 395, 43544, 42346),
    "potato": (168, 309, 26830, 26830),
    "raccoon": (268, 379, 59716, 59043),
    "squirrel": (353, 424, 79182, 79182),
    "sun": (560, 484, 182884, 182884),
    "teabag1": (253, 258, 30417, 30417),
    "teabag2": (267, 259, 34185, 34185),
    "turtle": (268, 414, 54216, 53506),
}


@pytest.mark.real_data
@pytest.mark.parametrize("name", OBJECTS)
def test_natural_shading_is_the_sets_own_forward_model(mit_berkeley_root: Path, name: str) -> None:
    """Log(shading) = B(N) . L far within the wanted 0.005 (RMS) inside the eroded mask.

    This holds for axes, signs, units and bit depth at once. Values of zero (black) and one (clipped
    by the file format) are left out: 8 of 3.5 million over all objects. Measured: at most 3.6e-5.
    """
    capture = MitBerkeley(mit_berkeley_root).load(name, "natural")
    truth, mask = capture.truth, capture.photograph.mask
    assert truth.normals is not None
    assert truth.shading is not None
    assert truth.illumination is not None
    inner = binary_erosion(mask, np.ones((3, 3)), iterations=2)
    normals, shading = truth.normals[inner], truth.shading[inner]
    predicted = harmonics(normals) @ truth.illumination.coefficients
    usable = (shading > 0) & (shading < 1)
    assert (~usable).sum() <= 8
    error = np.log(shading[usable]) - predicted[usable]
    assert np.sqrt(np.mean(error**2)) < 1e-4
    # Where it was clipped, the model says that it would be above one.
    assert (predicted[shading == 1] > -1e-4).all()


@pytest.mark.real_data
@pytest.mark.parametrize("name", OBJECTS)
def test_sizes_and_pixel_counts_are_those_counted_before(
    mit_berkeley_root: Path, name: str
) -> None:
    """Crop, mask and known depth agree with an independent reader of the same files."""
    dataset = MitBerkeley(mit_berkeley_root)
    laboratory, natural = (dataset.load(name, s) for s in ("laboratory", "natural"))
    assert laboratory.truth.height is not None
    mask = laboratory.photograph.mask
    counted = (*mask.shape, int(mask.sum()), int(np.isfinite(laboratory.truth.height).sum()))
    assert counted == COUNTED[name]
    assert natural.photograph.mask.sum() == COUNTED[name][3]
    assert natural.photograph.image.shape == (*COUNTED[name][:2], 3)


@pytest.mark.real_data
@pytest.mark.parametrize("name", OBJECTS)
def test_measured_photographs_keep_sixteen_bits(mit_berkeley_root: Path, name: str) -> None:
    """More than 256 values in every photograph, within [0, 1], and natural ones A times S."""
    dataset = MitBerkeley(mit_berkeley_root)
    for setting in dataset.settings:
        capture = dataset.load(name, setting)
        image, mask = capture.photograph.image, capture.photograph.mask
        assert len(np.unique(image)) > 1000
        assert image.min() == 0
        assert image.max() <= 1
        assert (image[mask] > 0).all()
    truth = dataset.load(name, "natural").truth
    assert truth.albedo is not None
    assert truth.shading is not None
    capture = dataset.load(name, "natural")
    product = truth.albedo * truth.shading
    assert np.nanmax(np.abs(product - capture.photograph.image)) < 1e-3


@pytest.mark.real_data
@pytest.mark.parametrize("name", OBJECTS)
def test_larger_heights_are_nearer(mit_berkeley_root: Path, name: str) -> None:
    """The inside of every object stands above its eight-pixel border."""
    height = MitBerkeley(mit_berkeley_root).load(name, "laboratory").truth.height
    assert height is not None
    known = np.isfinite(height)
    inside = binary_erosion(known, iterations=8)
    assert height[inside].mean() > height[known & ~inside].mean() + 5


@pytest.mark.real_data
def test_measured_lit_photographs_are_ten_and_bright_toward_their_light(
    mit_berkeley_root: Path,
) -> None:
    """Each photograph divided by the albedo is explained better by its own light than by others."""
    dataset = MitBerkeley(mit_berkeley_root)
    truth = dataset.load("raccoon", "laboratory").truth
    assert truth.albedo is not None
    assert truth.normals is not None
    lit = dataset.lit_photographs("raccoon")
    assert len(lit) == 10
    known = np.isfinite(truth.normals).all(axis=-1) & (truth.albedo > 0).all(axis=-1)
    shadings = [item.photograph.image[known] / truth.albedo[known] for item in lit]
    predicted = [item.illumination.shade(truth.normals)[known] for item in lit]
    likeness = np.array(
        [[np.corrcoef(s.ravel(), p.ravel())[0, 1] for p in predicted] for s in shadings]
    )
    assert (likeness.argmax(axis=1) == np.arange(10)).mean() >= 0.8


@pytest.mark.real_data
@pytest.mark.parametrize("file", ["Z.mat", "light03.png", "mask.png"])
def test_a_damaged_measured_file_is_one_sentence(
    mit_berkeley_root: Path, tmp_path: Path, file: str
) -> None:
    """The measured files too, cut in half, are told by name."""
    for folder in ("MIT-Berkeley-Laboratory", "MIT-Berkeley-Natural"):
        shutil.copytree(mit_berkeley_root / folder / "potato", tmp_path / folder / "potato")
    path = tmp_path / "MIT-Berkeley-Laboratory" / "potato" / file
    content = path.read_bytes()
    path.chmod(0o644)
    path.write_bytes(content[: len(content) // 2])
    dataset = MitBerkeley(tmp_path)
    with pytest.raises(RelightlabError, match=f"cannot read .*{file}"):
        (dataset.load("potato", "laboratory"), dataset.lit_photographs("potato"))
