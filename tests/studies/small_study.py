"""A small study with pictures, and the page's part in a session, as the tests of serving need."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from studies.bare_study import bare_study
from studies.study_records import Question, Recruitment, Study, TrialSettings

IDS = {"PROLIFIC_PID": "5f3a", "STUDY_ID": "77", "SESSION_ID": "c0ffee"}


def small_study(folder: Path, pairs: int = 3, tasks: int = 2, *, ids: bool = True) -> Study:
    """Return a study of few pairs whose pictures are noise, written into the folder."""
    bare = bare_study(pairs=pairs, tasks=tasks, qualification=1, folder=folder)
    for number, stimulus in enumerate(bare.stimuli()):
        path = bare.stimulus_path(stimulus)
        path.parent.mkdir(parents=True, exist_ok=True)
        noise = np.random.default_rng(number).integers(0, 255, (6, 8, 3), dtype=np.uint8)
        Image.fromarray(noise).save(path)
    return replace(
        bare,
        name="small",
        hash="5" * 64,
        questionnaire=(
            Question("gender", "Gender?", "choice", ("male", "female", "other")),
            Question("age", "Age?", "number", required=True, minimum=18, maximum=120),
            Question("expertise", "Expert?", "choice", ("yes", "no")),
            Question("comment", "Comments?", "text", maximum_length=500),
        ),
        recruitment=Recruitment(
            "https://panel.example/complete?cc={code}", tuple(IDS) if ids else ()
        ),
        settings=TrialSettings(allow_tie=True),
    )


def answer(**changes: Any) -> dict[str, Any]:
    """Return the body of an answer."""
    body = {"response": "left", "shown_ms": 900.5, "reaction_ms": 850.25, "blur_events": 0}
    return body | {"display_width": 1280.0, "display_height": 720.0} | changes


SMALL_FILE = """
name = "served"
title = "A small study"
seed = 1
consent = "Consent."
instructions = "Instructions."

[[tasks]]
name = "real"
title = "Ours against real"
target = "ours"
other = "real"
target_files = "{pair}-a.png"
other_files = "{pair}-b.png"
pairs = ["one", "two", "three"]

[[closing]]
name = "spheres"
plausible = "s-a.png"
implausible = "s-b.png"

[[closing]]
name = "perspective"
plausible = "p-a.png"
implausible = "p-b.png"

[[questionnaire]]
name = "age"
text = "How old are you?"
kind = "number"
minimum = 18
required = true
"""


def write_small_study(folder: Path) -> Path:
    """Write the file of a study of five trials, with its pictures, and return the file."""
    for number, name in enumerate(("one", "two", "three", "s", "p")):
        for side, letter in enumerate("ab"):
            noise = np.random.default_rng(2 * number + side).integers(0, 255, (6, 8, 3))
            Image.fromarray(noise.astype(np.uint8)).save(folder / f"{name}-{letter}.png")
    (folder / "study.toml").write_text(SMALL_FILE, encoding="utf-8")
    return folder / "study.toml"
