"""Study files: what is read from them, and what is refused in one sentence."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from shading_model.errors import RelightlabError
from studies.study_file import Pair, Study, load_study
from tests.studies.written_study import TEXT, changed, write_study


def loaded(folder: Path, text: str = TEXT) -> Study:
    """Return the study of a text."""
    return load_study(write_study(folder, text))


def test_everything_written_is_read(tmp_path: Path) -> None:
    """Every section of the file arrives in its record."""
    study = loaded(tmp_path)
    assert (study.name, study.title, study.seed) == ("small", "A small study", 7)
    assert study.folder == tmp_path
    task = study.task("ours-real")
    assert (task.title, task.target, task.other, task.family) == (
        ("ours-real", "ours", "real", "ours-real")
    )
    assert task.pairs == (
        Pair("kitchen", "ours/kitchen.png", "real/kitchen.png"),
        Pair("garden", "ours/garden.png", "real/garden.png"),
        Pair("desk", "desk-a.jpg", "desk-b.webp"),
    )
    assert study.qualification == (Pair("cartoon", "photo.png", "cartoon.png"),)
    assert [pair.name for pair in study.closing] == ["spheres", "perspective"]
    assert [question.kind for question in study.questionnaire] == ["choice", "number", "choice"]
    assert study.recruitment.id_parameters == ("PROLIFIC_PID",)
    assert study.recruitment.completion_url.endswith("{code}")
    rules = study.exclusions
    assert (rules.minimum_median_ms, rules.maximum_same_side, rules.maximum_blur_events) == (
        (400.0, 0.9, 3)
    )
    assert (study.analysis.equivalence_margin, study.analysis.alpha) == (0.06, 0.05)
    assert study.analysis.groups == ("expertise", "gender")
    assert (study.settings.minimum_view_ms, study.settings.allow_tie) == (300, True)
    assert len(study.stimuli()) == 12
    assert all(study.stimulus_path(one).is_file() for one in study.stimuli())


def test_layout_and_place_do_not_count_in_the_hash(tmp_path: Path) -> None:
    """Comments, a longer way to say the same and another folder leave the hash as it is."""
    patterns = 'pairs = ["kitchen", "garden", '
    written = 'pairs = [{name="kitchen", target="ours/kitchen.png", other="real/kitchen.png"}, '
    longer = changed(patterns, f'{written}"garden", ') + "alpha = 0.05\n"
    assert loaded(tmp_path / "b", "# a comment\n" + longer).hash == loaded(tmp_path / "a").hash


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('title = "A small study"', 'title = "Another study"'),
        ("seed = 7", "seed = 8"),
        ('consent = "Consent."', 'consent = "Other."'),
        ("allow_tie = true", "allow_tie = false"),
        ("maximum_same_side = 0.9", "maximum_same_side = 0.95"),
        ("equivalence_margin = 0.06", "equivalence_margin = 0.05"),
        ('text = "Your age?"', 'text = "How old are you?"'),
        ('"kitchen", "garden"', '"garden", "kitchen"'),
    ],
)
def test_every_value_counts_in_the_hash(tmp_path: Path, old: str, new: str) -> None:
    """Whatever the file says, to say it otherwise is another study."""
    assert loaded(tmp_path / "b", changed(old, new)).hash != loaded(tmp_path / "a").hash


def test_every_byte_of_a_picture_counts_in_the_hash(tmp_path: Path) -> None:
    """A picture that is exchanged under its name makes another study."""
    before = loaded(tmp_path).hash
    picture = tmp_path / "photo.png"
    end = picture.read_bytes()
    picture.write_bytes((tmp_path / "lines-a.png").read_bytes())
    assert load_study(tmp_path / "study.toml").hash != before
    picture.write_bytes(end)
    assert load_study(tmp_path / "study.toml").hash == before


def test_groups_that_cannot_be_formed_are_not_planned(tmp_path: Path) -> None:
    """Without a choice of groups, those are planned that the questions and tests allow."""
    chosen = 'groups = ["expertise", "gender"]'
    assert loaded(tmp_path, changed(chosen, "")).analysis.groups == (
        ("expertise", "tests", "gender", "age", "half")
    )
    bare = TEXT.replace(chosen, "").replace('name = "age"', 'name = "years"')
    assert loaded(tmp_path, bare).analysis.groups == ("expertise", "tests", "gender", "half")


WRONG = [
    (
        'title = "A small study"',
        "titel = 'x'",
        "Unknown key in the study 'titel'. Did you mean 'tit",
    ),
    (
        "allow_tie = true",
        "allow_ties = true",
        r"\[trials\] 'allow_ties'. Did you mean 'allow_tie'?",
    ),
    (
        'target = "ours"',
        'targets = "ours"',
        r"\[\[tasks\]\] ours-real 'targets'. Did you mean 'targ",
    ),
    ('real = "photo.png"', 'photo = "photo.png"', "Unknown key in .*cartoon 'photo'"),
    ("minimum_median_ms", "minimum_median", "exclusions.*Did you mean 'minimum_median_ms'"),
    ('name = "small"', "", "expected name to be a text that is not empty, got nothing"),
    ('name = "small"', 'name = "A Study"', "letters and digits .* got 'A Study'"),
    ('name = "small"', "name = 3", "expected name to be a text that is not empty, got 3"),
    ('consent = "Consent."', 'consent = " "', "expected consent to be a text that is not empty"),
    ('consent = "Consent."', r'consent = "a\u0007"', "expected consent to be a text"),
    ("seed = 7", 'seed = "7"', "seed to be a whole number from 0 to .* got '7'"),
    ("seed = 7", "seed = -1", "whole number from 0 to"),
    ("seed = 7", "seed = true", "whole number from 0 to .* got true"),
    ("seed = 7", "seed = 7.0", "whole number from 0 to .* got 7.0"),
    ("minimum_view_ms = 300", "minimum_view_ms = 600001", "whole number from 0 to 60000, got 60"),
    ("allow_tie = true", "allow_tie = 1", "allow_tie to be true or false, got 1"),
    ("pairs_per_subject = 2", "pairs_per_subject = 4", "at most the 3 pairs of task 'ours-real'"),
    ("pairs_per_subject = 2", "pairs_per_subject = 0", "from 1 to 200, got 0"),
    ('other = "real"', 'other = "ours"', "other to be another condition than the target"),
    ('"kitchen", "garden"', '"kitchen", "kitchen"', "different names, got 'kitchen' twice"),
    ('"kitchen", "garden"', '"kitchen", 3', "pair 2 of .*ours-real to be a table, got 3"),
    ('target_files = "ours/{pair}.png"', "", "target_files to be a path with {pair} in it"),
    ('other_files = "real/{pair}.png"', 'other_files = "a.png"', "path with {pair} in it"),
    ('real = "photo.png"', 'real = "../photo.png"', "below the study's folder"),
    ('real = "photo.png"', 'real = "/photo.png"', "below the study's folder"),
    ('real = "photo.png"', 'real = "photo.svg"', ".png, .jpg, .jpeg, .webp below"),
    ('real = "photo.png"', 'real = "cartoon.png"', "cartoon to be another picture than real"),
    ('real = "photo.png"', 'real = "absent.png"', "expected the picture .*absent.png, .* No such"),
    ('name = "spheres"', 'name = "sphere"', "Did you mean 'spheres'? Available: spheres, per"),
    ('name = "perspective"', 'name = "spheres"', r"\[\[closing\]\] to have different names"),
    ('kind = "number"', 'kind = "numbr"', "Did you mean 'number'?"),
    ('kind = "number"', 'kind = "text"', "minimum belongs to a question of kind 'number'"),
    ('options = ["Yes", "No"]', 'options = ["Yes"]', "options to be at least two texts"),
    ('options = ["Yes", "No"]', 'options = ["Yes", "Yes"]', "a list of texts that all differ"),
    ('options = ["Yes", "No"]', 'options = ["Yes", 1]', "a list of texts, got"),
    ('options = ["Yes", "No"]', 'options = ["A lot", "Some"]', "to be 'Yes' and 'No', got 'A lot'"),
    ("maximum = 120", "maximum = 18", "maximum to be more than minimum, 18, got 18"),
    ("maximum = 120", "maximum = nan", "maximum to be a number from"),
    ("https://panel", "javascript:panel", "starts with https:// or http://"),
    ('"PROLIFIC_PID"', '"PROLIFIC PID"', "names of letters, digits"),
    ("maximum_same_side = 0.9", "maximum_same_side = 0.4", "number from 0.5 to 1, got 0.4"),
    ("equivalence_margin = 0.06", "equivalence_margin = 0.5", "number from 0.001 to 0.499"),
    ('"expertise", "gender"', '"expert"', "Unknown group .*Did you mean 'expertise'?"),
    ('name = "gender"', 'name = "sex"', "group 'gender' needs a .* named 'gender'; add it"),
    ("[analysis]", "[[analysis]]", r"expected \[analysis\] to be a table, got"),
    ("[[qualification]]", "[qualification]", "expected qualification to be a list of tables"),
]


@pytest.mark.parametrize(("old", "new", "words"), WRONG)
def test_faults_are_one_sentence(tmp_path: Path, old: str, new: str, words: str) -> None:
    """A wrong key, value, name or picture is refused with the file, the place and what came."""
    file = write_study(tmp_path, changed(old, new))
    with pytest.raises(
        RelightlabError, match=words.replace("?", r"\?").replace("{", r"\{")
    ) as caught:
        load_study(file)
    message = str(caught.value)
    assert message.startswith(f"{file}: ")
    assert "\n" not in message


def test_a_study_has_a_task(tmp_path: Path) -> None:
    """A study without tasks is refused."""
    bare = re.sub(r"\[\[tasks\]\].*?(?=\[\[qual)", "", TEXT, flags=re.DOTALL)
    with pytest.raises(RelightlabError, match="at least one table"):
        loaded(tmp_path, bare)


def test_two_tasks_have_two_names(tmp_path: Path) -> None:
    """Two tasks of one name are refused."""
    tasks = re.search(r"\[\[tasks\]\].*?(?=\[\[qual)", TEXT, re.DOTALL)
    assert tasks is not None
    with pytest.raises(RelightlabError, match=r"\[\[tasks\]\] to have different names"):
        loaded(tmp_path, TEXT + tasks.group())


def test_files_that_are_no_study(tmp_path: Path) -> None:
    """A missing file, a folder, other bytes and broken TOML have a sentence each."""
    other = tmp_path / "other.toml"
    with pytest.raises(RelightlabError, match="there is none; 'relightlab study example DIR'"):
        load_study(other)
    with pytest.raises(RelightlabError, match="got a folder"):
        load_study(tmp_path)
    other.write_bytes(b"\xff\xfe")
    with pytest.raises(RelightlabError, match="UTF-8"):
        load_study(other)
    other.write_text("seed = 1\nname = \n", encoding="utf-8")
    with pytest.raises(RelightlabError, match=r"got a fault: .*line 2"):
        load_study(other)


def test_markup_in_texts_stays_text(tmp_path: Path) -> None:
    """Angle brackets are kept as they are: whoever shows them escapes them."""
    study = loaded(tmp_path, changed('"Consent."', '"a < b <script>"'))
    assert study.consent == "a < b <script>"
