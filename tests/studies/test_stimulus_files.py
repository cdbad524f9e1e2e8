"""The pictures of a study: missing, damaged, misnamed and doubled ones are refused."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest
from PIL import Image

from shading_model.errors import RelightlabError
from studies import stimulus_files
from studies.stimulus_files import stimulus_digests
from studies.study_file import Study, load_study
from tests.studies.written_study import write_study


@pytest.fixture
def study(tmp_path: Path) -> Study:
    """Return a study with pictures of every kind."""
    return load_study(write_study(tmp_path))


def test_digests_are_those_of_the_bytes(study: Study) -> None:
    """Each picture has the SHA-256 of its file."""
    digests = stimulus_digests(study)
    assert set(digests) == set(study.stimuli())
    for name, digest in digests.items():
        assert hashlib.sha256(study.stimulus_path(name).read_bytes()).hexdigest() == digest


@pytest.mark.parametrize("name", ["photo.png", "desk-a.jpg", "desk-b.webp"])
def test_a_picture_that_breaks_off_is_refused(study: Study, name: str) -> None:
    """Half a file of any kind is no picture."""
    path = study.stimulus_path(name)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(RelightlabError, match=f"{name}: expected a whole"):
        stimulus_digests(study)


def test_a_picture_of_another_kind_is_refused(study: Study) -> None:
    """A JPEG named .png would be served as what it is not."""
    with Image.open(study.stimulus_path("photo.png")) as picture:
        picture.convert("RGB").save(study.stimulus_path("photo.png"), "JPEG")
    with pytest.raises(RelightlabError, match="expected a PNG picture by its name, got JPEG"):
        stimulus_digests(study)


def test_a_text_is_no_picture(study: Study) -> None:
    """Bytes that are no picture are refused."""
    study.stimulus_path("photo.png").write_text("picture", encoding="utf-8")
    with pytest.raises(RelightlabError, match="expected a whole PNG picture"):
        stimulus_digests(study)


def test_two_copies_are_no_pair(study: Study) -> None:
    """A pair of equal files would be answered by chance."""
    copy = study.stimulus_path("photo.png").read_bytes()
    study.stimulus_path("cartoon.png").write_bytes(copy)
    with pytest.raises(
        RelightlabError, match=r"'cartoon': photo\.png and cartoon\.png are the same"
    ):
        stimulus_digests(study)


def test_a_huge_picture_is_refused(study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    """Subjects wait for every picture, so its size has a limit."""
    monkeypatch.setattr(stimulus_files, "LARGEST_PICTURE", 100)
    with pytest.raises(RelightlabError, match="expected at most 0 MB"):
        stimulus_digests(study)
