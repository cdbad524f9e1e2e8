"""The commands for one object: ``relightlab model ...``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.commands.options import numbers_of
from shading_model.errors import RelightlabError, unknown_name

if TYPE_CHECKING:
    from shading_model.arrays import Float, Image, Mask
    from shading_model.illumination import Illumination
    from shading_model.object_model import ModelParameters, ObjectModel

BACKGROUNDS = ("black", "transparent")

app = typer.Typer(help="Build a relightable object from one photograph, and relight it.")


@app.command("build")
def build_command(
    photograph: Annotated[Path, typer.Argument(metavar="PHOTO", help="8-bit or 16-bit picture.")],
    out: Annotated[Path, typer.Option(help="Model file to write, .npz.")],
    mask: Annotated[
        Path | None,
        typer.Option(help="Picture of the same size, above zero on the object; default: alpha."),
    ] = None,
    gray_threshold: Annotated[
        float | None, typer.Option(help="Change of log brightness that is albedo.")
    ] = None,
    chromaticity_threshold: Annotated[
        float | None, typer.Option(help="Change of log chromaticity that is albedo.")
    ] = None,
    slope_limit: Annotated[
        float | None, typer.Option(help="Least N_z in the height equation.")
    ] = None,
    shading: Annotated[
        Path | None, typer.Option(help="Known shading (picture or .exr) instead of Retinex.")
    ] = None,
    max_pixels: Annotated[
        int,
        typer.Option(help="Larger objects are reduced; a million take about 15 s and 1.3 GB."),
    ] = 1_000_000,
) -> None:
    """Build an object model from a photograph and its mask."""
    from datasets.model_files import save_model
    from datasets.photograph_files import load_photograph, saturation_notice
    from reports.console import progress, say
    from shading_model.object_model import build_model, contour_base

    check_suffix(out, (".npz",))
    parameters = _parameters(gray_threshold, chromaticity_threshold, slope_limit)
    taken, notice = load_photograph(photograph, mask, max_pixels=max_pixels)
    say(*filter(None, (notice, saturation_notice(taken))))
    known = None if shading is None else _shading(shading, taken.mask, notice)
    with progress("building") as report:
        report(0, 2, "contour shape")
        shape = contour_base(taken.mask, parameters)
        report(1, 2, "contour shape")
        model = build_model(taken.image, taken.mask, parameters, shape=shape, shading=known)
        report(2, 2, "albedo, light and detail")
    save_model(out, model, name=taken.name, source=taken.source)
    height, width = model.mask.shape
    say(f"written: {out} ({width}x{height} pixels, {int(model.mask.sum())} on the object)")


@app.command("relight")
def relight_command(
    model_file: Annotated[Path, typer.Argument(metavar="MODEL", help="Made by 'model build'.")],
    out: Annotated[Path, typer.Option(help="Picture to write: .png, .jpg or .exr.")],
    light: Annotated[
        str | None,
        typer.Option(help="'fitted', a natural light such as apartment-72, or a .json file."),
    ] = None,
    direction: Annotated[
        str | None,
        typer.Option(metavar="X,Y,Z", help="Toward a distant light: right, up, to the viewer."),
    ] = None,
    intensity: Annotated[
        float | None, typer.Option(help="Of the distant light; default: 1.")
    ] = None,
    coefficients: Annotated[
        str | None, typer.Option(metavar="C1,...,C9", help="Nine harmonics, or 27 for colour.")
    ] = None,
    convention: Annotated[
        str | None, typer.Option(help="Of the coefficients: 'log' (default) or 'linear'.")
    ] = None,
    weights: Annotated[
        str, typer.Option(metavar="W_P,W_G", help="Weights of the two detail layers.")
    ] = "1,1",
    exposure: Annotated[
        float | None, typer.Option(help="Factor on the picture; default: so that nothing clips.")
    ] = None,
    background: Annotated[str, typer.Option(help="'black' or 'transparent'.")] = "black",
) -> None:
    """Relight an object model and write a picture of it."""
    from datasets.model_files import load_model
    from reports.console import say
    from shading_model.object_model import Weights

    if background not in BACKGROUNDS:
        raise unknown_name("background", background, BACKGROUNDS)
    check_suffix(
        out, (".png",) if background == "transparent" else (".png", ".jpg", ".jpeg", ".exr")
    )
    layers = Weights(*numbers_of(weights, 2, "--weights"))
    model = load_model(model_file)
    chosen = _light(model, light, direction, intensity, coefficients, convention)
    image = model.relight(chosen, layers)
    factor = _exposure(image, exposure, out)
    _write(out, factor * image, model.mask if background == "transparent" else None)
    say(f"exposure: {factor:.4g}{'' if exposure else _why(factor)}", f"written: {out}")


def check_suffix(path: Path, suffixes: tuple[str, ...]) -> None:
    """Refuse a name that does not say a format that can be written, before any work is done.

    Parameters
    ----------
    path : Path
    suffixes : tuple of str

    Raises
    ------
    RelightlabError
        If the name ends in none of the suffixes.

    Examples
    --------
    >>> check_suffix(Path("a.png"), (".png", ".jpg"))
    """
    if path.suffix.lower() not in suffixes:
        raise RelightlabError(f"expected --out to end in {' or '.join(suffixes)}, got {path}")


def _parameters(
    gray: float | None, chromaticity: float | None, slope_limit: float | None
) -> ModelParameters:
    from dataclasses import replace

    from datasets.model_parameters import shipped_parameters

    shipped = shipped_parameters()
    given = {"gray": gray, "chromaticity": chromaticity}
    chosen = {name: value for name, value in given.items() if value is not None}
    if any(not value >= 0 for value in chosen.values()):
        raise RelightlabError("expected Retinex thresholds of at least zero")
    if slope_limit is not None and not 0 < slope_limit <= 1:
        raise RelightlabError(f"expected a slope limit above 0 and at most 1, got {slope_limit}")
    return replace(
        shipped,
        thresholds=replace(shipped.thresholds, **chosen),
        slope_limit=shipped.slope_limit if slope_limit is None else slope_limit,
    )


def _shading(path: Path, mask: Mask, notice: str | None) -> Float:
    from datasets.image_files import read_image
    from datasets.openexr_files import read_openexr

    shading = read_openexr(path) if path.suffix.lower() == ".exr" else read_image(path)
    (height, width), (rows, columns) = shading.shape[:2], mask.shape
    if (height, width) != (rows, columns):
        changed = f" ({notice}: a larger --max-pixels leaves it whole)" if notice else ""
        raise RelightlabError(
            f"the shading {path} is {width}x{height} pixels but the model is built from"
            f" {columns}x{rows}{changed}: give a shading of that size"
        )
    return shading


def _light(
    model: ObjectModel,
    name: str | None,
    direction: str | None,
    intensity: float | None,
    coefficients: str | None,
    convention: str | None,
) -> Illumination:
    import numpy as np

    from reports.light_choice import FITTED, distant_light, harmonic_light, named_light

    if sum(given is not None for given in (name, direction, coefficients)) > 1:
        raise RelightlabError("give one of --light, --direction and --coefficients, not several")
    if intensity is not None and direction is None:
        raise RelightlabError("--intensity is that of a distant light: give its --direction too")
    if convention is not None and coefficients is None:
        raise RelightlabError("--convention is that of --coefficients: give them too")
    if direction is not None:
        toward = np.array(numbers_of(direction, 3, "--direction"))
        return distant_light(toward, 1.0 if intensity is None else intensity, model)
    if coefficients is not None:
        count = 27 if coefficients.count(",") == 26 else 9
        numbers = numbers_of(coefficients, count, "--coefficients")
        return harmonic_light(np.array(numbers), convention or "log")
    return named_light(name or FITTED, model)


def _exposure(image: Image, given: float | None, out: Path) -> float:
    import numpy as np

    if given is not None:
        if not 0 < given < float("inf"):
            raise RelightlabError(f"expected an exposure above zero, got {given}")
        return given
    brightest = float(np.nanmax(image))
    return 1.0 if out.suffix.lower() == ".exr" or brightest <= 1 else 1 / brightest


def _why(factor: float) -> str:
    return (
        " (nothing clips)" if factor == 1 else " (so that the brightest pixel just does not clip)"
    )


def _write(out: Path, image: Image, opaque: Mask | None) -> None:
    import numpy as np

    from datasets.image_files import write_image
    from datasets.openexr_files import write_openexr

    if out.suffix.lower() == ".exr":
        write_openexr(out, np.nan_to_num(image, nan=0.0))
    else:
        write_image(out, image, opaque=opaque)
