"""The example study: whole, always the same, and never written over something else."""

from __future__ import annotations

from pathlib import Path

import pytest

from shading_model.errors import RelightlabError
from studies.example_pictures import (
    INSERTIONS,
    cartoon_picture,
    perspective_picture,
    scene_picture,
    spheres_picture,
)
from studies.example_study import write_example
from studies.schedules import make_schedules
from studies.study_file import Study, load_study


@pytest.fixture(scope="module")
def example_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write the example study once."""
    return write_example(tmp_path_factory.mktemp("example"))


@pytest.fixture(scope="module")
def example_study(example_file: Path) -> Study:
    """Return the example study."""
    return load_study(example_file)


def test_it_is_the_papers_design(example_study: Study) -> None:
    """Ten pairs in each task, one task for a subject, four cartoons and two closing pairs."""
    assert [(task.target, task.other) for task in example_study.tasks] == [
        ("ours", "real"),
        ("barron-malik", "real"),
        ("ours", "barron-malik"),
        ("ours", "karsch"),
        ("one-layer", "no-detail"),
        ("two-layers", "one-layer"),
    ]
    assert {len(task.pairs) for task in example_study.tasks} == {10}
    assert len(example_study.qualification) == 4
    assert [pair.name for pair in example_study.closing] == ["spheres", "perspective"]
    assert {len(one.entries) for one in make_schedules(example_study)} == {16}
    assert example_study.analysis.groups == ("expertise", "tests", "gender", "age", "half")


def test_a_second_writing_changes_nothing(example_file: Path, example_study: Study) -> None:
    """Whoever asks again for the example gets the same file, untouched."""
    before = {path: path.stat().st_mtime_ns for path in example_file.parent.rglob("*.*")}
    assert write_example(example_file.parent) == example_file
    after = {path: path.stat().st_mtime_ns for path in example_file.parent.rglob("*.*")}
    assert after == before
    assert load_study(example_file).hash == example_study.hash


def test_another_study_is_not_written_over(tmp_path: Path) -> None:
    """A folder with a study of its own is refused, and nothing is added to it."""
    own = tmp_path / "study.toml"
    own.write_text("name = 'mine'", encoding="utf-8")
    with pytest.raises(RelightlabError, match="choose another folder"):
        write_example(tmp_path)
    assert list(tmp_path.iterdir()) == [own]
    assert own.read_text(encoding="utf-8") == "name = 'mine'"


def test_pictures_are_the_same_every_time_and_differ_from_each_other() -> None:
    """A picture depends on its scene and its method alone."""
    pictures = [scene_picture("scene-01", insertion) for insertion in INSERTIONS.values()]
    pictures += [scene_picture("scene-02", INSERTIONS["ours"]), cartoon_picture("scene-01")]
    pictures += [
        make(plausible=one)
        for one in (True, False)
        for make in (spheres_picture, perspective_picture)
    ]
    assert len({picture.tobytes() for picture in pictures}) == len(pictures)
    assert {picture.size for picture in pictures} == {(400, 300)}
    assert scene_picture("scene-01", INSERTIONS["real"]) == pictures[0]
