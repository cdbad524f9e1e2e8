"""Running SIRFS on a dataset from the command line: the document of its errors, and its lines."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from evaluation.experiment import Experiment
from evaluation.grid_run import DEFAULT_OPTIONS, RunOptions
from evaluation.grid_status import grid_summary
from evaluation.provenance import provenance_of
from evaluation.row_store import ROWS, RowStore
from evaluation.sirfs.metrics import ERROR_NAMES
from evaluation.sirfs_fits import SirfsFits, light_model, priors_in_use
from evaluation.sirfs_grid import (
    NAME,
    VERSION,
    SirfsContext,
    SirfsTable,
    run_sirfs,
    sirfs_experiment,
)
from reports.console import progress, say
from reports.table1_run import Table1Run, Table1Source

BOTH = "both"
TITLE = "SIRFS: errors of its fits"
COLUMNS = (
    *("object", "setting", "channels"),
    *("Z-MAE", "N-MAE", "s-MSE", "r-MSE", "rs-MSE", "L-MSE", "mean"),
    *("loss", "evaluations", "seconds"),
)
_DIGITS = {"z_mae": 3, "n_mae": 4, "final_loss": 3, "evaluations": 1, "seconds": 1}
_OTHER_DIGITS = 5


@dataclass(frozen=True)
class SirfsChoice:
    """What is to be fitted.

    Parameters
    ----------
    objects : tuple of str
        All by default.
    setting : str
        One of the dataset's, or ``both``: all.
    channels : {"color", "gray"}
    without : tuple of str
        Terms of the loss that are left out.
    """

    objects: tuple[str, ...] = ()
    setting: str = BOTH
    channels: str = "color"
    without: tuple[str, ...] = ()

    @property
    def settings(self) -> tuple[str, ...]:
        """The setting, none for all.

        Examples
        --------
        >>> SirfsChoice().settings, SirfsChoice(setting="natural").settings
        ((), ('natural',))
        """
        return () if self.setting == BOTH else (self.setting,)


def choice_experiment(
    source: Table1Source, choice: SirfsChoice, store: Path | None = None
) -> Experiment:
    """Return the grid of cells that `measure_sirfs_errors` measures.

    Parameters
    ----------
    source : Table1Source
    choice : SirfsChoice
    store : Path, optional

    Returns
    -------
    Experiment

    Raises
    ------
    RelightlabError
        For unknown names.
    """
    context = SirfsContext(source.dataset, SirfsFits.in_store(store, choice.without))
    return sirfs_experiment(context, choice.objects, choice.settings, [choice.channels])


def measure_sirfs_errors(
    source: Table1Source,
    choice: SirfsChoice = SirfsChoice(),
    *,
    store: Path | None = None,
    options: RunOptions = DEFAULT_OPTIONS,
) -> dict[str, Any]:
    """Fit SIRFS to the chosen photographs and return a document of its errors.

    Parameters
    ----------
    source : Table1Source
        Its lights play no part.
    choice : SirfsChoice
    store : Path, optional
        Folder that keeps rows and fits; what it holds is not measured again.
    options : RunOptions
        The numbers do not depend on them.

    Returns
    -------
    dict
        ``rows`` and ``summary`` as in `evaluation.sirfs_grid.SirfsTable`; ``missing``, the cells
        without a result, with the reasons; ``protocol``, ``provenance``.

    Raises
    ------
    RelightlabError
        For unknown names, fewer than one worker, or data or a store that cannot be used.
    """
    experiment = choice_experiment(source, choice, store)
    rows = None if store is None else RowStore(store / ROWS)
    if rows is not None:
        say(grid_summary(experiment, rows).sentence())
    started = time.monotonic()
    with progress("fitting") as report:
        table = run_sirfs(
            experiment.context,
            choice.objects,
            choice.settings,
            [choice.channels],
            store=rows,
            options=options,
            progress=report,
        )
    return _document(table, source, choice, time.monotonic() - started, options.workers)


def with_errors_of_fits(run: Table1Run, errors: Mapping[str, Any], store: Path) -> Table1Run:
    """Add to a measured Table 1 the errors of the fits that it rests on, for the report.

    The fits are best measured first, so that the seconds of a row are those of its fit.

    Parameters
    ----------
    run : Table1Run
        Not a quick one.
    errors : mapping
        Of `measure_sirfs_errors`, on the same source.
    store : Path
        Holds the fits.

    Returns
    -------
    Table1Run
        Its document has ``sirfs_rows`` and ``sirfs_summary``, see `measure_sirfs_errors`; its
        seconds are those of both.
    """
    origin = run.document["provenance"]
    seconds = round(origin["seconds"] + errors["provenance"]["seconds"], 1)
    parts = {
        "provenance": {**origin, "seconds": seconds},
        "sirfs_rows": errors["rows"],
        "sirfs_summary": errors["summary"],
    }
    return replace(run, document=run.document | parts, fits=SirfsFits.in_store(store))


def sirfs_lines(document: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the lines of the printed table: one for each fit, then one for each set of objects.

    Parameters
    ----------
    document : mapping
        Of `measure_sirfs_errors`.

    Returns
    -------
    list of tuples of str
        In the order of `COLUMNS`; an empty tuple before the sets.
    """
    lines = [_line(row, row["object"]) for row in document["rows"]]
    sets = [_line(row, f"{row['object']} ({row['objects']})") for row in document["summary"]]
    return [*lines, (), *sets] if lines else []


def sirfs_title(document: Mapping[str, Any]) -> str:
    """Return the title of the printed table, which says if fits are missing or terms left out.

    Parameters
    ----------
    document : mapping

    Returns
    -------
    str

    Examples
    --------
    >>> sirfs_title({"missing": [{}], "protocol": {"without": ["slant"]}})
    'INCOMPLETE, 1 cell missing. SIRFS: errors of its fits, without slant'
    """
    without = document["protocol"]["without"]
    title = f"{TITLE}, without {', '.join(without)}" if without else TITLE
    missing = len(document["missing"])
    if not missing:
        return title
    return f"INCOMPLETE, {missing} cell{'s' if missing > 1 else ''} missing. {title}"


def _line(row: Mapping[str, Any], name: str) -> tuple[str, ...]:
    numbers = (*ERROR_NAMES, "mean", "final_loss", "evaluations", "seconds")
    return (
        *(name, row["setting"], row["channels"]),
        *(_number(row[key], _DIGITS.get(key, _OTHER_DIGITS)) for key in numbers),
    )


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _document(
    table: SirfsTable, source: Table1Source, choice: SirfsChoice, seconds: float, workers: int
) -> dict[str, Any]:
    settings: Sequence[str] = choice.settings or source.dataset.settings
    provenance = provenance_of(
        protocol=f"{NAME} {VERSION}",
        dataset=source.dataset.name,
        data_hash=source.dataset.fingerprint(),
        seeds={},
        seconds=seconds,
        workers=workers,
        cells_done=len(table.rows),
        cells_missing=len(table.missing),
    )
    return {
        "protocol": {
            "name": NAME,
            "version": VERSION,
            "without": list(choice.without),
            "light_models": {setting: light_model(setting) for setting in settings},
            "priors": priors_in_use()[1],
        },
        "rows": list(table.rows),
        "summary": list(table.summary),
        "missing": list(table.missing),
        "provenance": provenance.document(),
    }
