"""The commands that hold results to their record: ``relightlab gate ...``."""
# ruff: noqa: PLC0415  what a command needs is imported when it runs, so that --help is quick

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reports.commands.options import DataRoot, JsonFile, Workers

if TYPE_CHECKING:
    from evaluation.gate_measurement import GateMeasurement
    from evaluation.regression_gate import Change, Comparison

WORSE = 1
"""Exit code of a check that found a cell worse."""
SHOWN = 10

Chosen = Annotated[
    str | None,
    typer.Option(
        "--dataset", help="synthetic or mit-berkeley; by default both, where they are found."
    ),
]
Records = Annotated[
    Path | None,
    typer.Option("--records", metavar="DIR", help="Folder of the records; default: the project's."),
]

app = typer.Typer(help="Record results cell by cell, and hold later ones to them.")


@app.command("check")
def check_command(
    dataset: Chosen = None,
    data: DataRoot = None,
    records: Records = None,
    workers: Workers = 2,
    json: JsonFile = None,
) -> None:
    """Measure again and compare with the record; exit code 1 if any cell is worse."""
    import time

    from evaluation.gate_baseline import FOLDER, read_baseline
    from evaluation.regression_gate import compare
    from reports.console import say
    from reports.result_files import write_json

    folder = records or FOLDER
    root, names = _found(dataset, data)
    baselines = {name: read_baseline(name, folder) for name in names}
    comparisons = []
    for name, baseline in baselines.items():
        started = time.monotonic()
        comparison = compare(baseline, _measure(name, root, workers))
        comparisons.append(comparison)
        recorded = f"record of {baseline.date} ({baseline.reason})"
        say(*_check_lines(comparison, recorded, time.monotonic() - started))
    if json is not None:
        write_json(json, {"comparisons": [one.document() for one in comparisons]})
        say(f"written: {json}")
    if not all(one.passed for one in comparisons):
        raise typer.Exit(WORSE)


@app.command("record")
def record_command(
    reason: Annotated[str, typer.Option(help="Why these results are the new standard.")],
    dataset: Chosen = None,
    data: DataRoot = None,
    records: Records = None,
    workers: Workers = 2,
) -> None:
    """Make the results of the code as it is the record that later ones are held to."""
    from datetime import UTC, datetime

    from evaluation.gate_baseline import FOLDER, baseline_path, new_baseline, write_baseline
    from reports.console import say
    from shading_model.errors import RelightlabError

    if not reason.strip():
        raise RelightlabError("expected --reason to say why these results are the new standard")
    folder = records or FOLDER
    root, names = _found(dataset, data)
    for name in names:
        measured = _measure(name, root, workers)
        baseline = new_baseline(measured, reason, f"{datetime.now(UTC):%Y-%m-%d}")
        if baseline_path(name, folder).exists():
            say(*_lines_before_recording(measured, folder))
        say(f"written: {write_baseline(baseline, folder)} ({measured.size} errors)")


def _found(dataset: str | None, data: Path | None) -> tuple[Path | None, tuple[str, ...]]:
    """Return the data root and the sets to measure, and say which is not here."""
    from datasets.locations import find_data_root, missing_data_sentence
    from evaluation.gate_measurement import SETS, checked_set
    from reports.console import say
    from shading_model.errors import RelightlabError

    wanted = SETS if dataset is None else (checked_set(dataset),)
    if "mit-berkeley" not in wanted:
        return None, wanted
    root = find_data_root(data)
    if root is not None and (root / "mit-berkeley").is_dir():
        return root, wanted
    missing = missing_data_sentence("mit-berkeley")
    if dataset is not None:
        raise RelightlabError(missing)
    say(f"{missing}; only the synthetic set is measured")
    return None, ("synthetic",)


def _measure(name: str, root: Path | None, workers: int) -> GateMeasurement:
    import tempfile

    from evaluation.gate_measurement import measure_gate, mit_gate_set, synthetic_gate_set
    from reports.console import progress

    with tempfile.TemporaryDirectory() as folder:
        if name == "mit-berkeley" and root is not None:
            subject = mit_gate_set(root)
        else:
            with progress("making the synthetic set") as report:
                subject = synthetic_gate_set(Path(folder), workers, report)
        with progress(f"measuring {name}") as report:
            return measure_gate(subject, workers, report)


def _check_lines(comparison: Comparison, recorded: str, seconds: float) -> list[str]:
    from evaluation.regression_gate import FIT_ELSEWHERE

    verdict = (
        f"{comparison.dataset}: {comparison.compared} errors compared with the {recorded},"
        f" tolerance {comparison.tolerance:g}, {seconds:.0f} s:"
        f" {len(comparison.worse)} worse, {len(comparison.better)} better"
    )
    lines = [verdict]
    if comparison.differing:
        lines.append(f"  another platform: {'; '.join(comparison.differing)}")
        lines.append(f"  tolerance of what SIRFS fits there: {FIT_ELSEWHERE:g}")
    lines += [f"  not measured: {reason}" for reason in comparison.reasons]
    lines += _change_lines("worse", comparison.worse)
    lines += _change_lines("better", comparison.better)
    if comparison.better and comparison.passed:
        lines.append(
            "  results improved and the record does not say so: if that was meant, run"
            f" 'relightlab gate record --dataset {comparison.dataset} --reason \"...\"'"
        )
    return lines


def _change_lines(word: str, changes: Sequence[Change]) -> list[str]:
    lines = [f"  {word}: {_words(change)}" for change in changes[:SHOWN]]
    left = len(changes) - SHOWN
    return [*lines, f"  {word}: {left} more, all with --json"] if left > 0 else lines


def _words(change: Change) -> str:
    if change.new is None:
        return f"{change.cell}: {change.old:.6g} -> not measured"
    return f"{change.cell}: {change.old:.6g} -> {change.new:.6g} ({100 * change.relative:+.4g}%)"


def _lines_before_recording(measured: GateMeasurement, folder: Path) -> list[str]:
    """Return what replaces the earlier record."""
    from evaluation.gate_baseline import read_baseline
    from evaluation.regression_gate import compare
    from shading_model.errors import RelightlabError

    try:
        earlier = read_baseline(measured.dataset, folder)
        comparison = compare(earlier, measured)
    except RelightlabError as error:
        return [f"{measured.dataset}: the earlier record is replaced unseen, {error}"]
    was = f"the record of {earlier.date} ({earlier.reason})"
    counts = f"{len(comparison.worse)} worse, {len(comparison.better)} better"
    return [
        f"{measured.dataset}: {counts} than {was}, of {comparison.compared} errors",
        *_change_lines("worse", comparison.worse),
        *_change_lines("better", comparison.better),
    ]
