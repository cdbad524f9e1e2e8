"""The commands for light probes: ``relightlab probe ...``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports.commands.options import JsonFile, numbers_of
from shading_model.errors import RelightlabError

if TYPE_CHECKING:
    from datasets.probe_files import ProbePicture
    from shading_model.arrays import Float
    from shading_model.chrome_probe import ChromeProbe
    from shading_model.diffuse_probe import DiffuseProbe
    from shading_model.probe_sphere import ProbeSphere

COLOURS = ("red", "green", "blue")

Images = Annotated[
    list[Path],
    typer.Argument(metavar="IMAGE...", help="8-bit, 16-bit or .exr pictures of one sphere."),
]
MaskFile = Annotated[
    Path, typer.Option("--mask", help="Picture of the same size, above zero on the sphere.")
]
Linear = Annotated[
    bool, typer.Option("--linear", help="Take eight-bit values for linear, not for sRGB.")
]

app = typer.Typer(help="Measure the light that a photographed sphere was under.")


@app.command("diffuse")
def diffuse_command(
    images: Images,
    mask: MaskFile,
    json: JsonFile = None,
    linear: Linear = False,
    albedo: Annotated[
        str, typer.Option(metavar="A|R,G,B", help="Of the sphere, above 0 and at most 1.")
    ] = "1",
    fit: Annotated[
        str,
        typer.Option(
            help="'least-squares', refused under rank 9; 'minimum-norm'; or 'ridge', which damps."
        ),
    ] = "least-squares",
    ridge: Annotated[float, typer.Option(help="Strength of the fit 'ridge'.")] = 1e-3,
) -> None:
    """Fit nine coefficients of each colour to pictures of a matt sphere."""
    from reports.console import print_table
    from shading_model.diffuse_probe import fit_diffuse_probe

    paint = _albedo(albedo)

    def measure(picture: ProbePicture, inside: Any, sphere: ProbeSphere) -> DiffuseProbe:
        return fit_diffuse_probe(
            picture.image,
            inside,
            albedo=paint,
            method=fit,
            ridge=ridge,
            saturated=picture.saturated,
            sphere=sphere,
        )

    probes, sphere = _measured(images, mask, json, linear, measure)
    names = [path.name for path in images]
    print_table(
        f"Light of a matt sphere of radius {sphere.radius:.2f} pixels at row {sphere.row:.2f},"
        f" column {sphere.column:.2f}",
        (
            "image",
            "residual %",
            "log %",
            "rank",
            "condition",
            "x",
            "y",
            "z",
            "pixels",
            "saturated %",
        ),
        [(name, *_diffuse_entries(probe)) for name, probe in zip(names, probes, strict=True)],
    )
    print_table(
        "One distant light in its place",
        ("image", "residual %", "x", "y", "z", "intensity"),
        [(name, *_distant_entries(probe)) for name, probe in zip(names, probes, strict=True)],
    )
    print_table(
        "Irradiance coefficients" + ("" if len(probes) == 1 else ", mean of the colours"),
        ("light", *(f"L{index}" for index in range(1, 10))),
        _coefficient_rows(names, probes),
    )
    if json is not None:
        rows = [_diffuse_row(path, probe) for path, probe in zip(images, probes, strict=True)]
        _write(json, "diffuse", mask, sphere, rows)


@app.command("chrome")
def chrome_command(
    images: Images, mask: MaskFile, json: JsonFile = None, linear: Linear = False
) -> None:
    """Find the direction of a distant light from its highlight on a mirror sphere."""
    from reports.console import print_table
    from shading_model.chrome_probe import chrome_direction

    def measure(picture: ProbePicture, inside: Any, sphere: ProbeSphere) -> ChromeProbe:
        return chrome_direction(picture.image, inside, sphere=sphere)

    probes, sphere = _measured(images, mask, json, linear, measure)
    print_table(
        f"Highlights on a mirror sphere of radius {sphere.radius:.2f} pixels at row"
        f" {sphere.row:.2f}, column {sphere.column:.2f}",
        ("image", "x", "y", "z", "row", "column", "area", "degrees per pixel"),
        [(path.name, *_chrome_entries(probe)) for path, probe in zip(images, probes, strict=True)],
    )
    if json is not None:
        rows = [_chrome_row(path, probe) for path, probe in zip(images, probes, strict=True)]
        _write(json, "chrome", mask, sphere, rows)


def _measured(
    images: Sequence[Path],
    mask: Path,
    json: Path | None,
    linear: bool,
    measure: Callable[[ProbePicture, Any, ProbeSphere], Any],
) -> tuple[list[Any], ProbeSphere]:
    """Measure every picture on the one mask's sphere; a fault names the picture."""
    from datasets.image_files import read_mask
    from datasets.probe_files import read_probe_picture
    from reports.result_files import require_writable
    from shading_model.probe_sphere import fit_sphere

    require_writable(json)
    inside = read_mask(mask)
    sphere = fit_sphere(inside)
    probes = []
    for path in images:
        picture = read_probe_picture(path, linear=linear)
        try:
            probes.append(measure(picture, inside, sphere))
        except RelightlabError as error:
            raise RelightlabError(f"{path}: {error}") from error
    return probes, sphere


