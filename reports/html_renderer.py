"""A report as one HTML file that needs nothing else, and no network."""

from __future__ import annotations

import base64
import hashlib
import os
from importlib.resources import files

from jinja2 import Environment, PackageLoader, StrictUndefined

from datasets.atomic import atomic_path
from reports.content import Report, kind
from reports.prose import spans

TEMPLATE, SCRIPT = "report.html.j2", "sort.js"


def write_html(path: str | os.PathLike[str], report: Report) -> None:
    """Write a report as an HTML file.

    The same report gives the same bytes.

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
        temporary.write_text(html_text(report), encoding="utf-8")


def html_text(report: Report) -> str:
    """Return a report as HTML.

    The only script is the one that sorts tables; its hash is in the page's own security policy,
    under which a browser runs no other and loads nothing.

    Parameters
    ----------
    report : Report

    Returns
    -------
    str
    """
    script = files("reports").joinpath("templates", SCRIPT).read_text(encoding="utf-8").strip()
    return (
        _environment()
        .get_template(TEMPLATE)
        .render(report=report, script=script, script_hash=_script_hash(script))
    )


def _script_hash(script: str) -> str:
    digest = hashlib.sha256(script.encode()).digest()
    return "sha256-" + base64.b64encode(digest).decode("ascii")


def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"spans": spans, "kind": kind}
    return environment
