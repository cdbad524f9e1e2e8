"""What the report calls the base shapes, rules and sets of Table 2, and its fixed prose."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from datasets.records import Dataset
from evaluation.base_shapes import BASE_SHAPES, HasSensor

Document = Mapping[str, Any]
"""Of a `reports.base_shape_run.BaseShapeStudy`."""
SHAPE_WORDS = {
    "contour": "contour (ours)",
    "kinect": "Kinect (simulated)",
    "sirfs": "SIRFS",
    "sirfs-stereo": "SIRFS-stereo",
    "ground-truth": "ground truth",
    "flat": "flat",
}
SENSOR = "depth sensor (real)"
REFERENCES = {"psm-uw": "photometric stereo (reference)"}
"""What stands for the true shape in sets that only have something close to it."""
SET_WORDS = {"mit-berkeley": "MIT-Berkeley", "synthetic": "the synthetic set"}
RULE_WORDS = {
    "default": "Default weights, (1, 1)",
    "oracle": "Oracle weights",
    "regression": "Regression weights",
}
INTRODUCTION = (
    "For each object, models that differ only in their base shape are relit, and compared with"
    " photographs really taken under known lights. {Flat}, a plane that faces the viewer, and the"
    " true shape, where there is one, are bounds and no rivals."
)
TABLE_CAPTION = (
    "Mean re-rendering error IMSE\u2032 over objects and lights, up to a scale of each picture;"
    " below it, its 95 % interval by bootstrap over objects. Relative: over the mean squared"
    " photograph. Minus contour: the paired difference and its interval. Over contour: an error"
    " divided by that of the contour shape under the same rule, here and as published. The paper's"
    " ten objects were never released, so only these proportions and the order can be compared"
    " with it. Regression weights, learned on the other objects, are not in its table, and one"
    " object alone has none."
)
PAIRS_CAPTION = (
    "Pairs of the paper's four shapes by relative error: on how many objects each is lower, the"
    " median difference of the first minus the second in percent of the mean squared photograph,"
    " Wilcoxon's signed-rank test, and its p after Holm's correction over the pairs of one rule."
)
OBJECTS_CAPTION = (
    "Relative error of every object in percent of its mean squared photograph: what the bars show."
)
SENSITIVITY_CAPTION = (
    "The error when one choice of the protocol is made otherwise, and the order of the paper's four"
    " shapes from lowest to highest error; whether it is that of the first row."
)
SIMULATED_NOTE = (
    "This set was not photographed with a depth sensor. The row {Kinect (simulated)} is a simulated"
    " time-of-flight sensor of that kind, looking at the shape that is taken for true; its depth is"
    " cleaned as a user would. The published column is a real Kinect before other objects."
)
SENSOR_NOTE = (
    "In the Kinect's place stands the depth that the set's own sensor measured, cleaned as a user"
    " would. The published column is a Kinect before other objects."
)
CAVEATS = {
    "mit-berkeley": (
        "Depth and lights of this set were reconstructed by its authors from these"
        " same photographs, together. A shape near their depth, the simulated Kinect and the ground"
        " truth foremost, is lit by lights that were fitted to it, and so is favoured."
    ),
    "psm-uw": (
        "The lights come from a gray sphere and favour no shape, but the reference"
        " is photometric stereo on the very photographs that it is tested on, and the simulated"
        " Kinect looks at that reference: both are favoured."
    ),
    "rgbd-mitten": (
        "No light of this set was measured. Each is estimated from the photograph"
        " it is tested on, on the normals of the set's own depth sensor, and so favours that"
        " sensor's shape. It is one object."
    ),
    "synthetic": (
        "These photographs are rendered and their lights fitted to renderings. The"
        " numbers test the method and the code, and say nothing about the paper's objects."
    ),
}
"""What each set favours."""


def set_words(dataset: str) -> str:
    """Return what the report calls a dataset.

    Parameters
    ----------
    dataset : str

    Returns
    -------
    str

    Examples
    --------
    >>> set_words("mit-berkeley"), set_words("psm-uw")
    ('MIT-Berkeley', 'psm-uw')
    """
    return SET_WORDS.get(dataset, dataset)


def shape_words(dataset: Dataset) -> dict[str, str]:
    """Return what the report calls each base shape as measured on a dataset.

    Parameters
    ----------
    dataset : Dataset
        Its sensor, where it has one, stands for the simulated one.

    Returns
    -------
    dict of str
    """
    words = {name: SHAPE_WORDS.get(name, name) for name in BASE_SHAPES}
    if isinstance(dataset, HasSensor):
        words["kinect"] = SENSOR
    if dataset.name in REFERENCES:
        words["ground-truth"] = REFERENCES[dataset.name]
    return words


def file_of(document: Document) -> str:
    """Return the name of the results file that a study is written to.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    str

    Examples
    --------
    >>> file_of({"provenance": {"dataset": "own:my mugs"}})
    'table2-own-my-mugs.json'
    """
    return f"table2-{key_of(document)}.json"


def short_words(words: Mapping[str, str]) -> dict[str, str]:
    """Return what the shapes are called in little room; what is simulated still says so.

    Parameters
    ----------
    words : mapping of str
        As `shape_words` gives them.

    Returns
    -------
    dict of str

    Examples
    --------
    >>> short_words({"contour": "contour (ours)", "kinect": "Kinect (simulated)"})
    {'contour': 'contour', 'kinect': 'Kinect (simulated)'}
    """
    return {
        shape: called if shape == "kinect" else called.split(" (")[0]
        for shape, called in words.items()
    }


def key_of(document: Document) -> str:
    """Return the dataset's name, fit for an address and for a file.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    str
    """
    name = str(document["provenance"]["dataset"])
    return "".join(sign if sign.isalnum() or sign in "-_." else "-" for sign in name)


def measured_shapes(document: Document) -> tuple[str, ...]:
    """Return the shapes of a study in the order of its table.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    tuple of str
    """
    measured = {row["shape"] for row in document["rows"]}
    return tuple(shape for shape in BASE_SHAPES if shape in measured)
