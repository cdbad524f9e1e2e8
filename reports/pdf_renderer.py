"""A report as a typeset, tagged PDF, through the typst wheel and fonts that wheels ship.

Typst compiles ``typst/report.typ``, which reads the report as JSON. Texts stay data on the way:
nothing of a report is read as typst markup, but the equations, which are our own.
"""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import typst

from datasets.atomic import atomic_path
from reports.content import Report, kind
from reports.prose import spans
from reports.rows_behind import Rows
from reports.style import print_svg

TEMPLATE, CONTENT = "report.typ", "report.json"
STAMPED = datetime(2019, 1, 1, tzinfo=UTC)
"""The date in every PDF, the year of the paper: a clock would make equal reports differ."""
STANDARD: Final = "ua-1"
"""PDF/UA-1: tagged headings, tables, captions and alternative texts, or it does not compile."""
PROSE = {
    *("prose text", "equation text", "stamp text", "table caption", "definitions items"),
    *("panelfigure caption", "plotfigure caption", "panel caption", "scale meaning"),
}
"""Kind and field of the texts that carry the marks of prose."""
SCREEN_ONLY = {"source", "mathml"}


def write_pdf(path: str | os.PathLike[str], report: Report) -> None:
    """Write a report as a PDF file.

    The same report gives the same bytes: no clock, no chance, no font of the machine.

    Parameters
    ----------
    path : path
        Written whole or not at all.
    report : Report

    Raises
    ------
    RelightlabError
        If the file cannot be written.
    """
    with atomic_path(path) as temporary:
        temporary.write_bytes(pdf_bytes(report))


def pdf_bytes(report: Report) -> bytes:
    """Return a report as a PDF file's content.

    Parameters
    ----------
    report : Report

    Returns
    -------
    bytes
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        content = plain(report, _Pictures(folder).keep)
        content["date"] = [STAMPED.year, STAMPED.month, STAMPED.day]
        (folder / CONTENT).write_text(json.dumps(content, ensure_ascii=False), encoding="utf-8")
        template = files("reports").joinpath("typst", TEMPLATE).read_text(encoding="utf-8")
        (folder / TEMPLATE).write_text(template, encoding="utf-8")
        return _compiled(folder)


def _compiled(folder: Path) -> bytes:
    compiler = typst.Compiler(
        root=str(folder),
        font_paths=[str(Path(mpl.get_data_path()) / "fonts" / "ttf")],
        ignore_system_fonts=True,
    )
    compiled = compiler.compile(
        str(folder / TEMPLATE), format="pdf", pdf_standards=[STANDARD], timestamp=STAMPED
    )
    if not isinstance(compiled, bytes):
        raise TypeError("expected one PDF of typst")
    return compiled


class _Pictures:
    """Files of pictures in a folder, named by their content."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def keep(self, content: bytes, suffix: str) -> str:
        name = hashlib.sha256(content).hexdigest()[:24] + suffix
        (self.folder / name).write_bytes(content)
        return name


def plain(value: Any, keep: Callable[[bytes, str], str]) -> Any:
    """Return a part of a report as JSON values: records as objects with their ``kind``.

    Parameters
    ----------
    value : object
        Any type of `reports.content` or `reports.figures`, or a tuple of them.
    keep : callable
        Takes the content and suffix of a picture, returns the name to find it by.

    Returns
    -------
    dict, list, str, number, bool or None
        Prose is cut into spans; pictures are names.

    Examples
    --------
    >>> from reports.content import Prose
    >>> plain(Prose("by `k`"), lambda content, suffix: "")
    {'kind': 'prose', 'text': [['text', 'by '], ['code', 'k']], 'role': ''}
    """
    if isinstance(value, tuple):
        return [plain(part, keep) for part in value]
    if isinstance(value, bytes):
        return keep(value, ".jpg")
    if not is_dataclass(value):
        return value
    word = kind(value)
    found: dict[str, Any] = {"kind": word}
    for one in fields(value):
        if one.name not in SCREEN_ONLY:
            found[one.name] = _field(f"{word} {one.name}", getattr(value, one.name), keep)
    if isinstance(value, Rows):
        found["sentence"] = _marked(value.sentence)
    return found


def _field(name: str, part: Any, keep: Callable[[bytes, str], str]) -> Any:
    if name in PROSE:
        return _marked(part)
    if name == "plotfigure svg":
        return keep(print_svg(part).encode(), ".svg")
    return plain(part, keep)


def _marked(part: Any) -> Any:
    if isinstance(part, str):
        return [list(span) for span in spans(part)]
    return [[term, _marked(text)] for term, text in part]
