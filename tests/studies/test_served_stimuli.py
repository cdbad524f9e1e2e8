"""Stimuli as subjects get them: the same pixels, and nothing else."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageCms
from PIL.PngImagePlugin import PngInfo

from shading_model.errors import RelightlabError
from studies.secret_key import SecretKey
from studies.served_stimuli import ServedStimuli, plain_png
from studies.study_records import Study

KEY = SecretKey(bytes(32))
NOISE = np.random.default_rng(0).integers(0, 255, (5, 7, 3), dtype=np.uint8)


def opened(content: bytes) -> Image.Image:
    """Return the picture in these bytes."""
    return Image.open(BytesIO(content))


def test_pixels_stay_and_metadata_goes(tmp_path: Path) -> None:
    """Text, times and resolution of a PNG are left out; its pixels are the same."""
    told = PngInfo()
    told.add_text("Software", "our method")
    told.add_itxt("Comment", "real")
    path = tmp_path / "a.png"
    Image.fromarray(NOISE).save(path, pnginfo=told, dpi=(300, 300))
    content = plain_png(path)
    np.testing.assert_array_equal(np.asarray(opened(content)), NOISE)
    assert b"our method" in path.read_bytes()
    assert opened(content).info == {}
    kinds = {content[at - 4 : at] for at in range(len(content)) if content[at - 4 : at].isalpha()}
    assert kinds & {b"tEXt", b"iTXt", b"pHYs", b"tIME", b"eXIf"} == set()


def test_a_jpeg_is_turned_upright_and_becomes_a_png(tmp_path: Path) -> None:
    """The format is the same for all, and the orientation of a camera is carried out."""
    exif = Image.Exif()
    exif[0x0112] = 6  # turned by a quarter
    exif[0x013B] = "a photographer"
    path = tmp_path / "a.jpg"
    Image.fromarray(NOISE).save(path, exif=exif)
    picture = opened(plain_png(path))
    assert (picture.format, picture.size) == ("PNG", (5, 7))
    assert b"a photographer" not in plain_png(path)


def test_a_colour_profile_is_carried_out(tmp_path: Path) -> None:
    """A picture with a profile of sRGB keeps its colours and loses the profile."""
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    path = tmp_path / "a.png"
    Image.fromarray(NOISE).save(path, icc_profile=profile)
    picture = opened(plain_png(path))
    assert "icc_profile" not in picture.info
    assert np.abs(np.asarray(picture).astype(int) - NOISE).max() <= 1


def test_a_colour_profile_is_carried_out_beside_transparency(tmp_path: Path) -> None:
    """A picture gets the same colours with an alpha channel as without, and keeps that channel."""
    content = bytearray(ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes())
    red, green = content.index(b"rXYZ"), content.index(b"gXYZ")
    content[red : red + 4], content[green : green + 4] = b"gXYZ", b"rXYZ"
    plain, clear = tmp_path / "a.png", tmp_path / "b.png"
    picture = Image.fromarray(NOISE)
    picture.save(plain, icc_profile=bytes(content))
    picture.putalpha(Image.fromarray(NOISE[..., 0]))
    picture.save(clear, icc_profile=bytes(content))
    shown = np.asarray(opened(plain_png(clear)))
    np.testing.assert_array_equal(shown[..., :3], np.asarray(opened(plain_png(plain))))
    np.testing.assert_array_equal(shown[..., 3], NOISE[..., 0])
    assert np.abs(shown[..., :3].astype(int) - NOISE).max() > 50


@pytest.mark.parametrize("mode", ["L", "P", "RGBA", "LA", "1", "I;16"])
def test_every_kind_of_picture_is_served(tmp_path: Path, mode: str) -> None:
    """Palettes, transparency and gray pictures become something that every browser shows."""
    path = tmp_path / "a.png"
    if mode == "I;16":
        Image.fromarray(NOISE[..., 0].astype(np.uint16) * 257).save(path)
    else:
        Image.fromarray(NOISE).convert(mode).save(path)
    assert opened(plain_png(path)).mode in {"L", "RGB", "RGBA"}


def test_sixteen_bits_of_gray_keep_their_range(tmp_path: Path) -> None:
    """A picture of 16 bits is served with its 8 most significant ones, not cut off at white."""
    path = tmp_path / "a.png"
    Image.fromarray(NOISE[..., 0].astype(np.uint16) * 257).save(path)
    shown = np.asarray(opened(plain_png(path)).convert("L"))
    assert np.abs(shown.astype(int) - NOISE[..., 0]).max() <= 1


def test_what_is_no_picture_is_told(tmp_path: Path) -> None:
    """A damaged file is told in a sentence with its name."""
    path = tmp_path / "a.png"
    path.write_bytes(b"no picture")
    with pytest.raises(RelightlabError, match=r"the stimulus .*a\.png cannot be read"):
        plain_png(path)


def test_names_tell_nothing_and_stay(study: Study) -> None:
    """Names are the same at every start with the same key, and others with another."""
    first, again, other = (
        ServedStimuli(study, key) for key in (KEY, KEY, SecretKey(bytes([1] * 32)))
    )
    addresses = [[one.address(path) for path in study.stimuli()] for one in (first, again, other)]
    assert addresses[0] == addresses[1]
    assert not set(addresses[0]) & set(addresses[2])
    assert len(set(addresses[0])) == len(study.stimuli())
    name = addresses[0][0].removeprefix("stimuli/")
    assert first.content(name) == plain_png(study.stimulus_path(study.stimuli()[0]))
    assert first.content("study.toml") is None
