"""The command that says how many subjects a study needs: ``relightlab study power``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.commands.options import JsonFile, numbers_of
from reports.commands.study import StudyFile, app

if TYPE_CHECKING:
    from studies.power import Aim, PowerCurve, PowerModel


@app.command("power")
def power_command(
    file: StudyFile,
    rate: Annotated[
        float,
        typer.Option(metavar="R", help="True rate of a method to be shown to differ from 0.5."),
    ] = 0.6,
    methods: Annotated[
        str, typer.Option(metavar="R,R", help="True rates of two tasks to be shown to differ.")
    ] = "0.44,0.34",
    real: Annotated[
        float, typer.Option(metavar="R", help="True rate to be shown to be equivalent to 0.5.")
    ] = 0.5,
    margin: Annotated[
        float | None, typer.Option(metavar="M", help="Margin of equivalence; default: the study's.")
    ] = None,
    groups: Annotated[
        str, typer.Option(metavar="R,R", help="True rates of two groups to be shown to differ.")
    ] = "0.66,0.585",
    share: Annotated[
        float, typer.Option(metavar="S", help="Share of subjects in the first group.")
    ] = 0.2,
    subject_sd: Annotated[
        float, typer.Option(help="Standard deviation of subjects, in log odds.")
    ] = 0.5,
    item_sd: Annotated[float, typer.Option(help="Standard deviation of pairs, in log odds.")] = 0.3,
    power: Annotated[float, typer.Option(metavar="P", help="The power wanted.")] = 0.8,
    tests: Annotated[int, typer.Option(help="Tests that are corrected together.")] = 1,
    loss: Annotated[
        float, typer.Option(metavar="S", help="Share of subjects that will be left out.")
    ] = 0.0,
    draws: Annotated[int, typer.Option(help="Simulated studies of each aim.")] = 2000,
    seed: Annotated[int, typer.Option(help="What the studies are drawn with.")] = 0,
    figure: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw the curves, as .svg."),
    ] = None,
    json: JsonFile = None,
) -> None:
    """Say how many subjects a study needs, and with what power fewer would do."""
    from reports.console import progress, say
    from reports.result_files import require_writable, write_json
    from studies.power import Aim, model_of, power_curve
    from studies.power_simulation import SCOPES
    from studies.study_file import load_study

    study = load_study(file)
    _check_loss(loss)
    require_writable(figure, json)
    limit = study.analysis.equivalence_margin if margin is None else margin
    two, pair = numbers_of(methods, 2, "--methods"), numbers_of(groups, 2, "--groups")
    aims = (
        Aim(f"difference: {rate:g} from 0.5", (rate,)),
        Aim(f"difference: {two[0]:g} from {two[1]:g}, two tasks", two),
        Aim(f"equivalence: {real:g} within {limit:g} of 0.5", (real,), margin=limit),
        Aim(f"subpopulations: {pair[0]:g} ({share:.0%}) from {pair[1]:g}", pair, share=share),
    )
    model = model_of(study, subject_sd=subject_sd, item_sd=item_sd, tests=tests)
    cases = [(aim, scope) for aim in aims for scope in SCOPES]
    curves = []
    with progress("simulating studies") as report:
        for done, (aim, scope) in enumerate(cases, 1):
            curves.append(power_curve(aim, model, scope, wanted=power, draws=draws, seed=seed))
            report(done, len(cases), aim.name)
    say(*_head(model, draws))
    _print_needed(curves, loss, len(study.tasks))
    for aim in aims:
        _print_curve(aim, [curve for curve in curves if curve.aim == aim.name])
    if figure is not None:
        from reports.power_figure import write_power_figure

        write_power_figure(figure, curves)
        say(f"written: {figure}")
    if json is not None:
        write_json(json, _document(study.hash, model, curves, loss, draws, seed))
        say(f"written: {json}")


def _check_loss(loss: float) -> None:
    from shading_model.errors import RelightlabError

    if not 0 <= loss < 1:
        raise RelightlabError(f"expected --loss to be a share from 0 to below 1, got {loss:g}")


def _head(model: PowerModel, draws: int) -> list[str]:
    from studies.power_simulation import SCOPES

    level = f"level {model.alpha:g}" + (f" / {model.tests}" if model.tests > 1 else "")
    return [
        (
            f"{model.shown} trials of {model.pairs} pairs, {level}, standard deviation of subjects"
            f" {model.subject_sd:g} and of pairs {model.item_sd:g} (log odds), {draws} simulated"
            " studies"
        ),
        f"{SCOPES[0]}: the result holds for these pairs; tested over subjects",
        f"{SCOPES[1]}: it holds for pairs like them; tested over subjects and pairs",
    ]


def _print_needed(curves: Sequence[PowerCurve], loss: float, tasks: int) -> None:
    from reports.console import print_table, say

    rows = [
        [
            curve.aim,
            curve.scope,
            "not reached" if curve.needed is None else str(curve.needed),
            _range(curve),
            _recruited(curve.needed, loss),
            "-" if curve.needed is None else _recruited(curve.needed * tasks, loss),
        ]
        for curve in curves
    ]
    title = f"Subjects in each task for a power of {curves[0].wanted:g}"
    names = ["to show", "for", "subjects", "Monte Carlo, 95 %", "to recruit", f"{tasks} tasks"]
    print_table(title, names, rows)
    if any(curve.needed is None for curve in curves):
        say("not reached: beyond the last size of its curve; where that is level, take more pairs")


def _print_curve(aim: Aim, curves: Sequence[PowerCurve]) -> None:
    from reports.console import print_table

    sizes = sorted({point.subjects for curve in curves for point in curve.points})
    found = [{point.subjects: point for point in curve.points} for curve in curves]
    rows = [
        [
            str(size),
            *(
                f"{own[size].power:.3f} ± {own[size].error:.3f}" if size in own else ""
                for own in found
            ),
        ]
        for size in sizes
    ]
    print_table(
        f"Power ± Monte-Carlo standard error, {aim.name}",
        ["subjects", *(curve.scope for curve in curves)],
        rows,
    )


def _range(curve: PowerCurve) -> str:
    if curve.needed_low is None:
        return "-"
    return f"{curve.needed_low} to {curve.needed_high or 'not reached'}"


def _recruited(needed: int | None, loss: float) -> str:
    import math

    return "-" if needed is None else str(math.ceil(needed / (1 - loss) - 1e-9))


def _document(
    study_hash: str,
    model: PowerModel,
    curves: Sequence[PowerCurve],
    loss: float,
    draws: int,
    seed: int,
) -> dict[str, object]:
    from dataclasses import asdict

    about = {"study_hash": study_hash, "draws": draws, "seed": seed, "loss": loss}
    return about | {"model": asdict(model), "curves": [curve.document() for curve in curves]}