def _albedo(text: str) -> Float:
    import numpy as np

    numbers = numbers_of(text, 3 if "," in text else 1, "--albedo")
    return np.array(numbers if len(numbers) == 3 else numbers[0])


def _diffuse_entries(probe: DiffuseProbe) -> tuple[str, ...]:
    return (
        f"{100 * probe.residual:.2f}",
        _percent(probe.log_residual),
        str(probe.rank),
        f"{probe.condition:.1f}",
        *_numbers(probe.direction, 4),
        str(probe.pixels),
        f"{100 * probe.saturated_share:.2f}",
    )


def _distant_entries(probe: DiffuseProbe) -> tuple[str, ...]:
    light = probe.distant
    if light is None:
        return ("-",) * 5
    return _percent(light.residual), *_numbers(light.direction, 4), f"{light.intensity:.4f}"


def _chrome_entries(probe: ChromeProbe) -> tuple[str, ...]:
    return (
        *_numbers(probe.direction, 4),
        *_numbers((probe.row, probe.column), 2),
        str(probe.area),
        f"{probe.degrees_per_pixel:.2f}",
    )


def _coefficient_rows(
    names: Sequence[str], probes: Sequence[DiffuseProbe]
) -> list[tuple[str, ...]]:
    if len(probes) == 1:
        colours = probes[0].linear.coefficients.T
        return [(name, *_numbers(values, 4)) for name, values in zip(COLOURS, colours, strict=True)]
    return [
        (name, *_numbers(probe.linear.monochrome().coefficients, 4))
        for name, probe in zip(names, probes, strict=True)
    ]


def _numbers(values: Float | Sequence[float] | None, digits: int) -> tuple[str, ...]:
    return ("-",) * 3 if values is None else tuple(f"{value:.{digits}f}" for value in values)


def _percent(share: float) -> str:
    return "-" if math.isnan(share) else f"{100 * share:.2f}"


def _diffuse_row(path: Path, probe: DiffuseProbe) -> dict[str, Any]:
    distant = probe.distant
    return {
        "image": path.name,
        "convention": "linear",
        "coefficients": probe.linear.coefficients.tolist(),
        "log_coefficients": None if probe.log is None else probe.log.coefficients.tolist(),
        "residual": probe.residual,
        "log_residual": None if probe.log is None else probe.log_residual,
        "rank": probe.rank,
        "condition": probe.condition,
        "direction": _list(probe.direction),
        "distant_direction": None if distant is None else _list(distant.direction),
        "distant_intensity": None if distant is None else distant.intensity,
        "distant_residual": None if distant is None else distant.residual,
        "pixels": probe.pixels,
        "saturated_share": probe.saturated_share,
    }


def _chrome_row(path: Path, probe: ChromeProbe) -> dict[str, Any]:
    return {
        "image": path.name,
        "direction": _list(probe.direction),
        "normal": _list(probe.normal),
        "row": probe.row,
        "column": probe.column,
        "area": probe.area,
        "share": probe.share,
        "degrees_per_pixel": probe.degrees_per_pixel,
    }


def _list(values: Float | None) -> list[float] | None:
    return None if values is None else values.tolist()


def _write(
    file: Path, probe: str, mask: Path, sphere: ProbeSphere, rows: list[dict[str, Any]]
) -> None:
    """Write the rows; of a single diffuse picture the file is also a light for 'model relight'."""
    from dataclasses import asdict

    from reports.result_files import write_json

    keys = ("convention", "coefficients")
    light = {key: rows[0][key] for key in keys if len(rows) == 1 and key in rows[0]}
    document = {"probe": probe, **light, "mask": mask.name, "sphere": asdict(sphere), "rows": rows}
    write_json(file, document)
