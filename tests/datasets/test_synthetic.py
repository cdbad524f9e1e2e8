"""The synthetic set as files and as a dataset."""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from datasets.records import Dataset
from datasets.synthetic import Synthetic, synthesize, synthetic_root
from datasets.synthetic_objects import FULL, fitted_light, load_object
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics, harmonics

NAMES = ("bear", "cup", "medal")
SMALL = {"size": 64, "seed": 3, "samples": 4, "workers": 1}


@pytest.fixture(scope="module")
def small_set(tmp_path_factory: pytest.TempPathFactory) -> Synthetic:
    """Three small objects, made once for this module."""
    return synthesize(tmp_path_factory.mktemp("synthetic"), objects=NAMES, **SMALL)


def hashes(folder: Path) -> dict[str, str]:
    """The SHA-256 of every file in a folder."""
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.iterdir()}


def test_it_is_a_dataset(small_set: Synthetic) -> None:
    """Names, settings, records and shapes are those of the protocol."""
    dataset: Dataset = small_set
    assert dataset.name == "synthetic"
    assert dataset.objects == NAMES
    assert dataset.settings == ("natural", "laboratory")
    for name in dataset.objects:
        for setting in dataset.settings:
            capture = dataset.load(name, setting)
            photograph, truth = capture.photograph, capture.truth
            shape = photograph.mask.shape
            assert (capture.setting, photograph.name) == (setting, name)
            assert photograph.image.shape == (*shape, 3)
            for values in (truth.height, truth.normals, truth.albedo, truth.shading):
                assert values is not None
                assert values.shape[:2] == shape
                assert np.isnan(values[~photograph.mask]).all()
            assert truth.illumination is not None
            assert truth.illumination.coefficients.shape == (9, 3)


def test_photographs_are_positive_on_the_mask_only(small_set: Synthetic) -> None:
    """In [0, 1], above zero on the object, exactly zero off it, in every photograph."""
    for name in NAMES:
        captures = [small_set.load(name, setting).photograph for setting in small_set.settings]
        lit = [photograph.photograph for photograph in small_set.lit_photographs(name)]
        assert len(lit) == 10
        for photograph in captures + lit:
            assert photograph.image[photograph.mask].min() > 0
            assert photograph.image.max() <= 1
            assert (photograph.image[~photograph.mask] == 0).all()


def test_image_is_albedo_times_shading(small_set: Synthetic) -> None:
    """The truth multiplies to the photograph in both settings."""
    for setting in small_set.settings:
        capture = small_set.load("bear", setting)
        mask = capture.photograph.mask
        assert capture.truth.albedo is not None
        assert capture.truth.shading is not None
        product = (capture.truth.albedo * capture.truth.shading)[mask]
        np.testing.assert_allclose(product, capture.photograph.image[mask], rtol=1e-12)


def test_natural_log_shading_is_the_forward_model(small_set: Synthetic) -> None:
    """Where nothing is clipped, log shading is B(N) . L to 1e-6, on all but the outer ring."""
    for name in NAMES:
        truth = small_set.load(name, "natural").truth
        assert truth.normals is not None
        assert truth.shading is not None
        assert truth.illumination is not None
        predicted = harmonics(truth.normals) @ truth.illumination.coefficients
        checked = np.isfinite(predicted) & (truth.shading < 1)
        assert checked.sum() > 2000
        np.testing.assert_allclose(
            np.log(truth.shading[checked]), predicted[checked], rtol=0, atol=1e-6
        )


def test_every_object_has_its_own_natural_light(small_set: Synthetic) -> None:
    """Lights are drawn without replacement."""
    lights = [small_set.load(name, "natural").truth.illumination for name in NAMES]
    coefficients = {light.coefficients.tobytes() for light in lights if light is not None}
    assert len(coefficients) == len(NAMES)


