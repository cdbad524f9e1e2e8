"""Table 1 as text: every entry with the published value beside it, open entries in sight."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import typer

COLUMNS = ("setting", "method", "details", "weights", "IMSE", "relative", "published")
TITLE = "Table 1: re-rendering error (published: on MIT-Berkeley, under other lights)"
OPEN = "open: needs SIRFS"
INCOMPLETE = 3
"""Exit code of a command whose table lacks cells."""
SHOWN_MISSING = 10
DETAILS = {
    "default": "(a) Retinex",
    "sirfs-shading": "(b) SIRFS shading",
    "gt-shading": "(c) true shading",
    "own": "its own",
}

Row = Mapping[str, Any]


def table1_lines(document: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the lines of the printed table, one for each computed or open entry.

    Parameters
    ----------
    document : mapping
        Of `evaluation.table1_results.table1_document`.

    Returns
    -------
    list of tuples of str
        In the order of `COLUMNS`; an empty tuple between settings.

    Examples
    --------
    >>> entry = {"setting": "natural", "method": "ours", "detail_source": "default",
    ...          "weights": "oracle"}
    >>> table1_lines({"rows": [{**entry, "imse": 0.005, "relative_imse": 0.08}], "baselines": [],
    ...               "published": [{**entry, "imse": 0.0329}], "open": []})
    [('natural', 'ours', '(a) Retinex', 'oracle', '0.00500', '0.080', '0.0329')]
    """
    settings = list(dict.fromkeys(row["setting"] for row in document["rows"]))
    lines: list[tuple[str, ...]] = []
    for setting in settings:
        lines += [()] if lines else []
        lines += _setting_lines(document, setting)
    return lines


def table1_title(document: Mapping[str, Any]) -> str:
    """Return the title of the printed table, which says if cells are missing.

    Parameters
    ----------
    document : mapping
        Of `evaluation.table1_results.table1_document`.

    Returns
    -------
    str

    Examples
    --------
    >>> table1_title({"missing": [{"object": "sun", "reason": "not measured"}]})[:27]
    'INCOMPLETE, 1 cell missing.'
    """
    missing = len(document["missing"])
    if not missing:
        return TITLE
    return f"INCOMPLETE, {missing} cell{'s' if missing > 1 else ''} missing. {TITLE}"


def summary_lines(document: Mapping[str, Any]) -> list[str]:
    """Return what a run came to, in five lines.

    Parameters
    ----------
    document : mapping
        Of `evaluation.table1_results.table1_document`.

    Returns
    -------
    list of str
    """
    origin, protocol = document["provenance"], document["protocol"]
    objects = len({row["object"] for row in document["objects"]})
    measured = (
        f"{origin['dataset']}: {objects} objects under {protocol['lights']} lights, protocol"
        f" {protocol['name']} version {protocol['version']}, {protocol['channels']}"
    )
    counted = (
        f"{origin['cells_done']} cells done, {origin['cells_missing']} missing;"
        f" {len(document['open'])} table entries open (they need SIRFS)"
    )
    came_from = (
        f"{origin['seconds']:.1f} s, workers: {origin['workers']},"
        f" code {origin['commit'][:12]}, data {origin['data_hash'][:12]}"
    )
    settings = [_comparison(document, setting) for setting in ("natural", "laboratory")]
    return [measured, *settings, counted, came_from]


def stop_if_incomplete(document: Mapping[str, Any]) -> None:
    """End the command with exit code 3 if cells of the table are missing, and name them.

    Parameters
    ----------
    document : mapping
        Of `evaluation.table1_results.table1_document`.

    Raises
    ------
    typer.Exit
        With code `INCOMPLETE`.
    """
    missing = document["missing"]
    if not missing:
        return
    typer.echo(f"INCOMPLETE: {len(missing)} cells are missing from the table", err=True)
    for cell in missing[:SHOWN_MISSING]:
        words = [value for axis, value in cell.items() if axis != "reason"]
        typer.echo(f"  {' '.join(words)}: {cell['reason']}", err=True)
    if len(missing) > SHOWN_MISSING:
        typer.echo(f"  and {len(missing) - SHOWN_MISSING} more, all in the JSON", err=True)
    raise typer.Exit(INCOMPLETE)


def _setting_lines(document: Mapping[str, Any], setting: str) -> list[tuple[str, ...]]:
    flat = [row for row in document["baselines"] if row["setting"] == setting]
    lines = [_line(row, ("flat shape, Retinex", "constant"), "-") for row in flat]
    lines += _open_lines(document, setting, "sirfs")
    for source, words in DETAILS.items():
        lines += [
            _line(row, (words, row["weights"]), _published(document, row))
            for row in document["rows"]
            if (row["setting"], row["detail_source"]) == (setting, source)
        ]
        if source == "sirfs-shading":
            lines += _open_lines(document, setting, "ours")
    return lines


def _line(row: Row, words: tuple[str, str], published: str) -> tuple[str, ...]:
    numbers = _number(row["imse"], 5), _number(row["relative_imse"], 3)
    return (row["setting"], row["method"], *words, *numbers, published)


def _open_lines(document: Mapping[str, Any], setting: str, method: str) -> list[tuple[str, ...]]:
    still_open = {(e["setting"], e["method"], e["detail_source"]) for e in document["open"]}
    return [
        (setting, method.upper(), "-", "-", OPEN, "-", _number(entry["imse"], 4))
        if method == "sirfs"
        else (
            *(setting, method, DETAILS[entry["detail_source"]], entry["weights"]),
            *(OPEN, "-", _number(entry["imse"], 4)),
        )
        for entry in document["published"]
        if entry["setting"] == setting
        and entry["method"] == method
        and (setting, method, entry["detail_source"]) in still_open
    ]


def _published(document: Mapping[str, Any], row: Row) -> str:
    keys = ("setting", "method", "detail_source", "weights")
    for entry in document["published"]:
        if all(entry[key] == row[key] for key in keys):
            return _number(entry["imse"], 4)
    return "-"


def _comparison(document: Mapping[str, Any], setting: str) -> str:
    found = {
        row["weights"]: f"{row['weights']} {_number(row['imse'], 5)}"
        f" ({_published(document, row)} published)"
        for row in document["rows"]
        if (row["setting"], row["method"], row["detail_source"]) == (setting, "ours", "default")
    }
    shown = [found[rule] for rule in ("regression", "oracle") if rule in found]
    return f"{setting}: IMSE {', '.join(shown) or 'not measured'}"


def _number(value: float | None, decimals: int) -> str:
    return "-" if value is None else f"{value:.{decimals}f}"
