"""What SIRFS makes of one photograph, beside the truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from datasets.records import Capture
from evaluation.sirfs.metrics import SirfsErrors, sirfs_errors
from evaluation.sirfs.result import SirfsFit
from reports.figures import Panel, PanelFigure, PanelRow, Scale, panel
from reports.pictures import (
    Picture,
    diverging_picture,
    normal_picture,
    photograph_picture,
    sphere_picture,
    symmetric_limit,
)
from reports.side_view import Surface, clay_pictures
from shading_model.arrays import Float, Map, Normals
from shading_model.errors import RelightlabError
from shading_model.illumination import LogHarmonics

SIDES = {"front": "from the front", "left": "from the left", "below": "from below"}
LOG_ALBEDO = "log albedo, fitted - true"
NOTES = {
    "albedo": ("r-MSE", "r_mse"),
    "shading": ("s-MSE", "s_mse"),
    "light": ("L-MSE", "l_mse"),
    "normals": ("N-MAE", "n_mae"),
    "front": ("Z-MAE", "z_mae"),
}
"""The error shown below a picture: its name, and the field of `SirfsErrors`."""


@dataclass(frozen=True, eq=False)
class _Maps:
    """What a fit and the truth have in common; a part of the truth may be unknown."""

    whose: str
    albedo: Float | None
    shading: Float | None
    light: LogHarmonics | None
    height: Map | None
    normals: Normals | None
    errors: SirfsErrors | None = None

    def note(self, picture: str) -> str:
        """Return the error that belongs to a picture, in words; empty for the truth."""
        words, field = NOTES.get(picture, ("", ""))
        value = getattr(self.errors, field, np.nan) if field else np.nan
        return f"{words} {significant(value)}" if np.isfinite(value) else ""


def sirfs_figure(fit: SirfsFit, capture: Capture) -> PanelFigure:
    """Return photograph, albedo, shading, light and shape of a fit, beside those of the truth.

    Parameters
    ----------
    fit : SirfsFit
    capture : Capture
        The photograph that was fitted, and what is known of its truth.

    Returns
    -------
    PanelFigure
        Without the parts of the truth that are not known.

    Raises
    ------
    RelightlabError
        If the photograph has another size than the fit.
    """
    name, photograph = capture.photograph.name, capture.photograph
    if photograph.mask.shape != fit.mask.shape:
        raise RelightlabError(
            f"the fit is of shape {fit.mask.shape} but its photograph of {photograph.mask.shape}"
        )
    both = (_fitted_maps(fit, capture), _true_maps(fit, capture))
    image = np.where(fit.mask[..., None], photograph.image, np.nan)
    seen = panel(photograph_picture(image), f"Photograph of {name}", "photograph I")
    rows = [
        PanelRow(f"{name}: fitted", (seen, *_image_panels(name, both[0])), 4),
        _true_row(name, *both),
        *_shape_rows(name, [maps for maps in both if maps.height is not None]),
    ]
    return PanelFigure(
        "sirfs-fit",
        "A photograph fitted by SIRFS",
        f"The {capture.setting} photograph of {name}. Fitted albedo times fitted shading is the"
        " photograph exactly, so that what one of them leaves out is in the other; the map of"
        " both albedos shows what. The sphere shows the light. Shapes are drawn as white clay,"
        " without perspective, fitted and true at one scale. Photographs, albedos and shadings have"
        " exposures of their own; errors are those of the table.",
        tuple(row for row in rows if row.panels),
    )


def significant(value: float | None, digits: int = 3) -> str:
    """Return a number with some significant digits and no exponent, a dash for None or NaN.

    Parameters
    ----------
    value : float or None
    digits : int

    Returns
    -------
    str

    Examples
    --------
    >>> [significant(value) for value in (22.857, 0.4, 0.0003146, None)]
    ['22.9', '0.400', '0.000315', '–']
    """
    if value is None or not np.isfinite(value):
        return "–"  # noqa: RUF001  an en dash: no value
    text = np.format_float_positional(value, digits, unique=False, fractional=False, trim="k")
    return text.removesuffix(".")


def _fitted_maps(fit: SirfsFit, capture: Capture) -> _Maps:
    maps = (fit.albedo, fit.shading, fit.illumination, fit.height, fit.normals)
    return _Maps("fitted", *maps, sirfs_errors(fit, capture.truth))


def _true_maps(fit: SirfsFit, capture: Capture) -> _Maps:
    truth, channels = capture.truth, fit.albedo.shape[-1]
    light = truth.illumination
    return _Maps(
        "true",
        _in_channels(truth.albedo, channels),
        _in_channels(truth.shading, channels),
        light.monochrome() if light is not None and channels == 1 else light,
        truth.height,
        truth.normals,
    )


def _in_channels(values: Float | None, channels: int) -> Float | None:
    return values if values is None or channels == 3 else values.mean(axis=-1, keepdims=True)


def _image_panels(name: str, maps: _Maps) -> Iterator[Panel]:
    """Yield albedo, shading and light, as far as they are known."""
    for words, values in (("albedo", maps.albedo), ("shading", maps.shading)):
        if values is not None:
            shown = photograph_picture(values[..., 0] if values.shape[-1] == 1 else values)
            yield _panel(shown, f"{words} of {name}", words, maps)
    if maps.light is not None and maps.shading is not None:
        sphere = sphere_picture(maps.light, *maps.shading.shape[:2])
        yield _panel(sphere, f"light of {name} on a white sphere", "light", maps)


def _panel(picture: Picture, what: str, caption: str, maps: _Maps, key: str = "") -> Panel:
    words = f"{maps.whose.capitalize()} {what}"
    return panel(picture, words, f"{caption}, {maps.whose}", maps.note(key or caption))


def _true_row(name: str, ours: _Maps, true: _Maps) -> PanelRow:
    """Return the true images, after a map of where the fitted albedo departs from the true."""
    panels = tuple(_image_panels(name, true))
    if ours.albedo is None or true.albedo is None:
        return PanelRow(f"{name}: true", panels, 4)
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = (np.log(ours.albedo) - np.log(true.albedo)).mean(axis=-1)
    apart = np.where(np.isfinite(apart), apart, np.nan)
    apart = apart - np.nanmedian(apart)
    limit = symmetric_limit(apart)
    words = f"Fitted over true albedo of {name}, orange too dark, purple too bright"
    compared = panel(diverging_picture(apart, limit), words, "albedo, fitted over true")
    return PanelRow(f"{name}: true", (compared, *panels), 4, (Scale(limit, LOG_ALBEDO),))


def _shape_rows(name: str, known: Sequence[_Maps]) -> Iterator[PanelRow]:
    """Yield a row of pictures of each shape: its normals, and clay seen from all sides."""
    surfaces = [
        Surface(maps.height, maps.normals)
        for maps in known
        if maps.height is not None and maps.normals is not None
    ]
    views = {side: clay_pictures(surfaces, side) for side in SIDES}
    for place, (maps, surface) in enumerate(zip(known, surfaces, strict=True)):
        normals = _panel(
            normal_picture(surface.normals),
            f"normals of {name}: red right, green up, blue toward the viewer",
            "normals",
            maps,
        )
        clay = (
            _panel(views[side][place], f"shape of {name} {words}", words, maps, side)
            for side, words in SIDES.items()
        )
        yield PanelRow(f"{name}: {maps.whose} shape", (normals, *clay), 4)
