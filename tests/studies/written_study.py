"""A small study file with tiny pictures, and its text for tests to change."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

TEXT = """
name = "small"
title = "A small study"
seed = 7
consent = "Consent."
instructions = "Choose."

[trials]
minimum_view_ms = 300
allow_tie = true
pairs_per_subject = 2

[[tasks]]
name = "ours-real"
target = "ours"
other = "real"
target_files = "ours/{pair}.png"
other_files = "real/{pair}.png"
pairs = ["kitchen", "garden", {name = "desk", target = "desk-a.jpg", other = "desk-b.webp"}]

[[qualification]]
name = "cartoon"
real = "photo.png"
cartoon = "cartoon.png"

[[closing]]
name = "spheres"
plausible = "spheres-a.png"
implausible = "spheres-b.png"

[[closing]]
name = "perspective"
plausible = "lines-a.png"
implausible = "lines-b.png"

[[questionnaire]]
name = "gender"
text = "Your gender?"
kind = "choice"
options = ["Female", "Male", "Another"]

[[questionnaire]]
name = "age"
text = "Your age?"
kind = "number"
minimum = 18
maximum = 120

[[questionnaire]]
name = "expertise"
text = "Are you an expert?"
kind = "choice"
options = ["Yes", "No"]

[recruitment]
id_parameters = ["PROLIFIC_PID"]
completion_url = "https://panel.example/done?cc={code}"

[exclusions]
minimum_median_ms = 400
maximum_same_side = 0.9
maximum_blur_events = 3

[analysis]
equivalence_margin = 0.06
groups = ["expertise", "gender"]
"""
PICTURES = (
    "ours/kitchen.png",
    "ours/garden.png",
    "real/kitchen.png",
    "real/garden.png",
    "desk-a.jpg",
    "desk-b.webp",
    "photo.png",
    "cartoon.png",
    "spheres-a.png",
    "spheres-b.png",
    "lines-a.png",
    "lines-b.png",
)


def write_study(folder: Path, text: str = TEXT) -> Path:
    """Write the pictures and a study file of this text; return the file."""
    for number, name in enumerate(PICTURES):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        noise = np.random.default_rng(number).integers(0, 255, (12, 16, 3), dtype=np.uint8)
        Image.fromarray(noise).save(path)
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    return file


def changed(old: str, new: str) -> str:
    """Return the text with one part replaced, which must be there."""
    assert old in TEXT
    return TEXT.replace(old, new, 1)
