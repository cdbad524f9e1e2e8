"""The example of docs/study-file.md, loaded as it is printed."""

from __future__ import annotations

import re
import tomllib
from dataclasses import fields
from pathlib import Path

import numpy as np
from PIL import Image

from studies.study_file import STUDY_KEYS, load_study
from studies.study_pairs import CLOSING_KEYS, QUALIFICATION_KEYS, TASK_KEYS
from studies.study_records import AnalysisPlan, Exclusions, Question, Recruitment, TrialSettings
from tests.repository import ROOT

PICTURE = re.compile(r'"([\w/{}-]+\.(?:png|jpg))"')


def example_text() -> str:
    """Return the TOML of the document."""
    text = (ROOT / "docs" / "study-file.md").read_text(encoding="utf-8")
    (found,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    return str(found)


def test_the_documented_study_loads(tmp_path: Path) -> None:
    """With pictures under the names that it gives, the example is a study."""
    text = example_text()
    names = {
        name.replace("{pair}", pair)
        for name in PICTURE.findall(text)
        for pair in ("kitchen", "garden")
    }
    for number, name in enumerate(sorted(names)):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        noise = np.random.default_rng(number).integers(0, 255, (8, 8, 3), dtype=np.uint8)
        Image.fromarray(noise).save(path)
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    study = load_study(tmp_path / "study.toml")
    assert [pair.name for pair in study.tasks[0].pairs] == ["kitchen", "garden", "desk"]
    assert study.closing[0].question == "Which spheres look more realistic?"
    assert study.exclusions.maximum_blur_events == 10


def test_every_key_is_documented() -> None:
    """The example has every key that a study file may have, in its place."""
    document = tomllib.loads(example_text())
    assert set(document) == set(STUDY_KEYS)
    assert set(document["tasks"][0]) == set(TASK_KEYS)
    assert set(document["qualification"][0]) == set(QUALIFICATION_KEYS)
    assert set(document["closing"][0]) == set(CLOSING_KEYS)
    assert {key for one in document["questionnaire"] for key in one} == names_of(Question)
    assert set(document["trials"]) == names_of(TrialSettings)
    assert set(document["recruitment"]) == names_of(Recruitment)
    assert set(document["exclusions"]) == names_of(Exclusions)
    assert set(document["analysis"]) == names_of(AnalysisPlan)


def names_of(record: type) -> set[str]:
    """Return the names of a record's fields."""
    return {field.name for field in fields(record)}