def test_the_laboratory_has_cast_shadows(small_set: Synthetic) -> None:
    """A visible share of the bear is half as bright as its fitted light predicts, or darker."""
    shares = []
    truth = small_set.load("bear", "laboratory").truth
    assert truth.albedo is not None
    assert truth.normals is not None
    known = np.isfinite(truth.normals).all(axis=-1)
    for lit in small_set.lit_photographs("bear"):
        shading = (lit.photograph.image / truth.albedo)[known]
        predicted = lit.illumination.shade(truth.normals)[known]
        shares.append((shading < 0.5 * predicted).mean())
    assert np.mean(shares) > 0.03
    assert max(shares) < 0.5


def test_fitted_lights_explain_most_of_the_log_shading(small_set: Synthetic) -> None:
    """The fit leaves less than half of the variance of log shading on every photograph."""
    truth = small_set.load("bear", "laboratory").truth
    assert truth.albedo is not None
    assert truth.normals is not None
    known = np.isfinite(truth.normals).all(axis=-1)
    for lit in small_set.lit_photographs("bear"):
        values = np.log((lit.photograph.image / truth.albedo)[known])
        residual = values - np.log(lit.illumination.shade(truth.normals)[known])
        assert residual.var() < 0.5 * values.var()


def test_a_light_is_recovered_from_its_own_shading() -> None:
    """On a bowl of normals the fit gives the light's shading back to a per mille."""
    generator = np.random.default_rng(0)
    normals = generator.normal(size=(60, 60, 3))
    normals[..., 2] = np.abs(normals[..., 2])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    normals[0] = np.nan
    light = LogHarmonics(generator.normal(scale=0.2, size=(9, 3)))
    fitted = fitted_light(light.shade(normals), normals)
    np.testing.assert_allclose(fitted.shade(normals), light.shade(normals), rtol=0.02)


def test_the_same_bytes_twice(small_set: Synthetic, tmp_path: Path) -> None:
    """Made again, alone, an object's file is the same to the byte."""
    synthesize(tmp_path, objects=["cup"], **SMALL)
    assert hashes(tmp_path)["cup.npz"] == hashes(small_set.root)["cup.npz"]


@pytest.mark.slow
def test_the_same_bytes_with_two_workers(small_set: Synthetic, tmp_path: Path) -> None:
    """Two processes of one thread give the files and the fingerprint of one with all threads."""
    done: list[tuple[int, int]] = []
    made = synthesize(
        tmp_path,
        objects=NAMES,
        progress=lambda count, total, _: done.append((count, total)),
        **{**SMALL, "workers": 2},
    )
    assert hashes(tmp_path) == hashes(small_set.root)
    assert made.fingerprint() == small_set.fingerprint()
    assert done == [(1, 3), (2, 3), (3, 3)]


def test_the_manifest_tells_how_the_set_was_made(small_set: Synthetic) -> None:
    """Generator, parameters and the hash of every file; nothing else lies in the folder."""
    manifest = json.loads((small_set.root / "manifest.json").read_text())
    assert (manifest["generator"], manifest["size"], manifest["seed"]) == (1, 64, 3)
    found = hashes(small_set.root)
    del found["manifest.json"]
    assert manifest["files"] == found


def test_another_seed_is_another_set(small_set: Synthetic, tmp_path: Path) -> None:
    """Albedo, light and fingerprint change with the seed."""
    other = synthesize(tmp_path, objects=["medal"], **{**SMALL, "seed": 4})
    assert other.fingerprint() != small_set.fingerprint()
    first, second = (s.load("medal", "natural").truth for s in (small_set, other))
    assert first.illumination is not None
    assert second.illumination is not None
    assert not np.array_equal(first.illumination.coefficients, second.illumination.coefficients)


def test_a_cached_set_is_made_once(tmp_path: Path) -> None:
    """The second call finds the first one's files and makes nothing."""
    made: list[str] = []
    for _ in range(2):
        root = synthetic_root(
            tmp_path, objects=["medal"], progress=lambda *args: made.append(args[2]), **SMALL
        )
    assert root.name == "synthetic-1-64-3"
    assert made == ["medal"]


