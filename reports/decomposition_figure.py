"""One photograph taken apart and lit again (`fig:detailmaps`)."""

from __future__ import annotations

import numpy as np

from reports.figures import Panel, PanelFigure, PanelRow, Scale, panel
from reports.pictures import (
    diverging_picture,
    exposure,
    normal_picture,
    photograph_picture,
    symmetric_limit,
    with_light,
)
from reports.subject import BuiltObject, Subject, varied_lights
from shading_model.illumination import LogHarmonics
from shading_model.object_model import Weights

PREFERRED = ("raccoon", "sun")
OBJECTS, RELIT = 2, 4
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
        f"After the paper's `fig:detailmaps`: models built from the {setting} photograph alone,"
        " detail source “default”. Retinex splits the photograph I into albedo A and shading S;"
        " five point lights on the contour shape give the fitted coarse shading; what they miss is"
        " the parametric residual S_p, and what a dictionary of smooth patches misses is the"
        " geometric detail S_g. Relit pictures have weights w = (1, 1, 1) and an exposure of their"
        " own; the sphere in the corner shows the light.",
        rows,
    )


def teaser_figure(subject: Subject) -> PanelFigure:
    """Return the page's opening: one photograph, its layers, and two other lights.

    Parameters
    ----------
    subject : Subject

    Returns
    -------
    PanelFigure
    """
    (name,) = subject.preferred(PREFERRED, 1)
    built = subject.built(name, subject.photographed_setting)
    lights = [subject.lights[number] for number in varied_lights(subject.lights, 2)]
    photograph, albedo, _, _, coarse, residual, *_ = layer_panels(name, built)
    shown = (photograph, albedo, coarse, residual, *relit_panels(name, built, lights))
    return PanelFigure("teaser", name, "", (PanelRow(name, shown, 6),))


def _rows(name: str, built: BuiltObject, lights: list[LogHarmonics]) -> list[PanelRow]:
    scales = tuple(Scale(limit, key) for key, limit in _limits(built).items())
    return [
        PanelRow(f"{name}: layers", layer_panels(name, built), 4, scales),
        PanelRow(f"{name}: relit", relit_panels(name, built, lights), 4),
    ]


def _limits(built: BuiltObject) -> dict[str, float]:
    model = built.model
    return {
        "S_p": symmetric_limit(model.parametric_residual),
        "S_g": symmetric_limit(model.geometric_detail),
    }


def layer_panels(name: str, built: BuiltObject) -> tuple[Panel, ...]:
    """Return the photograph and every layer of its model.

    Parameters
    ----------
    name : str
    built : BuiltObject

    Returns
    -------
    tuple of Panel
    """
    model, shading = built.model, built.parts.shading
    image = np.where(model.mask[..., None], built.capture.photograph.image, np.nan)
    fitted = shading - model.parametric_residual
    again = model.relight(model.illumination, PHOTOGRAPH_ONLY)
    difference = float(np.sqrt(np.nanmean((again - image) ** 2)))
    limits = _limits(built)
    bright, own = exposure(image), exposure(shading)
    maps = {"S_p": model.parametric_residual, "S_g": model.geometric_detail}
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
            diverging_picture(maps["S_p"], limits["S_p"]),
            f"Parametric residual of {name}, orange below zero, purple above",
            "residual S_p",
            spread["S_p"],
        ),
        panel(
            diverging_picture(maps["S_g"], limits["S_g"]),
            f"Geometric detail of {name}, orange below zero, purple above",
            "geometric detail S_g",
            spread["S_g"],
        ),
        panel(
            photograph_picture(again, bright),
            f"Photograph of {name} put together again from albedo, coarse shading and residual",
            "A (coarse + S_p)",
            f"rms to I {difference:.0e}" if difference > 1e-12 else "equal to I",
        ),
    )


def relit_panels(name: str, built: BuiltObject, lights: list[LogHarmonics]) -> tuple[Panel, ...]:
    """Return the object under each light, the light shown on a sphere in a corner.

    Parameters
    ----------
    name : str
    built : BuiltObject
    lights : list of LogHarmonics

    Returns
    -------
    tuple of Panel
    """
    return tuple(
        panel(
            with_light(photograph_picture(built.model.relight(light)), light),
            f"{name} relit under other light {number}, which a white sphere in the corner shows",
            f"relit, light {number}",
        )
        for number, light in enumerate(lights, start=1)
    )
