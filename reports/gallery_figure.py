"""Target, relit and error pictures of objects from the easiest to the hardest."""

from __future__ import annotations

import numpy as np

from evaluation.rerendering import rerendering_cells, target_image
from reports.figures import Panel, PanelFigure, PanelRow, Scale, panel
from reports.pictures import (
    Picture,
    diverging_picture,
    exposure,
    photograph_picture,
    sphere_picture,
    symmetric_limit,
)
from reports.subject import BuiltObject, Subject, varied_lights
from shading_model.arrays import Image, Mask
from shading_model.illumination import LogHarmonics
from shading_model.object_model import Weights

OBJECTS, LIGHTS = 4, 2


def gallery_figure(subject: Subject, setting: str) -> PanelFigure:
    """Return target, relit and error of objects spread over the range of errors, in one setting.

    Parameters
    ----------
    subject : Subject
    setting : str

    Returns
    -------
    PanelFigure
    """
    numbers = varied_lights(subject.lights, LIGHTS)
    rows = tuple(
        _row(name, subject.built(name, setting), subject.lights[number], number)
        for name in spread_over_errors(subject, setting, OBJECTS)
        for number in numbers
    )
    return PanelFigure(
        f"gallery-{setting}",
        f"Gallery: {setting} models",
        f"Models built from the {setting} photograph, relit under two lights of the table that"
        " differ much. Objects are not hand-picked: they are spread evenly from the lowest to the"
        " highest relative error (oracle weights). The sphere shows the light; w is (w_p, w_g)."
        " Relit pictures are scaled by the best k and share the target's exposure; errors are relit"
        " - target, mean over colour channels.",
        rows,
    )


def spread_over_errors(subject: Subject, setting: str, count: int) -> tuple[str, ...]:
    """Return objects spread evenly by rank of relative oracle error, lowest first.

    Parameters
    ----------
    subject : Subject
    setting : str
    count : int

    Returns
    -------
    tuple of str
        At most as many as were reported.
    """
    errors = {
        row["object"]: row["relative_imse"]
        for row in subject.document["objects"]
        if (row["setting"], row["detail_source"], row["weights"]) == (setting, "default", "oracle")
    }
    ranked = sorted(errors, key=lambda name: (errors[name], name))
    places = np.linspace(0, len(ranked) - 1, min(count, len(ranked))).round().astype(int)
    return tuple(ranked[place] for place in places)


def _row(name: str, built: BuiltObject, light: LogHarmonics, number: int) -> PanelRow:
    truth, model = built.capture.truth, built.model
    target = target_image(truth, light)
    target = np.where(model.mask[..., None], target, np.nan)
    (cell,) = rerendering_cells(model, truth, [light])
    choices = {"oracle": cell.oracle(), "default": Weights()}
    relit = {rule: best_scaled(model.relight(light, w), target) for rule, w in choices.items()}
    errors = {rule: (image - target).mean(axis=-1) for rule, image in relit.items()}
    limit = symmetric_limit(*errors.values())
    height, width = model.mask.shape
    words, bright = f"light {number + 1}", exposure(target)
    panels = [
        panel(sphere_picture(light, height, width), f"White sphere under {words}", words),
        panel(photograph_picture(target, bright), f"{name} under {words}, true", "target"),
    ]
    for rule, weights in choices.items():
        share = cell.error(weights) / cell.power
        shown = photograph_picture(relit[rule], bright)
        difference = diverging_picture(errors[rule], limit)
        panels += _pair(
            f"{name} under {words} by the {built.capture.setting} model",
            rule,
            weights,
            (shown, difference),
            share,
        )
    return PanelRow(f"{name}, {words}", tuple(panels), 6, (Scale(limit, "error"),))


def _pair(
    where: str, rule: str, weights: Weights, pictures: tuple[Picture, Picture], share: float
) -> list[Panel]:
    shown, difference = pictures
    values = f"w = ({weights.parametric:.2f}, {weights.geometric:.2f})"
    return [
        panel(shown, f"{where}, relit with {rule} weights", f"relit, {rule}", values),
        panel(
            difference,
            f"Error of {where} with {rule} weights, orange too dark, purple too bright",
            f"error, {rule}",
            f"{100 * share:.1f} % of I²",
        ),
    ]


def best_scaled(image: Image, target: Image) -> Image:
    """Return ``k image`` with the k >= 0 of least squared error to the target, in gray.

    Parameters
    ----------
    image, target : (h, w, 3) arrays
        NaN where unknown.

    Returns
    -------
    (h, w, 3) array
        NaN where either is unknown.

    Examples
    --------
    >>> best_scaled(np.full((1, 1, 3), 0.2), np.full((1, 1, 3), 0.6)).round(6).tolist()
    [[[0.6, 0.6, 0.6]]]
    """
    known: Mask = np.asarray(np.isfinite(image + target).all(axis=-1))
    ours, true = image[known].mean(axis=-1), target[known].mean(axis=-1)
    power = float(ours @ ours)
    scale = max(float(ours @ true), 0.0) / power if power > 0 else 0.0
    return np.where(known[..., None], scale * image, np.nan)
