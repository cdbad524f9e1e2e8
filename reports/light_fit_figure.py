"""Nine spherical harmonics against five point lights as the fitted light (`fig:SHlight`)."""

from __future__ import annotations

import numpy as np

from reports.figures import PanelFigure, PanelRow, Scale, panel
from reports.pictures import (
    diverging_picture,
    exposure,
    photograph_picture,
    symmetric_limit,
)
from reports.subject import BuiltObject, Subject
from shading_model.arrays import Map
from shading_model.illumination_fit import fit_harmonics

PREFERRED = ("raccoon", "sun", "turtle", "dinosaur", "pear")
OBJECTS = 5


def light_fit_figure(subject: Subject) -> PanelFigure:
    """Return the input shading, both fits and both residuals of several objects.

    Parameters
    ----------
    subject : Subject

    Returns
    -------
    PanelFigure
    """
    setting = subject.photographed_setting
    names = subject.preferred(PREFERRED, OBJECTS)
    return PanelFigure(
        "light-fits",
        "Spherical harmonics against point lights",
        f"After the paper's `fig:SHlight`, on the {setting} photographs. (a) Retinex shading; (b)"
        " nine spherical harmonics and (c) five point lights, both fitted to (a) on the contour"
        " shape; (d) = (a) - (b); (e) = (a) - (c), the parametric residual S_p. Below each residual"
        " is its root mean square; the mean shading of every object is 0.5.",
        tuple(_row(name, subject.built(name, setting)) for name in names),
    )


def _row(name: str, built: BuiltObject) -> PanelRow:
    model, shading = built.model, built.parts.shading
    harmonic = fit_harmonics(shading, model.normals).illumination.shade(model.normals)
    points = model.illumination.shade(model.normals, model.height)
    missed = {"spherical harmonics": shading - harmonic, "point lights": shading - points}
    limit = symmetric_limit(*missed.values())
    own = exposure(shading)
    fits = [("a", "Input shading", "S", shading), ("b", "Nine harmonics", "SH fit", harmonic)]
    fits.append(("c", "Five point lights", "point-light fit", points))
    return PanelRow(
        name,
        (
            *(
                panel(photograph_picture(values, own), f"{words}, {name}", f"({key}) {caption}")
                for key, words, caption, values in fits
            ),
            *(
                panel(
                    diverging_picture(values, limit),
                    f"Shading of {name} that {what} miss, orange below zero, purple above",
                    f"({key}) missed by {what}",
                    f"rms {_root_mean_square(values):.3f}",
                )
                for key, (what, values) in zip("de", missed.items(), strict=True)
            ),
        ),
        5,
        (Scale(limit, "shading"),),
    )


def _root_mean_square(values: Map) -> float:
    return float(np.sqrt(np.nanmean(values**2)))
