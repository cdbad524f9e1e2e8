"""The commands of the rival method SIRFS: ``relightlab sirfs ...``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from reports.commands.options import DataRoot, JsonFile
from shading_model.errors import RelightlabError

if TYPE_CHECKING:
    from evaluation.sirfs.priors import SirfsPriors
    from reports.console import Report
    from shading_model.arrays import Float

app = typer.Typer(help="SIRFS, the rival method: shape, light and albedo from shading.")


@app.command("fit")
def fit_command(
    photograph: Annotated[Path, typer.Argument(metavar="PHOTO", help="8-bit or 16-bit picture.")],
    out: Annotated[Path, typer.Option(metavar="FILE", help="File to write, .npz.")],
    mask: Annotated[
        Path | None,
        typer.Option(help="Picture of the same size, above zero on the object; default: alpha."),
    ] = None,
    light: Annotated[
        str, typer.Option(help="Which lights are likely: 'laboratory' or 'natural'.")
    ] = "laboratory",
    channels: Annotated[str, typer.Option(help="Fit 'color', or 'gray': the mean.")] = "color",
    without: Annotated[
        list[str] | None,
        typer.Option(metavar="TERM", help="Leave this term of the loss out; again for more."),
    ] = None,
    depth: Annotated[
        Path | None,
        typer.Option(help="External depth, .npy in pixels, larger is nearer, NaN where unknown."),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Coarse to fine: a third of the time, less faithful.")
    ] = False,
    max_pixels: Annotated[
        int, typer.Option(help="Larger objects are reduced; 250000 take about a minute.")
    ] = 250_000,
) -> None:
    """Explain a photograph by shape, albedo, shading and light."""
    from datasets.photograph_files import load_photograph, saturation_notice
    from evaluation.sirfs.fit import EVALUATIONS, QUICK_EVALUATIONS, FitOptions, fit_sirfs
    from evaluation.sirfs.fit_files import save_fit
    from evaluation.sirfs.prior_files import shipped_priors
    from evaluation.sirfs.settings import term_weights
    from reports.commands.model import check_suffix
    from reports.console import progress, say
    from reports.result_files import require_writable

    check_suffix(out, (".npz",))
    term_weights(light, channels, tuple(without or ()))
    require_writable(out)
    taken, notice = load_photograph(photograph, mask, max_pixels=max_pixels)
    say(*filter(None, (notice, saturation_notice(taken))))
    options = FitOptions(
        light=light,
        channels=channels,
        without=tuple(without or ()),
        depth=None if depth is None else _depth(depth, taken.mask.shape),
        evaluations=QUICK_EVALUATIONS if quick else EVALUATIONS,
    )
    with progress("fitting") as report:
        fit = fit_sirfs(
            taken.image, taken.mask, shipped_priors(), options, progress=_LossProgress(report)
        )
    save_fit(out, fit)
    say(
        f"final loss {fit.final_loss:.4f} after {fit.evaluations:.0f} evaluations: {fit.stopped}",
        f"written: {out} ({int(fit.mask.sum())} pixels of {taken.mask.shape[1]}x"
        f"{taken.mask.shape[0]})",
    )


class _LossProgress:
    """Progress of a fit, with its loss and the time that is left at most.

    Parameters
    ----------
    report : Report
    """

    def __init__(self, report: Report) -> None:
        self._report = report
        self._started = time.monotonic()

    def __call__(self, done: float, most: float, loss: float) -> None:
        """Show how far the fit has come."""
        seconds = (time.monotonic() - self._started) * (most - done) / max(done, 1e-9)
        self._report(int(done), int(most), f"loss {loss:.4f}, at most {seconds:.0f} s left")


def _depth(path: Path, shape: tuple[int, ...]) -> Float:
    import numpy as np

    try:
        depth = np.asarray(np.load(path, allow_pickle=False), dtype=np.float64)
    except (OSError, ValueError) as error:
        raise RelightlabError(f"cannot read the depth in {path}: {error}") from error
    if depth.shape != shape:
        raise RelightlabError(
            f"expected depth of shape (h, w) = {shape}, the photograph's, got {depth.shape}"
        )
    return depth


@app.command("train")
def train_command(
    data: DataRoot = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Where to; default: the file every fit uses."),
    ] = None,
    json: JsonFile = None,
    search: Annotated[
        bool,
        typer.Option(
            "--search",
            help="Instead, leave one object out for several smoothnesses of the colour prior, and"
            " print how unlikely it is (6 min).",
        ),
    ] = False,
) -> None:
    """Learn the priors from the training objects of MIT-Berkeley again (2 min)."""
    from evaluation.sirfs.prior_files import FILE, SUFFIX, save_priors
    from evaluation.sirfs.prior_training import train_priors
    from reports.commands.model import check_suffix
    from reports.console import progress, say
    from reports.result_files import require_writable, write_json

    target = out or FILE
    check_suffix(target, (SUFFIX,))
    root = _set_folder(data)
    require_writable(*(() if search else (target,)), json)
    if search:
        _search(root, json)
        return
    started = time.monotonic()
    with progress("learning") as report:
        priors = train_priors(root, report)
    save_priors(target, priors)
    document = _document(priors) | {"seconds": round(time.monotonic() - started, 1)}
    say(*_lines(document))
    if json is not None:
        write_json(json, document)
        say(f"written: {json}")
    kilobytes = target.stat().st_size / 1000
    say(f"written: {target} ({kilobytes:.0f} kB, {document['seconds']:.0f} s)")


def _search(root: Path, json: Path | None) -> None:
    from datasets.mit_berkeley import MitBerkeley
    from evaluation.sirfs.smoothness_search import CANDIDATES, held_out_costs
    from evaluation.sirfs.training_data import training_samples
    from reports.console import progress, say
    from reports.result_files import write_json

    objects = [samples.color for samples in training_samples(MitBerkeley(root))]
    with progress("leaving out") as report:
        costs = held_out_costs(objects, CANDIDATES, report=report)
    pairs = [
        (weight, float(mean)) for weight, mean in zip(CANDIDATES, costs.mean(axis=1), strict=True)
    ]
    say(*(f"smoothness {weight:.3g}: held-out cost {mean:.4f}" for weight, mean in pairs))
    if json is not None:
        rows = [{"smoothness": weight, "held_out_cost": mean} for weight, mean in pairs]
        write_json(json, {"rows": rows})
        say(f"written: {json}")


def _set_folder(data: Path | None) -> Path:
    from datasets.locations import find_root_of, missing_data_sentence

    root = find_root_of("mit-berkeley", data)
    if root is None:
        raise RelightlabError(missing_data_sentence("mit-berkeley", data))
    return root / "mit-berkeley"


def _document(priors: SirfsPriors) -> dict[str, Any]:
    """Return what was learned, in numbers few enough to be read."""
    import numpy as np

    from evaluation.sirfs.absolute_albedo import gray_knots
    from evaluation.sirfs.priors import MIXTURES, priors_identity

    mixtures = {name: getattr(priors, name) for name in MIXTURES}
    return {
        "sha256": priors_identity(priors),
        "differences": {
            name: {"scales": mixture.scales.size, "largest": mixture.largest}
            for name, mixture in mixtures.items()
        },
        "gray_absolute": {
            "knots": [priors.gray_absolute.size],
            "least_at": float(gray_knots()[priors.gray_absolute.argmin()]),
        },
        "color_absolute": {
            "knots": list(priors.color_absolute.shape),
            "whitening": priors.color_whitening.tolist(),
        },
        "lights": {
            f"{light} {channels}": {
                "count": prior.count,
                "mean": prior.mean.tolist(),
                "standard_deviation": np.sqrt(prior.covariance.diagonal()).tolist(),
            }
            for (light, channels), prior in priors.lights.items()
        },
    }


def _lines(document: Mapping[str, Any]) -> list[str]:
    """Return the same in words: sizes, and the mean of the nine coefficients of gray lights."""
    lines = [
        f"{name.replace('_', ' ')}: {part['scales']} scales, tables up to {part['largest']:.4g}"
        for name, part in document["differences"].items()
    ]
    gray, color = document["gray_absolute"], document["color_absolute"]
    lines += [
        f"gray absolute: {gray['knots'][0]} knots, least at log albedo {gray['least_at']:.2f}",
        f"color absolute: {' x '.join(map(str, color['knots']))} knots",
    ]
    for name, light in document["lights"].items():
        shown = " (first channel)" if len(light["mean"]) > 9 else ""
        mean = " ".join(f"{value:.3f}" for value in light["mean"][:9])
        lines.append(f"{name} light: of {light['count']} lights, mean{shown} {mean}")
    return lines
