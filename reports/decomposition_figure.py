"""One photograph taken apart and lit again (`fig:detailmaps`)."""

from __future__ import annotations

import numpy as np

from reports.figures import Panel, PanelFigure, PanelRow, Scale, panel
from reports.pictures import (
    diverging_picture,
    exposure,
    normal_picture,
    photograph_picture,
    sphere_picture,
    symmetric_limit,
)
from reports.subject import BuiltObject, Subject, varied_lights
from shading_model.illumination import LogHarmonics
from shading_model.object_model import Weights

PREFERRED = ("raccoon", "sun")
OBJECTS, RELIT = 2, 3
PHOTOGRAPH_ONLY = Weights(parametric=1.0, geometric=0.0)
"""The weights that give back the photograph: S_g is already part of S_p."""


def decomposition_figure(subject: Subject) -> PanelFigure:
    """Return the layers of two objects' models, and the objects under other lights.

    Parameters
    ----------
    subject : Subject

    Returns
    -------
    PanelFigure
    """
    setting = subject.photographed_setting
    lights = [subject.lights[number] for number in varied_lights(subject.lights, RELIT)]
    rows = tuple(
        row
        for name in subject.preferred(PREFERRED, OBJECTS)
        for row in _rows(name, subject.built(name, setting), lights)
    )
    return PanelFigure(
        "decomposition",
        "One photograph, taken apart and lit again",
        f"Models built from the {setting} photograph alone (detail source “default”, the paper's"
        " Fig. detailmaps). Retinex splits the photograph I into albedo A and shading S; five point"
        " lights on the contour shape give the fitted coarse shading; what they miss is the"
        " parametric residual Sₚ, and what a dictionary of smooth patches misses is the geometric"
        " detail S_g. Relit pictures use weights (1, 1, 1) under lights of the table.",
        rows,
        columns=4,
    )


def _rows(name: str, built: BuiltObject, lights: list[LogHarmonics]) -> list[PanelRow]:
    limit = symmetric_limit(built.model.parametric_residual, built.model.geometric_detail)
    return [
        PanelRow(f"{name}: layers", layer_panels(name, built, limit), Scale(limit, "shading")),
        PanelRow(f"{name}: relit", relit_panels(name, built, lights)),
    ]


def layer_panels(name: str, built: BuiltObject, limit: float) -> tuple[Panel, ...]:
    """Return the photograph and every layer of its model.

    Parameters
    ----------
    name : str
    built : BuiltObject
    limit : float
        Of the scale of both detail maps.

    Returns
    -------
    tuple of Panel
    """
    model, shading = built.model, built.parts.shading
    image = np.where(model.mask[..., None], built.capture.photograph.image, np.nan)
    fitted = shading - model.parametric_residual
    again = model.relight(model.illumination, PHOTOGRAPH_ONLY)
    difference = float(np.sqrt(np.nanmean((again - image) ** 2)))
    bright, own = exposure(image), exposure(shading)
    maps = {"Sₚ": model.parametric_residual, "S_g": model.geometric_detail}
    spread = {key: f"rms {np.sqrt(np.nanmean(values**2)):.3f}" for key, values in maps.items()}
    return (
        panel(photograph_picture(image, bright), f"Photograph of {name}", "photograph I"),
        panel(photograph_picture(model.albedo), f"Albedo of {name}", "albedo A"),
        panel(photograph_picture(shading, own), f"Shading of {name}", "shading S"),
        panel(
            normal_picture(model.normals),
            f"Normals of the contour shape of {name}: red right, green up, blue toward the viewer",
            "contour shape, normals",
        ),
        panel(
            photograph_picture(fitted, own),
            f"Coarse shading of {name} by five fitted point lights",
            "fitted coarse shading",
        ),
        panel(
            diverging_picture(maps["Sₚ"], limit),
            f"Parametric residual of {name}, orange below zero, purple above",
            "residual Sₚ",
            spread["Sₚ"],
        ),
        panel(
            diverging_picture(maps["S_g"], limit),
            f"Geometric detail of {name}, orange below zero, purple above",
            "geometric detail S_g",
            spread["S_g"],
        ),
        panel(
            photograph_picture(again, bright),
            f"Photograph of {name} put together again from albedo, coarse shading and residual",
            "A (coarse + Sₚ)",
            f"rms to I {difference:.0e}" if difference > 1e-12 else "equal to I",
        ),
    )


def relit_panels(name: str, built: BuiltObject, lights: list[LogHarmonics]) -> tuple[Panel, ...]:
    """Return the object under each light, the light shown on a sphere, and its bare shading.

    Parameters
    ----------
    name : str
    built : BuiltObject
    lights : list of LogHarmonics

    Returns
    -------
    tuple of Panel
    """
    height, width = built.model.mask.shape
    panels = []
    for number, light in enumerate(lights, start=1):
        relit = photograph_picture(built.model.relight(light))
        words = f"other light {number}"
        panels += [
            panel(sphere_picture(light, height, width), f"White sphere under {words}", words),
            panel(relit, f"{name} relit under {words}", "relit"),
        ]
    return tuple(panels)