@pytest.mark.parametrize("fault", ["damaged", "missing", "half made", "other samples", "garbled"])
def test_a_faulty_cached_set_is_made_again(
    small_set: Synthetic, tmp_path: Path, fault: str
) -> None:
    """Whatever happened to the folder, the set that comes back is whole."""
    root = tmp_path / "synthetic-1-64-3"
    shutil.copytree(small_set.root, root)
    file, manifest = root / "medal.npz", root / "manifest.json"
    if fault == "damaged":
        file.write_bytes(file.read_bytes()[:-100] + bytes(100))
    elif fault == "missing":
        file.unlink()
    elif fault == "half made":
        manifest.unlink()
    elif fault == "garbled":
        manifest.write_text('{"format": ')
    else:
        manifest.write_text(manifest.read_text().replace('"samples": 4', '"samples": 5'))
    made: list[str] = []
    synthetic_root(
        tmp_path, objects=["medal"], progress=lambda *args: made.append(args[2]), **SMALL
    )
    assert made == ["medal"]
    assert hashes(root)["medal.npz"] == hashes(small_set.root)["medal.npz"]


def test_damaged_files_are_refused_on_loading(small_set: Synthetic, tmp_path: Path) -> None:
    """A flipped byte, a truncated archive and a missing file each get the sentence."""
    root = tmp_path / "copy"
    shutil.copytree(small_set.root, root)
    dataset, path = Synthetic(root), root / "cup.npz"
    whole = bytearray(path.read_bytes())
    whole[len(whole) // 2] ^= 1
    for content in (bytes(whole), bytes(whole[:1000]), b""):
        path.write_bytes(content)
        with pytest.raises(RelightlabError, match="missing or damaged"):
            dataset.load("cup", "natural")
    path.write_bytes(b"no archive")
    with pytest.raises(RelightlabError, match="missing or damaged"):
        load_object(path)
    path.unlink()
    with pytest.raises(RelightlabError, match="missing or damaged"):
        dataset.lit_photographs("cup")


def test_unknown_names_are_refused(small_set: Synthetic, tmp_path: Path) -> None:
    """Objects and settings that do not exist, when loading and when making."""
    with pytest.raises(RelightlabError, match=r"Unknown object 'bare'\. Did you mean 'bear'"):
        small_set.load("bare", "natural")
    with pytest.raises(RelightlabError, match="Unknown setting 'outdoors'"):
        small_set.load("bear", "outdoors")
    with pytest.raises(RelightlabError, match=r"Unknown object 'aple'\. Did you mean 'apple'"):
        synthesize(tmp_path, objects=["aple"])
    with pytest.raises(RelightlabError, match="at least one object"):
        synthesize(tmp_path, objects=[])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"size": 31}, "a picture size of at least 32, got 31"),
        ({"seed": -1}, "a seed of at least 0, got -1"),
        ({"samples": 0}, "samples per pixel of at least 1, got 0"),
        ({"workers": 0}, "a number of workers of at least 1, got 0"),
    ],
)
def test_numbers_out_of_range_are_refused(
    tmp_path: Path, parameters: dict[str, int], sentence: str
) -> None:
    """The sentence says the least that is accepted, and nothing is written."""
    with pytest.raises(RelightlabError, match=sentence):
        synthesize(tmp_path / "out", **parameters)
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    """A file where the folder should be gets the sentence."""
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(RelightlabError, match="cannot write"):
        synthesize(tmp_path / "file", objects=["medal"], **SMALL)


def test_a_folder_without_a_set_is_refused(tmp_path: Path) -> None:
    """An empty folder and one with somebody else's manifest are no synthetic set."""
    with pytest.raises(RelightlabError, match="no finished synthetic set"):
        Synthetic(tmp_path)
    for text in ('{"format": "something else"}', '{"format": "relightlab synthetic set 1"}', "[]"):
        (tmp_path / "manifest.json").write_text(text)
        with pytest.raises(RelightlabError, match=r"expected .* to say"):
            Synthetic(tmp_path)


def test_sixteen_bits_are_kept(small_set: Synthetic) -> None:
    """A laboratory photograph has far more than 256 levels, each a whole share of 65535."""
    image = small_set.load("bear", "laboratory").photograph.image
    levels = np.unique(image * FULL)
    assert len(levels) > 1000
    np.testing.assert_allclose(levels, np.rint(levels), atol=1e-6)
