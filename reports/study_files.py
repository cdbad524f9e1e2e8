"""The files that an analysis leaves: results, tables, figures, and the report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from datasets.atomic import atomic_path
from reports.content import Plot, Report, Table
from reports.html_renderer import write_html
from reports.paper_table3 import table3
from reports.pdf_renderer import write_pdf
from reports.result_files import write_csv, write_json
from reports.study_report import PAGE, PRINTED, study_report
from reports.style import print_svg

MARK_COLUMN = "mark"
"""In every CSV file: empty for real answers, else what they are."""


def write_study_files(folder: Path, document: Mapping[str, Any], json: Path | None) -> list[Path]:
    """Write everything an analysis is asked for.

    Parameters
    ----------
    folder : Path
        Gets ``study.json``, ``rates.csv``, ``models.csv``, ``table3.csv`` where there is one,
        ``figures/*.svg`` and ``report/``.
    document : mapping
        See `reports.study_results`.
    json : Path or None
        Where to write the results a second time.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    RelightlabError
        If a file cannot be written, or a part lacks the mark of its data.
    """
    report = study_report(document)
    results = [folder / "study.json", *([json] if json else [])]
    for path in results:
        write_json(path, document)
    tables = list(_write_tables(folder, document))
    figures = list(_write_figures(folder / "figures", report))
    return [*results, *tables, *figures, *_write_report(folder / "report", report)]


def _write_report(folder: Path, report: Report) -> tuple[Path, Path]:
    page, printed = folder / PAGE, folder / PRINTED
    write_html(page, report)
    write_pdf(printed, report)
    return page, printed


def _write_tables(folder: Path, document: Mapping[str, Any]) -> Iterator[Path]:
    parts: dict[str, Sequence[Mapping[str, Any]]] = {
        name: document[name] for name in ("rates", "models", "exclusions", "tests")
    }
    if document["table3"]:
        parts["table3"] = list(table_rows(table3(document)))
    for name, rows in parts.items():
        if rows:
            path = folder / f"{name}.csv"
            write_csv(path, [{MARK_COLUMN: document["mark"], **row} for row in rows])
            yield path


def table_rows(table: Table) -> Iterator[dict[str, str]]:
    """Yield the rows of a table with two lines of heads, its cells under joined heads.

    Parameters
    ----------
    table : Table
        As `reports.study_tables.table3` makes it.

    Yields
    ------
    dict
        A cell's second line is in a column of its own, which ends in ``, note``.
    """
    above = [cell.text for cell in table.head[0] for _ in range(cell.columns)]
    below = [table.head[0][0].text, *(cell.text for cell in table.head[1])]
    names = [above[0], *(f"{a}, {b}" for a, b in zip(above[1:], below[1:], strict=True))]
    for group in table.groups:
        for row in group.rows:
            found: dict[str, str] = {}
            for name, cell in zip(names, row, strict=True):
                found |= {name: cell.text, f"{name}, note": cell.note}
            del found[f"{names[0]}, note"]
            yield found


def _write_figures(folder: Path, report: Report) -> Iterator[Path]:
    plots = (b for section in report.sections for b in section.blocks if isinstance(b, Plot))
    for plot in plots:
        path = folder / f"{plot.figure.identifier}.svg"
        with atomic_path(path) as temporary:
            temporary.write_text(print_svg(plot.figure.svg) + "\n", encoding="utf-8")
        yield path
